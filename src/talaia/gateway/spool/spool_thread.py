"""The spool on a thread of its own, so that a slow disk never holds up a driving frame."""

from __future__ import annotations

import asyncio
import logging
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from concurrent.futures import Future

    from talaia.gateway.spool.former_runs import FormerNewest
    from talaia.gateway.spool.journal import SegmentHead, Spool, SpoolPosition, StoredRecord
    from talaia.gateway.spool.segment import SampleRecord
    from talaia.wire.frames import SampleGap

__all__ = ["SpoolThread"]

log = logging.getLogger(__name__)
T = TypeVar("T")
# Bytes handed to the thread and not taken by it yet.
MAX_WAITING = 32 * 1024 * 1024
# What was heard longer ago than this has been given to the spool (µs).
UNDER_WAY_US = 250_000
# Of the time in which records are gathered: one that comes this late takes all of them along.
_EARLY = 0.7


class SpoolThread:
    """Gives the spool's work to one thread, in order. Called from the event loop only.

    What waits for the disk is bounded: beyond that a batch is not kept but recorded as lost,
    since a disk that has stood still for that long would take the memory of the robot's own
    programs next.
    """

    def __init__(self, spool: Spool, gather_s: float = 0.0) -> None:
        """Take over ``spool``; nobody else may call it from now on.

        Records are written about every ``gather_s`` (s), those together that came since, so that
        batches that are made sooner ask no more of the disk.
        """
        self._spool = (
            spool  # Touched on `_thread` only, but for `acknowledge_samples` and `former`.
        )
        # One thread: it is a queue as well, so all calls keep their order.
        self._thread = ThreadPoolExecutor(1, "talaia-spool")
        # How far the run before this one came, if there was one.
        self.former = spool.former
        self._gather_s = gather_s
        # Not handed to the thread yet; whatever else is asked of it comes behind them.
        self._gathered: list[SampleRecord] = []
        # From when on a record is handed over at once (monotonic s); the timer does it without one.
        self._ripe_s = 0.0
        self._timer: asyncio.TimerHandle | None = None
        # Two counters, each written by one thread only.
        self._given = 0  # Bytes given, by the event loop.
        self._taken = 0  # Bytes taken, by the thread.

    def append_record(self, record: SampleRecord) -> None:
        """Keep a record."""
        size = len(record.body)
        # A stale `_taken` only makes the queue look longer than it is.
        if self._given - self._taken + size > MAX_WAITING:
            self._submit(self._spool.record_loss, record, "the gateway's disk stood still")
            return
        self._given += size
        self._gathered.append(record)
        if time.monotonic() >= self._ripe_s:
            self._hand_over()
        elif self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(self._gather_s, self._hand_over)

    def _hand_over(self) -> None:
        """Give the thread what was gathered."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._gathered:
            records, self._gathered = self._gathered, []
            self._ripe_s = time.monotonic() + _EARLY * self._gather_s
            self._thread.submit(self._append_sized, records).add_done_callback(_log_failure)

    def _submit(self, work: Callable[..., T], *told: object) -> Future[T]:
        """Have the thread do something behind all that was given before."""
        self._hand_over()
        return self._thread.submit(work, *told)

    def record_loss(self, record: SampleRecord, reason: str, boot: str = "") -> None:
        """Record a loss that happened outside the spool; see `Spool.record_loss`."""
        self._submit(self._spool.record_loss, record, reason, boot).add_done_callback(_log_failure)

    def all_heard(self) -> None:
        """See `Spool.all_heard`."""
        self._submit(self._spool.all_heard).add_done_callback(_log_failure)

    def _append_sized(self, records: list[SampleRecord]) -> None:
        # Before the disk is waited for: at most these more than the bound are in memory.
        self._taken += sum(len(record.body) for record in records)
        self._spool.append_records(records)

    def redescribe(self, head: SegmentHead) -> None:
        """See `Spool.redescribe`; what was given before is kept by the old channel list."""
        self._submit(self._spool.redescribe, head).add_done_callback(_log_failure)

    def acknowledge_samples(self, boot: str, below: int) -> None:
        """Pass on an acknowledgement.

        It is only a note in a dictionary, which the next append or sync acts on; so it costs no
        change of thread.
        """
        self._spool.acknowledge_samples(boot, below)

    def acked_below(self, boot: str) -> int:
        """See `Spool.acked_below`; it is one look into a dictionary."""
        return self._spool.acked_below(boot)

    def rewind_acknowledged(self, below: int) -> None:
        """See `Spool.rewind_acknowledged`; done before whatever is asked for after it."""
        self._submit(self._spool.rewind_acknowledged, below).add_done_callback(_log_failure)

    async def sync_to_disk(self, heard_us: int = 0) -> None:
        """See `Spool.sync_to_disk`."""
        await self._run_on_thread(lambda: self._spool.sync_to_disk(heard_us))

    async def keep_syncing(self, period_s: float, wall_us: Callable[[], int]) -> None:
        """Force what was given to disk so often, until cancelled."""
        while True:
            await asyncio.sleep(period_s)
            try:
                await self.sync_to_disk(wall_us() - UNDER_WAY_US)
            except OSError as error:
                # A disk that fails ends nothing: what guards the robot needs none.
                log.debug("the spool cannot be forced to disk: %s", error)

    async def list_gaps(self) -> list[SampleGap]:
        """See `Spool.list_gaps`."""
        return await self._run_on_thread(self._spool.list_gaps)

    async def seek_sample(self, boot: str, first: int) -> SpoolPosition:
        """See `Spool.seek_sample`."""
        return await self._run_on_thread(lambda: self._spool.seek_sample(boot, first))

    async def former_newest(self, known: set[str], now_us: int) -> AsyncIterator[FormerNewest]:
        """Give what former runs heard last of channels that are not ``known``, newest run first.

        One segment at a time, so that what is new is kept in between.
        """
        # Newest first: what a later run heard of a channel hides what an earlier one did.
        for number in await self._run_on_thread(self._spool.former_segments):
            read = partial(self._spool.newest_in, number, known, now_us)
            found = await self._run_on_thread(read)
            if found is not None:
                yield found

    async def read_records(
        self, place: SpoolPosition, most: int
    ) -> tuple[list[StoredRecord], SpoolPosition]:
        """See `Spool.read_records`."""
        return await self._run_on_thread(lambda: self._spool.read_records(place, most))

    async def _run_on_thread(self, work: Callable[[], T]) -> T:
        return await asyncio.wrap_future(self._submit(work))

    async def close(self) -> None:
        """Finish what waits, close the spool and end the thread."""
        try:
            await self._run_on_thread(self._spool.close)
        # The process ends all the same; what was written survives it.
        except OSError as error:
            log.warning("the spool could not be closed well: %s", error)
        self._thread.shutdown(wait=True)


def _log_failure(future: Future[None]) -> None:
    error = future.exception()
    # Nobody awaits these calls, so without this a fault would be silent.
    if error is not None:
        log.error("the spool failed: %s", error, exc_info=error)
