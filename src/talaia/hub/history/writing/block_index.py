"""What is stored, and how a group of batches becomes one commit.

A batch goes into the journal as it came. When a channel has a block's worth of samples in memory,
they are made a block after the commit, while nobody waits; the next commit writes it, too. When no
channel needs a journal row any more, the row is deleted. Each channel records up to which row it
is done in the same transaction, so after a crash at any point the journal and the saved tails give
back exactly what was in memory.

Only the writing thread comes here. The file is longer than 300 lines because a group's plan, its
commit and its reading back after a crash must agree on every column: they are read together.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from sqlalchemy import delete, func, select

from talaia.hub.history.blocks.block import concatenate_samples, decode_block
from talaia.hub.history.blocks.journal import part_of, write_row
from talaia.hub.history.blocks.journal_rows import JournalRows
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.sensors.plain_rows import Recent
from talaia.hub.history.writing.bulk_writes import insert_rows
from talaia.hub.history.writing.channel_ids import Names, write_counters
from talaia.hub.history.writing.chunks import Chunk
from talaia.hub.history.writing.compaction import (
    Newest,
    Saved,
    Sealed,
    read_newest,
    save_tail,
    seal_tail,
    write_tails,
)
from talaia.hub.history.writing.gap_rows import gap_row, write_gap
from talaia.hub.history.writing.journal_replay import (
    JournalReader,
    JournalTargets,
    replay_journal,
)
from talaia.hub.history.writing.merged_rows import RowMerger
from talaia.hub.history.writing.open_blocks import Tails
from talaia.hub.history.writing.retention import delete_blocks
from talaia.hub.history.writing.seal_choice import SealChoice
from talaia.hub.history.writing.site_jobs import adopt_blocks, count_outside, forget_site
from talaia.hub.history.writing.stored_runs import StoredRuns
from talaia.hub.history.writing.writer_jobs import (
    Adopt,
    AdoptRuns,
    Append,
    Below,
    Describe,
    Drop,
    Forget,
    GapJob,
    ReadRuns,
    Rename,
    SealSite,
    Show,
    checked_columns,
)
from talaia.hub.store import history_tables as tables
from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection, Engine

    from talaia.clock import Clock
    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.history.writing.merged_rows import MergedRow
    from talaia.hub.history.writing.retention import Doomed
    from talaia.hub.history.writing.site_jobs import Adopted, Forgotten
    from talaia.hub.history.writing.writer_jobs import Job

__all__ = ["BlockIndex"]

_LOG = logging.getLogger(__name__)


class _Plan(NamedTuple):
    """What of the tails and of the journal the next commit writes anew."""

    seals: list[Sealed]
    saves: list[Saved]
    merged: MergedRow | None


class _Draft:
    """What the next commit writes."""

    def __init__(self) -> None:
        # Of the journal: every batch as it came.
        self.rows: list[dict[str, Any]] = []
        # A row in the place of several that are there.
        self.merged: MergedRow | None = None
        # What is lost for good.
        self.gaps: list[dict[str, Any]] = []
        # The samples of `rows`, for the tails once they are committed.
        self.chunks: list[Chunk] = []
        # Channels whose tails become blocks, and those that are only saved as they are.
        self.seals: list[Sealed] = []
        self.saves: list[Saved] = []
        # Readings that the views show.
        self.recent: list[dict[str, Any]] = []
        # Blocks that are dropped.
        self.doomed: list[Doomed] = []
        # The last rollup rows of each channel that is sealed, as they are after it.
        self.newest: dict[int, Newest] = {}
        # By boot, where the ranges begin that stand in the database after it.
        self.ranges: dict[int, set[int]] = {}
        # Something got a number or another name, which has to be written though no row is.
        self.named = False
        # What came from another server, and sites that have gone to one.
        self.adopted: list[Adopted] = []
        self.forgotten: list[Forgotten] = []
        # Ranges are written though no row of the journal goes.
        self.writes_runs = False
        # In `rows`; how much is sealed next goes by it.
        self.samples = 0

    def __bool__(self) -> bool:
        return bool(self.rows or self.gaps or self.recent or self.named or self.doomed)

    def count_bytes(self) -> int:
        rows = [*self.rows, self.merged.row] if self.merged is not None else self.rows
        bodies = sum(len(row["body"]) for row in rows)
        return bodies + sum(seal.count_bytes() for seal in self.seals)


class BlockIndex:
    """The writing side's picture of the database.

    Attributes:
        names: numbers of channels and boots.
        tails: what is not in blocks; readers look at it too.
        run: how often all was loaded; from one time to the next no block's number is given twice.
        written: bytes of the last commit's bodies.

    """

    def __init__(self, engine: Engine, clock: Clock, limits: HistoryLimits) -> None:
        """Use ``engine`` to write; `load_index` comes before anything else."""
        self._engine = engine
        self._clock = clock
        self._limits = limits
        self.names = Names()
        self.tails = Tails(1, 0, limits.recent)
        self.run = 0
        self._recent = Recent()
        # The last rollup rows of each channel, to which its next block adds.
        self._newest: dict[int, Newest] = {}
        # What of each boot is stored or lost.
        self._runs = StoredRuns()
        self._next_row = 1
        # From this number on readers take no block: their samples are in the tails still.
        self._next_block = 1
        self._journal = JournalRows()
        # A server packs rows by itself.
        self._merges_rows = not dialect_of(engine).is_server
        self._merger = RowMerger()
        # What of the tails the next commit writes; compressed while nobody waits.
        self._plan: _Plan | None = None
        # Chooses what is planned.
        self._choice = SealChoice(limits)
        self.written = 0

    def load_index(self) -> None:
        """Read what is stored; also after a commit of which nobody knows whether it happened."""
        names = Names()
        self._newest, self._runs = {}, StoredRuns()
        self._journal = JournalRows()
        self._merger = RowMerger()
        self._plan = None
        with self._engine.begin() as connection:
            names.load_names(connection)
            self._runs.load_runs(connection)
            last_block = connection.scalar(select(func.max(tables.body.c.block_id))) or 0
            # The last ones may have been dropped.
            self._next_block = max(last_block + 1, names.next_of("block"))
            done = max(names.saved_row.values(), default=0)
            tails = Tails(self._next_block, done, self._limits.recent)
            for row in connection.execute(select(tables.tail)):
                # One damaged row must not keep the hub from starting.
                try:
                    samples = decode_block(row.body)
                except HistoryError as error:
                    _LOG.error("samples of channel %d are lost: %s", row.channel_id, error)
                    continue
                tails.restore_tail(row.channel_id, samples)
                ids = np.full(samples.time_us.size, row.channel_id, np.int64)
                self._recent.add_chunks([Chunk(0, ids, *samples)])
            self._next_row = max(done + 1, names.next_of("row"))
            reader = JournalReader(names.all_catalogues(), names.saved_row)
            targets = JournalTargets(tails, self._runs, self._recent, self._journal)
            last = replay_journal(connection, reader, targets)
            self._next_row = max(self._next_row, last + 1)
        # Readers see the old state or the new one, never half of it.
        self.names, self.tails, self.run = names, tails, self.run + 1

    def commit_jobs(self, jobs: Sequence[Job]) -> list[HistoryError | int]:
        """Commit a group of jobs and give each one's answer; only `Below`'s number means anything.

        Raises:
            SQLAlchemyError: nothing is known of this commit; `load_index` before anything else.

        """
        draft = _Draft()
        answers = [self._answer_job(job, draft) for job in jobs]
        if draft:
            if self._plan is not None:
                draft.seals, draft.saves, draft.merged = self._plan
            with self._engine.begin() as connection:
                last_gone = self._write_draft(connection, draft)
            self._apply_draft(draft, last_gone)
            self.written = draft.count_bytes()
        return answers

    def plan_writes(self) -> None:
        """Choose what of the tails the next commit writes, and compress it.

        It is little at a time, so that no commit is slow, and comes after a commit was answered,
        so that nobody waits for it who does not send at once.
        """
        if self._plan is not None:
            return
        tails = self.tails
        # Before batches are dealt out, perhaps.
        merged = self._merger.next_row(tails.deals) if self._merges_rows else None
        chosen, saved, enough = self._choice.choose_channels(tails, self._journal)
        if chosen or saved or merged:
            saves = [
                save_tail(
                    channel, tails.dealt_row, concatenate_samples(tails.all_tails()[channel].parts)
                )
                for channel in saved
            ]
            seals = [self._seal_tail(channel, enough) for channel in chosen]
            self._plan = _Plan(seals, saves, merged)

    def _answer_job(self, job: Job, draft: _Draft) -> HistoryError | int:
        try:
            match job:
                case Append():
                    self._add_batch(job, draft)
                case GapJob():
                    self._take_gap(job, draft)
                case Below():
                    boot = self.names.boots.get((job.site, job.boot), 0)
                    return self._runs.settled_below(boot)
                case Describe():
                    now_us = self._clock.wall_ns() // 1_000
                    self.names.channel_catalogue(job.site, job.addresses, now_us)
                    draft.named = True
                case Rename():
                    self.names.rename_channels(job.site, job.moves)
                    draft.named = True
                case Drop():
                    draft.doomed += job.doomed
                case Show():
                    draft.recent = self._recent.newest_rows()
                case _:
                    return self._answer_move(job, draft)
        except (HistoryError, UnicodeEncodeError) as error:
            # One batch that cannot be kept must not take the others of its commit with it.
            if isinstance(error, HistoryError):
                return error
            return HistoryError(f"a text is not Unicode: {error}")
        return 0

    def _answer_move(
        self, job: SealSite | ReadRuns | Adopt | AdoptRuns | Forget, draft: _Draft
    ) -> int:
        """Answer a job of a site's move to another server, or from one."""
        # What is planned is written with it, and the next plan is made after it.
        draft.named = True
        match job:
            case SealSite():
                mine = self.names.of_site(job.site)
                # Those that wait in batches are dealt out before the next plan.
                self._choice.seal_soon(mine)
                return count_outside(self.tails, mine, draft.chunks)
            case ReadRuns():
                for (site, boot), number in self.names.boots.items():
                    if site == job.site:
                        job.found[boot] = list(self._runs.stored_of(number))
            case Adopt():
                now_us = self._clock.wall_ns() // 1_000
                adopted = adopt_blocks(job, self.names, self._next_block, now_us)
                self._next_block += len(adopted.blocks)
                draft.adopted.append(adopted)
            case AdoptRuns():
                for boot, ranges in job.runs.items():
                    number = self.names.boot_id(job.site, boot)
                    for first, past in ranges:
                        self._runs.add_stored(number, first, past)
                draft.writes_runs = True
            case Forget():
                draft.forgotten.append(forget_site(job, self.names))
        return 0

    def _add_batch(self, job: Append, draft: _Draft) -> None:
        columns = checked_columns(job)
        # Packing may refuse, so it comes before anything is remembered.
        boot = self.names.boot_id(job.site, job.boot)
        now_us = self._clock.wall_ns() // 1_000
        catalogue = self.names.channel_catalogue(job.site, job.addresses, now_us)
        stored = self._runs.stored_of(boot)
        parts = [
            (first, part_of(columns, first - job.first, past - job.first))
            for first, past in stored.missing_ranges(job.first, job.first + len(columns))
        ]
        packed = [(first, part, write_row(part)) for first, part in parts]
        for first, part, body in packed:
            row = self._next_row
            self._next_row += 1
            draft.rows.append(
                {
                    "id": row,
                    "boot_id": boot,
                    "catalogue_id": catalogue.id,
                    "first_seq": first,
                    "samples": len(part),
                    "body": body,
                }
            )
            ids = catalogue.channels[part.channel]
            draft.chunks.append(Chunk(row, ids, part.time_us, part.value, part.texts))
            draft.samples += len(part)
            # At once, so that another batch of this commit is cut by it too.
            self._runs.add_stored(boot, first, first + len(part))

    def _take_gap(self, job: GapJob, draft: _Draft) -> None:
        row = gap_row(job)
        boot = self.names.boot_id(job.site, job.boot)
        draft.gaps.append({"boot_id": boot, **row})
        self._runs.settled_of(boot).add_range(job.first, job.last + 1)

    def _seal_tail(self, channel: int, block: int) -> Sealed:
        tail = self.tails.all_tails()[channel]
        sealed = seal_tail(
            channel,
            self.tails.dealt_row,
            first_block=self._next_block,
            longest_us=self.names.longest_us[channel],
            samples=concatenate_samples(tail.parts),
            block=block,
            was_saved=tail.saved,
        )
        self._next_block += len(sealed.blocks)
        # Before the commit: a reader that looks back too far loses nothing.
        self.names.longest_us[channel] = sealed.longest_us
        return sealed

    def _write_draft(self, connection: Connection, draft: _Draft) -> int:
        self.names.write_new(connection)
        insert_rows(connection, tables.hot, draft.rows)
        for row in draft.gaps:
            write_gap(connection, row)
        if draft.recent:
            self._recent.write_rows(connection, draft.recent)
        if draft.doomed:
            delete_blocks(connection, draft.doomed)
            write_counters(connection, {"block": self._next_block})
            # The rollup rows that were known to be the last may be gone.
            for block in draft.doomed:
                self._newest.pop(block.channel, None)
        for adopted in draft.adopted:
            adopted.write_rows(connection)
            for channel in adopted.channels:
                self._newest.pop(channel, None)
        for sealed in draft.seals:
            channel = sealed.channel
            newest = self._newest.get(channel)
            if newest is None:
                newest = read_newest(connection, channel)
            draft.newest[channel] = sealed.write_blocks(connection, newest)
        write_tails(connection, draft.saves)
        if draft.merged is not None:
            draft.merged.write_row(connection)
        if draft.writes_runs:
            draft.ranges = self._runs.write_changed(connection)
        if draft.forgotten:
            self._forget_rows(connection, draft.forgotten)
        return self._delete_done(connection, draft)

    def _forget_rows(self, connection: Connection, forgotten: Sequence[Forgotten]) -> None:
        counters = {**self.names.counters, "block": self._next_block, "row": self._next_row}
        write_counters(connection, counters)
        for site in forgotten:
            site.delete_rows(connection)

    def _delete_done(self, connection: Connection, draft: _Draft) -> int:
        """Delete journal rows that nobody needs; a range of numbers stands for them then."""
        most = self._limits.delete + 4 * len(draft.rows)
        count = min(most, self._journal.count_below(self.tails.needed_row()))
        if count and (count == most or self._journal.samples > self._limits.journal // 8):
            last = self._journal.last_of_oldest(count)
            draft.ranges = self._runs.write_changed(connection)
            connection.execute(delete(tables.hot).where(tables.hot.c.id <= last))
            return last
        return 0

    def _apply_draft(self, draft: _Draft, last_gone: int) -> None:
        self._plan = None
        self._choice.samples += draft.samples
        self._choice.rows += len(draft.rows)
        self.names.clear_new()
        self._newest.update(draft.newest)
        self._runs.mark_written(draft.ranges)
        for sealed in draft.seals:
            self.names.saved_row[sealed.channel] = sealed.row
        if draft.seals:
            self.tails.forget_sealed([sealed.channel for sealed in draft.seals], self._next_block)
        for saved in draft.saves:
            self.names.saved_row[saved.channel] = saved.row
        if draft.adopted:
            # From here on readers find them.
            self.tails.forget_sealed([], self._next_block)
        for site in draft.forgotten:
            self.names.forget_site(site.site)
            self._runs.forget_boots(site.boots)
            self._recent.forget_channels(site.channels)
            for channel in site.channels:
                self._newest.pop(channel, None)
        if draft.saves:
            self.tails.mark_saved([saved.channel for saved in draft.saves])
        if draft.merged is not None:
            self._journal.merge_rows(draft.merged.first, draft.merged.row["id"])
        if last_gone:
            self._runs.clear_changed()
            self._journal.forget_rows(last_gone)
        self.tails.add_chunks(draft.chunks)
        self._recent.add_chunks(draft.chunks)
        for row in draft.rows:
            self._journal.append_row(row["id"], row["samples"])
        if self._merges_rows:
            self._merger.add_rows(draft.rows, self.tails.deals)
