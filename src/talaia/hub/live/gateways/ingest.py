"""Samples of one gateway on their way to the history: bounded, then it presses back.

To press back by not reading the link would hold up STOP, driving and beats as well. So what finds
no room is put down as owed, and the gateway, which keeps it until it is stored, is asked for it
again once there is room.

Long, because what waits, is owed and is stored are one account.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.hub.history.errors import HistoryElsewhere
from talaia.hub.live.gateways.acknowledged_sequence import StoredRun
from talaia.wire.columns import join_columns
from talaia.wire.frames import Ack, ResendRequest, SampleGap

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.hub.ports import History
    from talaia.wire.columns import Columns

__all__ = ["Batch", "Ingest", "Renaming", "StoringPace"]

_LOG = logging.getLogger(__name__)
# Samples that may wait, and that one commit holds at the most.
_MOST_WAITING = 500_000
_MOST_A_COMMIT = 100_000
# While so many wait, nothing more is gathered: a gateway that catches up is not held up.
_MANY = 10_000
# Pieces of it that do not follow each other.
_MOST_PIECES = 1000
# Runs of a gateway of which is remembered what is stored; the database knows it of the others.
_MOST_RUNS = 1000
# When so few wait, what is owed is asked for.
_ROOM = _MOST_WAITING // 4
_RETRY_S = 1.0
# So many gateways begin to store in one turn of the loop: whoever drives has the next one.
_A_TURN = 32


@dataclass(frozen=True, slots=True)
class Batch:
    """Samples as they came: sample i has the sequence number ``first + i``."""

    boot: str
    first: int
    addresses: tuple[str, ...]
    columns: Columns

    @property
    def end(self) -> int:
        """One past the last sequence number."""
        return self.first + len(self.columns)


@dataclass(frozen=True, slots=True)
class Renaming:
    """Channels that have other addresses from here on, by the former ones; ``done`` is set then."""

    moves: Mapping[str, str]
    done: asyncio.Event = field(default_factory=asyncio.Event)


class StoringPace:
    """When gateways store what has come of them: together, so that they share commits.

    Each with a timer of its own, thousands of them would have the disk sync for a few each.
    """

    def __init__(self, gather_s: float) -> None:
        """Let what comes gather for at most so long (s); 0: for nothing."""
        self._gather_s = gather_s
        # What is set when it is time, of those that have something to store.
        self._due: deque[asyncio.Event] = deque()
        # It will be.
        self._armed = False

    def set_soon(self, event: asyncio.Event) -> None:
        """Set an event when it is time to store."""
        if not self._gather_s:
            event.set()
            return
        self._due.append(event)
        if not self._armed:
            self._armed = True
            asyncio.get_running_loop().call_later(self._gather_s, self._set_some)

    def _set_some(self) -> None:
        for _ in range(min(_A_TURN, len(self._due))):
            self._due.popleft().set()
        self._armed = bool(self._due)
        if self._armed:
            asyncio.get_running_loop().call_soon(self._set_some)


class Ingest:
    """Stores batches and gaps in the order they came and acknowledges once for each commit."""

    def __init__(
        self,
        history: History,
        site: str,
        tell: Callable[[Ack | ResendRequest], None],
        pace: StoringPace,
    ) -> None:
        """Tell the gateway when samples are safe; gather by ``pace`` before a commit."""
        self._history = history
        self._site = site
        # Acknowledges, or asks again, on the link to the gateway.
        self._tell = tell
        self._pace = pace
        # In the order in which it came, which is the order in which it is stored.
        self._waiting: deque[Batch | SampleGap | Renaming] = deque()
        # Of all that ever waited.
        self._count = 0
        # Of what waits; bounded by `_MOST_WAITING`, since the link is read on.
        self._samples = 0
        # Set when it is time to store something, or the end; and whether the pace knows of it.
        self._news = asyncio.Event()
        self._paced = False
        # What found no room, by run: from which sequence number to before which.
        self._owed: dict[str, tuple[int, int]] = {}
        # What is known to be stored, by run of the gateway.
        self._runs: dict[str, StoredRun] = {}
        # Set once: what waits is stored, and `run` ends.
        self._ending = False

    async def first_missing(self, boot: str) -> int:
        """Give the first sequence number of ``boot`` that is not stored."""
        return (await self._stored_run(boot)).below

    def first_unstored(self, boot: str) -> int:
        """Give the first sequence number of ``boot`` that is not known to be stored."""
        run = self._runs.get(boot)
        return 0 if run is None else run.below

    def enqueue_batch(self, item: Batch | SampleGap) -> None:
        """Take a batch or a gap; what finds no room will be asked for again."""
        if self._samples >= _MOST_WAITING:
            last = item.last if isinstance(item, SampleGap) else item.first + len(item.columns) - 1
            # One span for each run, over what was stored in between too: storing twice changes
            # nothing.
            if item.boot not in self._owed and len(self._owed) >= _MOST_RUNS:
                # Not acknowledged, so the gateway has it, and sends it on its next link.
                return
            first, end = self._owed.get(item.boot, (item.first, last + 1))
            self._owed[item.boot] = (min(first, item.first), max(end, last + 1))
            return
        self._append_waiting(item)
        # A gap counts as well, so that a flood of them is bounded too.
        self._samples += len(item.columns) if isinstance(item, Batch) else 1
        self._wake_soon()

    def rename_channels(self, moves: Mapping[str, str]) -> asyncio.Event:
        """Rename channels once what came before is stored, and before what comes after."""
        renaming = Renaming(moves)
        self._append_waiting(renaming)
        self._wake_soon()
        return renaming.done

    def finish_storing(self) -> None:
        """Let `run` end once what waits is stored."""
        self._ending = True
        self._news.set()

    async def run(self) -> None:
        """Store until `finish_storing`. When the database fails, try again."""
        failing = False
        while self._waiting or not self._ending:
            await self._news.wait()
            self._news.clear()
            self._paced = False
            # What comes meanwhile is gathered anew: most of a commit's cost is the commit.
            due = self._count
            while self._waiting and (self._ending or self._is_due(due)):
                try:
                    await self._store_some()
                except (SQLAlchemyError, TalaiaError, OSError) as error:
                    if isinstance(error, HistoryElsewhere):
                        # No failure: this hub is about to let the site's gateway go.
                        _LOG.warning("samples of %s wait for another hub: %s", self._site, error)
                    elif not failing:
                        _LOG.exception("samples of %s cannot be stored; they wait", self._site)
                    failing = True
                    # The gateway keeps what is not acknowledged, and sends it on its next link.
                    if self._ending:
                        return
                    await asyncio.sleep(_RETRY_S)
                else:
                    if failing:
                        _LOG.warning("samples of %s are stored again", self._site)
                    failing = False
            if self._waiting:
                self._wake_soon()

    def _is_due(self, due: int) -> bool:
        """Tell whether the first that waits is one of the first ``due``, or very much waits."""
        return self._count - len(self._waiting) < due or self._samples >= _MANY

    def _append_waiting(self, item: Batch | SampleGap | Renaming) -> None:
        self._waiting.append(item)
        self._count += 1

    def _wake_soon(self) -> None:
        if self._samples >= _MANY:
            self._news.set()
        # Gathered, so that the disk is not made to sync for each batch of a few samples.
        elif not self._paced:
            self._paced = True
            self._pace.set_soon(self._news)

    async def _store_some(self) -> None:
        """Store what waits, as much as one commit takes."""
        first = self._waiting[0]
        # Nothing is stored beside it: what follows has the new addresses.
        if isinstance(first, Renaming):
            await self._history.rename_channels(self._site, first.moves)
            # Only when it is done: after a failure it is still the first.
            self._waiting.popleft()
            first.done.set()
            return
        if isinstance(first, SampleGap):
            taken: list[Batch | SampleGap] = [first]
            spans = [(first.boot, first.first, first.last + 1)]
            await self._history.record_gap(
                self._site,
                first.boot,
                first.first,
                first.last,
                from_us=first.from_us,
                to_us=first.to_us,
                reason=first.reason,
            )
        else:
            pieces = self._next_batches()
            batches = [batch for piece in pieces for batch in piece]
            taken = [*batches]
            spans = [(batch.boot, batch.first, batch.end) for batch in batches]
            await self._append_pieces(pieces)
        # Asks the database for a run that is new, so it stands before the first change here.
        runs = {
            boot: await self._stored_run(boot)
            for boot in dict.fromkeys(boot for boot, _, _ in spans)
        }
        for item in taken:
            self._waiting.popleft()
            self._samples -= len(item.columns) if isinstance(item, Batch) else 1
        if self._owed and self._samples < _ROOM:
            for boot, (owed, below) in self._owed.items():
                self._tell(ResendRequest(boot=boot, first=owed, below=below))
            self._owed.clear()
        for boot, begin, end in spans:
            runs[boot].add_stored(begin, end)
        for boot, run in runs.items():
            self._tell(Ack(boot=boot, below=run.below))

    async def _append_pieces(self, pieces: list[list[Batch]]) -> None:
        # Nearly always: a task for it would take longer than all else here.
        if len(pieces) == 1:
            await self._append_batches(pieces[0])
            return
        # Side by side: pieces that do not follow each other share a commit all the same.
        stored = await asyncio.gather(
            *(self._append_batches(piece) for piece in pieces), return_exceptions=True
        )
        # Pieces that were stored are stored once more then, which changes nothing.
        for failure in stored:
            if isinstance(failure, BaseException):
                raise failure

    async def _append_batches(self, piece: list[Batch]) -> None:
        first = piece[0]
        columns = join_columns([batch.columns for batch in piece])
        await self._history.append_samples(
            self._site, first.boot, first.first, addresses=first.addresses, columns=columns
        )

    def _next_batches(self) -> list[list[Batch]]:
        """Take from the front the batches of one commit, those together that follow each other."""
        pieces: list[list[Batch]] = []
        expected, count = -1, 0
        for item in self._waiting:
            # One batch is taken however large it is, or it would wait for ever.
            if not isinstance(item, Batch) or (
                pieces and count + len(item.columns) > _MOST_A_COMMIT
            ):
                break
            last = pieces[-1][-1] if pieces else None
            if (
                last is not None
                and (item.boot, item.first) == (last.boot, expected)
                and item.addresses == last.addresses
            ):
                pieces[-1].append(item)
            elif len(pieces) >= _MOST_PIECES:
                break
            else:
                pieces.append([item])
            count += len(item.columns)
            expected = item.end
        return pieces

    async def _stored_run(self, boot: str) -> StoredRun:
        run = self._runs.get(boot)
        if run is None:
            below = await self._history.stored_below(self._site, boot)
            run = self._runs[boot] = StoredRun(below)
            while len(self._runs) > _MOST_RUNS:
                # The oldest; a run that lives is asked for again, which is all.
                del self._runs[next(iter(self._runs))]
        return run
