"""Takes lines of robots' own logs from gateways: kept first, acknowledged after that, each once."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import re
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.errors import StoreDown
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.sites.robot_log import StoredLine
from talaia.wire.frames import MAX_LOG_TEXT, LogLine, RobotLogAck

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.site_state import SiteLink
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.sites.robot_log import RobotLogStore
    from talaia.wire.frames import RobotLogBatch

__all__ = ["RobotLogIntake", "stored_line"]

_LOG = logging.getLogger(__name__)
# Messages of one site that wait.
_MOST_WAITING = 4
_RETRY_S = 2.0
# How often old lines are deleted (s), and the first time after the start.
_TRIM_S, _FIRST_TRIM_S = 600.0, 60.0
_DAY_US = 86_400_000_000
# A line is of the past; a clock may be ahead by so much (µs).
_AHEAD_US = 60_000_000
# Colours of a terminal, which mean nothing on a page (ECMA-48, 5.4).
_COLOURS = re.compile(r"\x1b\[[0-?]*[ -/]*[@-~]")
_NAME = 200


class _Waiting(NamedTuple):
    site: str
    link: SiteLink
    batch: RobotLogBatch


class RobotLogIntake:
    """Writes lines down in the order in which they come."""

    def __init__(
        self,
        store: RobotLogStore,
        clock: Clock,
        *,
        days: float,
        most: int,
        retry_s: float = _RETRY_S,
    ) -> None:
        """Keep lines for ``days`` (0: for good), and at most ``most`` of each site."""
        self._store, self._clock = store, clock
        self._days, self._most, self._retry_s = days, most, retry_s
        self._waiting: deque[_Waiting] = deque()
        self._wake = asyncio.Event()
        loop_s = clock.monotonic_ns() / 1e9
        self._trim_due_s = loop_s + _FIRST_TRIM_S
        # The database is away: said once, and once when it is back.
        self._away = False

    def handle_batch(self, live: LiveSite, batch: RobotLogBatch) -> None:
        """Take lines; their gateway is told when they are kept."""
        if live.link is None:
            return
        # What came on a former link comes again on this one.
        for former in [one for one in self._waiting if one.site == live.name]:
            if former.link is not live.link:
                self._waiting.remove(former)
        # A gateway sends the next one when the last was acknowledged; others have no room here.
        if sum(one.site == live.name for one in self._waiting) >= _MOST_WAITING:
            return
        self._waiting.append(_Waiting(live.name, live.link, batch))
        self._wake.set()

    async def run(self) -> None:
        """Keep lines, and let old ones go, until cancelled."""
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_FIRST_TRIM_S):
                    await self._wake.wait()
            self._wake.clear()
            try:
                while self._waiting:
                    await self._store_next()
                await self._trim_old()
                if self._away:
                    self._away = False
                    _LOG.warning("lines of robots' logs are kept again")
            except StoreDown as error:
                if not self._away:
                    _LOG.warning("lines of robots' logs wait: %s", error)
                self._away = True
                await asyncio.sleep(self._retry_s)
                self._wake.set()

    async def _store_next(self) -> None:
        waiting = self._waiting[0]
        site, link, batch = waiting
        latest_us = self._clock.wall_ns() // 1000 + _AHEAD_US
        lines = [stored_line(line, latest_us) for line in batch.lines]
        await self._store.store_lines(site, safe_text(batch.boot, _NAME), batch.first, lines)
        # Only now: whoever is cancelled before has written nothing, or all of it once more.
        with contextlib.suppress(ValueError):
            self._waiting.remove(waiting)
        link.send(RobotLogAck(boot=batch.boot, below=batch.first + len(batch.lines)))

    async def _trim_old(self) -> None:
        now_s = self._clock.monotonic_ns() / 1e9
        if now_s < self._trim_due_s:
            return
        self._trim_due_s = now_s + _TRIM_S
        before_us = self._clock.wall_ns() // 1000 - round(self._days * _DAY_US) if self._days else 0
        if gone := await self._store.delete_old(before_us, self._most):
            _LOG.info("%d old lines of robots' logs were deleted", gone)


def stored_line(line: LogLine, latest_us: int) -> StoredLine:
    """Give what is kept of a line: nothing hidden is in it, and its time is none of the future."""
    text = _COLOURS.sub("", line.text).replace("\r\n", "\n").strip("\n")
    text = "\n".join(safe_text(part, MAX_LOG_TEXT) for part in text.split("\n"))[:MAX_LOG_TEXT]
    return StoredLine(
        time_us=min(max(0, line.time_us), latest_us),
        level=line.level,
        node=safe_text(line.node, _NAME),
        text=text,
        function=safe_text(line.function, _NAME),
        file=safe_text(line.file, _NAME),
        line=line.line,
        left_out=line.left_out,
    )
