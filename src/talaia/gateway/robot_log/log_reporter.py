"""Lines of the robot's log on their way to the hub: on disk until it has them."""

from __future__ import annotations

import asyncio
import contextlib
from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.disk_trouble import DiskTrouble
from talaia.gateway.robot_log.line_queue import LineQueue
from talaia.wire.frames import LogLine, RobotLogBatch

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.gateway.robot_log.line_files import LineFiles
    from talaia.gateway.robot_log.line_queue import WaitingLine
    from talaia.wire.frames import FromGateway, RobotLogAck

__all__ = ["LogReporter"]

# What gathers meanwhile is one write and one message (s).
_GATHER_S = 0.3
# Between two words on lines that went for want of room (s).
_DROPPED_S = 60.0
_FILES = "copy of the robot's log"
_WARNING = 30


class LogReporter:
    """A `LogSink`; all but `keep_line` on the event loop only."""

    def __init__(
        self,
        *,
        boot: str,
        files: LineFiles,
        send: Callable[[FromGateway], None],
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
        loop: asyncio.AbstractEventLoop,
    ) -> None:
        """Take up what an earlier run left (blocks).

        Args:
            boot: names this run of the gateway.
            files: of what the hub does not have yet.
            send: to the hub.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.
            loop: of everything here.

        """
        self._files, self._send = files, send
        self._on_disk, self._loop = on_disk, loop
        self._trouble = DiskTrouble()
        self._queue = LineQueue(boot, files.read_left())
        # What came since the last write.
        self._fresh: list[WaitingLine] = []
        self._wake = asyncio.Event()
        self._takes = False
        # A message is on its way, and the hub has not answered it.
        self._under_way = False
        self._on_disk_now = self._queue.segments()
        # When the next word on lines that went may be said (loop's time).
        self._dropped_due = 0.0

    def keep_line(self, line: LogLine) -> None:
        """See `LogSink`."""
        # The loop may be closed already: an adapter's thread ends after it.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._add, line)

    def link_up(self, *, takes: bool) -> None:
        """Tell all of it to a new link, if its hub takes it."""
        self._takes, self._under_way = takes, False
        self._send_next()

    def link_lost(self) -> None:
        """Wait for the next link."""
        self._takes = False

    def handle_ack(self, ack: RobotLogAck) -> None:
        """Forget what the hub has, and send what comes behind it."""
        self._queue.acknowledge(ack.boot, ack.below)
        self._under_way = False
        self._send_next()
        self._wake.set()

    async def run(self) -> None:
        """Write and send until cancelled."""
        while True:
            await self._wake.wait()
            await asyncio.sleep(_GATHER_S)
            self._wake.clear()
            self._tell_dropped()
            await self._write_fresh()
            self._send_next()

    async def close(self) -> None:
        """Write what has just come."""
        await self._write_fresh()

    def _add(self, line: LogLine) -> None:
        self._fresh.append(self._queue.add_line(line))
        self._wake.set()

    def _tell_dropped(self) -> None:
        """Say how many lines went for want of room, where they are missing."""
        if not self._queue.dropped or self._loop.time() < self._dropped_due:
            return
        self._dropped_due = self._loop.time() + _DROPPED_S
        count, time_us = self._queue.collect_dropped()
        self._add(
            LogLine(
                time_us=time_us,
                level=_WARNING,
                text=f"{count} lines up to here are lost: the gateway had no room for them "
                "while the hub could not be reached",
                left_out=count,
            )
        )

    async def _write_fresh(self) -> None:
        fresh, self._fresh = self._fresh, []
        needed = self._queue.segments()
        work = []
        # What the hub has got meanwhile is in no file that is needed.
        if lines := [one for one in fresh if (one.boot, one.segment) in needed]:
            work.append(partial(self._files.append, lines))
        if self._on_disk_now - needed:
            work.append(partial(self._files.remove_others, needed))
        self._on_disk_now = needed
        for step in work:
            try:
                await self._on_disk(step)
            except OSError as error:
                # They are still in memory, and go to the hub from there.
                self._trouble.record_failure(_FILES, error)
            else:
                self._trouble.record_success(_FILES)

    def _send_next(self) -> None:
        """Send one message; the next follows when it is answered, or on a new link."""
        if not self._takes or self._under_way:
            return
        batch = self._queue.next_batch()
        if not batch:
            return
        self._under_way = True
        self._send(
            RobotLogBatch(
                boot=batch[0].boot, first=batch[0].number, lines=[one.line for one in batch]
            )
        )
