"""Drops what a signal no longer keeps, and the oldest of all where there is too much."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.hub.history.writing.retention import too_much, too_old
from talaia.hub.history.writing.writer_jobs import Drop

if TYPE_CHECKING:
    from sqlalchemy import Engine

    from talaia.clock import Clock
    from talaia.hub.history.database_threads import DatabaseThreads
    from talaia.hub.history.writing.block_index import BlockIndex
    from talaia.hub.history.writing.retention_periods import RetentionPeriods
    from talaia.hub.history.writing.writer import Writer

__all__ = ["Tidier"]

_LOG = logging.getLogger(__name__)


class Tidier:
    """Looks for what is to go beside the readers, and lets the writing thread drop it.

    A few blocks are dropped at a time, each time as a job behind those that wait: a gateway's
    samples never wait for a whole clearing up.
    """

    def __init__(
        self,
        *,
        threads: DatabaseThreads,
        reading: Engine,
        ledger: BlockIndex,
        writer: Writer,
        periods: RetentionPeriods,
        most_bytes: int,
        clock: Clock,
    ) -> None:
        """Keep what ``periods`` say, and at most ``most_bytes`` of blocks; 0 is without a limit."""
        self._threads = threads
        # To look for blocks takes a while, so that is not done by the connection that writes.
        self._reading = reading
        # Knows the channels' numbers.
        self._ledger = ledger
        # Drops what was found, as a job among others.
        self._writer = writer
        # How long each channel is kept; descriptions change it.
        self._periods = periods
        # Of all blocks; 0: no limit.
        self._most_bytes = most_bytes
        self._clock = clock
        # Sites that move: nothing is dropped meanwhile, or it would come there after all.
        self.held_for: set[str] = set()

    async def drop_old_blocks(self) -> int:
        """See `HistoryStore.apply_retention`."""
        if self.held_for:
            return 0
        now_us = self._clock.wall_ns() // 1000
        before_us = self._periods.oldest_kept(self._ledger.names.channels, now_us)
        dropped = 0
        while doomed := await self._threads.run_query(too_old, self._reading, before_us):
            await self._writer.complete_job(Drop(doomed))
            dropped += len(doomed)
        # Second: what is too old goes anyway, and may make room enough.
        while self._most_bytes and (
            doomed := await self._threads.run_query(too_much, self._reading, self._most_bytes)
        ):
            await self._writer.complete_job(Drop(doomed))
            dropped += len(doomed)
        if dropped:
            _LOG.info("%d blocks of the history were too old or too much, and are dropped", dropped)
        return dropped
