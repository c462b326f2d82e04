"""What the hub has not stored yet: segments on disk, bounded in bytes and age, trimmed by acks.

Guarantees: records come back in the order they went in; a record is gone only when it was
acknowledged or when a recorded gap tells of it; after a crash at any point what was written
before is there, less what the last seconds' power cut took. All calls block on the disk and
come from one thread.

Forcing every batch to disk (50 a second) would cost more than all the rest of the gateway and
wear out the SD cards robots run on. What the process has written survives its own death without
that; only a power cut needs it. So `sync_to_disk` is called once a second, and does nothing while
the hub keeps up: then there is nothing here that is not stored elsewhere. A segment that is full
while the hub is away is packed.

Long, because the order in which these parts are asked is the guarantee, and stands in one place.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.gateway.spool.disk_room import DiskRoom
from talaia.gateway.spool.files import SegmentHead, remove_file, set_aside
from talaia.gateway.spool.former_runs import newest_of_segment
from talaia.gateway.spool.gaps import DroppedSamples, SpoolGaps
from talaia.gateway.spool.memory_queue import MemoryQueue
from talaia.gateway.spool.opening import DAMAGED, open_folder
from talaia.gateway.spool.run_progress import RunProgress
from talaia.gateway.spool.segment import SampleRecord, pack_record
from talaia.gateway.spool.segment_list import SegmentList
from talaia.gateway.spool.segment_packer import pack_segment
from talaia.gateway.spool.segment_reader import (
    SegmentReader,
    SpoolPosition,
    StoredRecord,
    gap_in,
    gap_of,
)
from talaia.gateway.spool.segment_writer import SegmentWriter
from talaia.gateway.spool.sizes import USUAL
from talaia.wire.frames import SampleGap

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from talaia.gateway.spool.files import Segment
    from talaia.gateway.spool.former_runs import FormerNewest
    from talaia.gateway.spool.sizes import SpoolSizes

__all__ = ["SegmentHead", "Spool", "SpoolPosition", "StoredRecord"]

log = logging.getLogger(__name__)
# Words for people: the hub shows them beside the gap in the history.
FULL = "the gateway's disk space for unsent samples was full"
UNLEARNED = "the hub lost what it had stored, and the gateway had it no more"
OLD = "it waited in the gateway for longer than it is kept"
# A segment is closed at the latest after this part of the age at which it would be dropped.
TURNS = 24


class Spool:
    """See the module."""

    def __init__(
        self,
        *,
        folder: Path,
        head: SegmentHead,
        bound: int,
        age_s: float = float("inf"),
        spare: int = 0,
        now: Callable[[], float] = lambda: 0.0,
        wall_us: Callable[[], int] = lambda: 0,
        machine: str = "",
        sizes: SpoolSizes = USUAL,
    ) -> None:
        """Take up what an earlier run left and begin a segment of this boot.

        Args:
            folder: where the segments are.
            head: of this boot.
            bound: bytes that may wait; the oldest gives way.
            age_s: a segment that has waited for longer gives way too. Time in which no gateway
                runs does not count.
            spare: so much of the disk stays free for what matters more (STOP, commands).
            now: a clock that never jumps (s).
            wall_us: the wall clock (µs, UTC).
            machine: see `ProgressMark.machine`.
            sizes: of its files.

        """
        # Bytes, file sizes, and the age (s) beyond which what waits gives way.
        self._bound, self._sizes, self._age_s = bound, sizes, age_s
        # By boot: every sample below is stored at the hub for good.
        self._acked: dict[str, int] = {}
        # What of this boot was acknowledged and is no longer here, should the hub lose it.
        self._gone = DroppedSamples()
        # Up to which sample of this boot the last `sync_to_disk` came.
        self._synced_end = 0
        # What the disk does not take now; all of it newer than what is on disk.
        self._memory = MemoryQueue()
        self._room = DiskRoom(folder, spare)
        self._writer = SegmentWriter(self._room)
        # What is lost, until the hub has acknowledged past it.
        self._gaps = SpoolGaps(folder / "gaps.json")
        self._reader = SegmentReader(self._acked, self._gaps)
        # How far this run came, for the one that follows it.
        self._progress = RunProgress(
            folder / "mark.json",
            head.boot,
            gaps=self._gaps,
            acked=self._acked,
            now=now,
            began_us=wall_us(),
            machine=machine,
        )
        self.former = self._progress.former  # Read by whoever tells of the time between the runs.
        # On disk, oldest first; the last is the current one.
        self._segments = SegmentList(folder, open_folder(folder, self._gaps, self.former), now)
        self._head = head  # Of this boot; what every new segment begins with.
        self._current = (
            self._begin_segment()
        )  # The segment that is written to; it may not be on disk yet.

    # ── writing ──

    def _begin_segment(self) -> Segment:
        """Begin a segment; while the disk has no room for it, the file is not there yet."""
        segment = self._segments.add_new(self._head)
        self._current = segment
        self._writer.begin_segment()
        # While there is no room even for the head, the oldest gives way. A disk that fails
        # otherwise leaves the segment without a file, and records wait in memory.
        while not self._writer.open_file(segment) and self._room.full and self._drop_oldest(FULL):
            pass
        return segment

    def redescribe(self, head: SegmentHead) -> None:
        """Keep what comes from here on by another channel list, in a segment of its own."""
        # What waits in memory goes to disk behind the new head: each says its addresses itself.
        self._memory.name_channels(self._head.addresses)
        closed = self._current
        self._head = head
        self._begin_segment()
        # Gone already: reading it failed, and it was set aside.
        if closed not in self._segments:
            return
        # Nothing was written to it: an empty file would only be scanned at the next start.
        if closed.first < 0:
            self._segments.remove_segment(closed)
            remove_file(closed.path)
        else:
            self._pack_segment(closed)

    @property
    def kept(self) -> int:
        """How much is kept, on disk and (while the disk is full) in memory."""
        return self._segments.bytes + self._memory.bytes

    def append_record(self, record: SampleRecord) -> None:
        """Keep a record of this boot; see `append_records`."""
        self.append_records((record,))

    def append_records(self, records: Sequence[SampleRecord]) -> None:
        """Keep records of this boot that follow each other, by one write.

        Never raises for a full disk: the oldest gives way.
        """
        # Trimmed first: what the hub has stored must not count against the bound.
        self._trim_acknowledged()
        data = b"".join(map(pack_record, records))
        # Never the current segment, which is closed at a quarter of the bound.
        while self.kept + len(data) > self._bound and self._drop_oldest(FULL):
            pass
        # In order: what waits in memory comes first.
        while self._memory and self._place_records(
            pack_record(self._memory.oldest), (self._memory.oldest,)
        ):
            self._memory.pop_oldest()
        if self._memory or not self._place_records(data, records):
            for record in records:
                # What no longer fits there is the oldest; it is told as a gap.
                for lost in self._memory.add_record(record, self._sizes.memory):
                    self.record_loss(lost, FULL)
        # Counts what waits in memory as well: if this run dies, the next one tells of it as
        # missing.
        self._progress.save_progress(records[-1].end, max(record.to_us for record in records))

    def _place_records(self, data: bytes, records: Sequence[SampleRecord]) -> bool:
        # Asked before each try: `full` says afterwards whether dropping would make room at all.
        while not (self._room.has_room(len(data)) and self._write_records(data, records)):
            if not self._room.full or not self._drop_oldest(FULL):
                return False
        return True

    def _write_records(self, data: bytes, records: Sequence[SampleRecord]) -> bool:
        segment = self._current
        # Quarter of the bound: dropping the oldest must not mean dropping nearly all.
        largest = min(self._sizes.segment, max(self._bound // 4, len(data)))
        # So the oldest can be dropped for its age in small steps, however slowly it was filled.
        is_old = self._segments.waited_s(segment) > self._age_s / TURNS
        if segment.first >= 0 and (segment.size + len(data) > largest or is_old):
            closed, segment = segment, self._begin_segment()
            # Not the current one any more: nobody writes to it while it is packed.
            self._pack_segment(closed)
        # The disk did not take the file when the segment began; it is tried again with each record.
        if not self._writer.is_open and not self._writer.open_file(segment):
            return False
        if not self._writer.write_record(segment, data):
            return False
        # Only what is whole in the file is counted in.
        for record in records:
            segment.count_record(record)
        return True

    def _pack_segment(self, segment: Segment) -> None:
        """Write a closed segment anew, smaller, unless the hub has it anyway."""
        if segment.end > self._acked.get(segment.head.boot, 0) and segment in self._segments:
            pack_segment(segment)

    def _drop_oldest(self, why: str) -> bool:
        """Let the oldest segment give way; tell whether there was one besides the current."""
        # The current segment is open and takes the next record; it is never dropped.
        if len(self._segments) < 2:
            return False
        self._drop_segment(self._segments.oldest, why)
        return True

    def _drop_segment(self, segment: Segment, why: str) -> None:
        # What of it the hub has stored is not lost.
        first = max(segment.first, self._acked.get(segment.head.boot, 0))
        if first < segment.end:
            # The gap is on record before the file goes: a crash between leaves both, not neither.
            self._gaps.add_gap(gap_in(segment, first, why))
            self._gaps.write_gaps()
        self._remove_segment(segment)
        # Where the disk was too full for the gap, there is room now.
        self._gaps.write_gaps()

    def _remove_segment(self, segment: Segment) -> None:
        # Only of this boot: `rewind_acknowledged` is told nothing of former ones.
        if segment.head.boot == self._head.boot:
            self._gone.add_range(segment.first, segment.end, segment.from_us, segment.to_us)
        self._segments.remove_segment(segment)
        # A file that the disk does not give up is given out again by a later run: no harm.
        remove_file(segment.path)

    def record_loss(self, record: SampleRecord, reason: str, boot: str = "") -> None:
        """Record that a batch is gone; of this boot when none is named."""
        self._gaps.add_gap(gap_of(record, boot or self._head.boot, reason))
        # The mark tells of this run only.
        if not boot:
            self._progress.count_lost(record.end)

    def list_gaps(self) -> list[SampleGap]:
        """Give the gaps that the hub has not acknowledged past."""
        return self._gaps.list_gaps()

    # ── acknowledging ──

    def acknowledge_samples(self, boot: str, below: int) -> None:
        """Note that every sample of ``boot`` below ``below`` is stored for good."""
        # Never backwards: a late or repeated acknowledgement takes nothing back;
        # `rewind_acknowledged` does.
        if below > self._acked.get(boot, 0):
            self._acked[boot] = below

    def acked_below(self, boot: str) -> int:
        """Give below which sample of ``boot`` a hub has said that all is stored."""
        return self._acked.get(boot, 0)

    def rewind_acknowledged(self, below: int) -> None:
        """Take back what of this boot was acknowledged from ``below`` on: the hub has lost it.

        Its database was begun anew or is an older one. What is still here is given out again; the
        rest is a gap.
        """
        boot, acked = self._head.boot, self._acked.get(self._head.boot, 0)
        if below >= acked:
            return
        log.warning("the hub has lost samples %d to %d, which it had stored", below, acked - 1)
        self._acked[boot] = below
        for first, end, from_us, to_us in self._gone.dropped_since(below):
            span = {"first": first, "last": end - 1, "from_us": from_us, "to_us": to_us}
            # What was dropped before the hub had it is a gap already, for its own reason.
            self._gaps.add_unknown(SampleGap(boot=boot, reason=UNLEARNED, **span))

    def _trim_acknowledged(self) -> None:
        # A list of its own: `_remove_segment` changes the one that is walked through.
        for segment in [
            segment
            for segment in self._segments
            if segment.end <= self._acked.get(segment.head.boot, 0) and segment is not self._current
        ]:
            # The mark is written before the file goes: a crash between would make a gap of stored
            # samples.
            self._progress.save_acked()
            self._remove_segment(segment)
        while (
            # The current one is closed by `_write_record`, at a part of this age.
            len(self._segments) > 1 and self._segments.waited_s(self._segments.oldest) > self._age_s
        ):
            self._drop_oldest(OLD)
        current, acked = self._current, self._acked.get(self._head.boot, 0)
        if current.end <= acked and current.size > self._sizes.trim:
            # Emptied in place: with a hub that keeps up, the pages never reach the disk at all.
            self._empty_segment(current)
        # What waits in memory may have been sent live and stored meanwhile.
        for stored in self._memory.pop_below(acked):
            self._gone.add_range(stored.first, stored.end, stored.from_us, stored.to_us)
        # Last: gaps are compared with what was acknowledged above.
        self._gaps.forget_acked(self._acked)

    def all_heard(self) -> None:
        """Note that every channel that speaks has been heard, or is told as a gap."""
        self._progress.all_heard()

    def _empty_segment(self, current: Segment) -> None:
        # As for a segment that goes: the mark first.
        self._progress.save_acked()
        if not self._writer.empty_file(current):
            return
        self._gone.add_range(current.first, current.end, current.from_us, current.to_us)
        # Nothing is in it; `end` stays, so that `sync_to_disk` compares with how far it had come.
        current.first = -1
        # Whoever reads at a place in it knows by this that the place means something else now.
        current.turn += 1

    def sync_to_disk(self, heard_us: int = 0) -> None:
        """Force to disk what a power cut would take, unless the hub has it all.

        Args:
            heard_us: up to when all that was heard has been given here (µs, UTC); 0: not known.

        """
        self._trim_acknowledged()
        self._gaps.write_gaps()
        if heard_us:
            # Silence moves the mark on as well, or the next run would tell of it as a gap.
            self._progress.save_progress(0, heard_us)
        # What the hub has acknowledged since the last call needs no force: one period of grace.
        settled = self._acked.get(self._head.boot, 0) >= self._synced_end
        self._synced_end = self._current.end
        if not settled:
            self._writer.sync_file()

    # ── reading ──

    def read_records(
        self, place: SpoolPosition, most: int
    ) -> tuple[list[StoredRecord], SpoolPosition]:
        """Give the next records not yet acknowledged, about ``most`` bytes; none at the end."""
        self._trim_acknowledged()
        for segment in self._segments:
            # Read already, or nothing in it yet.
            if segment.number < place.number or segment.first < 0:
                continue
            same = segment.number == place.number and segment.turn == place.turn
            # Another segment, or the same one emptied or packed since: offsets in it mean nothing
            # now.
            if not same:
                place = SpoolPosition(segment.number, segment.turn, segment.start)
            try:
                found, place = self._reader.read_segment(segment, place, most)
            except OSError as error:
                # One file that cannot be read must not end the link; the ones behind it are given
                # out.
                self._give_up(segment, error)
                continue
            if found:
                return found, place
        last = self._segments.newest_number + 1
        # Newer than all on disk, so it comes last; by the place it is given out once.
        if self._memory and place.number < last:
            return [StoredRecord(self._head, record) for record in self._memory], SpoolPosition(
                last, 0, 0
            )
        return [], place

    def former_segments(self) -> list[int]:
        """Give the numbers of the segments that former runs left, the newest first."""
        return self._segments.former_numbers(self._head.boot)

    def newest_in(self, number: int, known: set[str], now_us: int) -> FormerNewest | None:
        """Give the newest samples of a segment (`former_runs`), or none when it is gone."""
        # Dropped since its number was given: `former_segments` is asked in another turn.
        segment = self._segments.by_number(number)
        return None if segment is None else newest_of_segment(segment, known, now_us)

    def seek_sample(self, boot: str, first: int) -> SpoolPosition:
        """Give where to read from to be given sample ``first`` of ``boot`` early on."""
        return self._segments.position_of(boot, first)

    def _give_up(self, segment: Segment, error: OSError) -> None:
        """Set a segment aside that the disk no longer gives back; the link goes on without it."""
        log.warning("%s cannot be read and is set aside: %s", segment.path, error)
        # First, so that there is always a current segment behind the one that goes.
        if segment is self._current:
            self._begin_segment()
        try:
            set_aside(segment.path)
        except OSError as failure:
            log.warning("%s cannot be set aside: %s", segment.path, failure)
        # Acknowledged samples of it are at the hub, whatever became of the file.
        first = max(segment.first, self._acked.get(segment.head.boot, 0))
        if first < segment.end:
            self._gaps.add_gap(gap_in(segment, first, DAMAGED))
        self._segments.remove_segment(segment)

    def close(self) -> None:
        """Force to disk and close; an empty current segment is removed."""
        # Trimmed first: what the hub has need not be forced to disk.
        self._trim_acknowledged()
        self._gaps.write_gaps()
        self._progress.save_acked()
        # Before the writer, which may raise: the mark's file is closed in any case.
        self._progress.close()
        self._writer.close()
        # As in `redescribe`: an empty segment is nothing to take up.
        if self._current.first < 0:
            remove_file(self._current.path)
