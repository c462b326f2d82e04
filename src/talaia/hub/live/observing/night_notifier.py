"""Tells people what their gateways say of a night: it is over, or somebody has to look."""

from __future__ import annotations

import asyncio
import logging
from collections import defaultdict, deque
from typing import TYPE_CHECKING

from talaia.hub.errors import StoreDown
from talaia.hub.store.observing.night_notices import NightNotice, add_night_notice
from talaia.model.alarms.alarm import Severity

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.database import Database
    from talaia.wire.frames import Event

__all__ = ["NightNotifier"]

_LOG = logging.getLogger(__name__)
_RETRY_S = 2.0
# Of all sites; each night has a few. What comes beyond it stands in the logbook alone.
_MOST_WAITING = 1000
# Of one site within a day: a gateway in other hands fills nobody's mailbox.
_MOST_A_DAY = 20
_DAY_US = 86_400 * 10**6
_OLDEST_US = 366 * _DAY_US
# What is told of, by the kind of the gateway's event.
_TOLD = {
    "night_ended": ("the night is over", Severity.INFO),
    "night_fault": ("the night has failed", Severity.CRITICAL),
    "night_not_closed": ("the roof is not closed", Severity.CRITICAL),
    "night_not_parked": ("the telescope is not parked", Severity.CRITICAL),
}


class NightNotifier:
    """Puts messages into the outbox, in the order in which they come."""

    def __init__(self, database: Database, clock: Clock, deliver: Callable[[], None]) -> None:
        """Keep them in ``database``; ``deliver`` is called when there may be one to send."""
        self._database = database
        self._clock = clock
        self._deliver = deliver
        self._waiting: asyncio.Queue[NightNotice] = asyncio.Queue(_MOST_WAITING)
        # When each site's last ones were taken (µs, UTC).
        self._taken: defaultdict[str, deque[int]] = defaultdict(lambda: deque(maxlen=_MOST_A_DAY))

    def handle_event(self, live: LiveSite, event: Event) -> None:
        """Take what a gateway says; never waits."""
        told = _TOLD.get(event.kind)
        if told is None or self._waiting.full():
            return
        now_us = self._clock.wall_ns() // 1000
        taken = self._taken[live.name]
        if len(taken) == _MOST_A_DAY and now_us - taken[0] < _DAY_US:
            return
        taken.append(now_us)
        words, severity = told
        if severity is Severity.INFO and not event.good:
            severity = Severity.WARNING
        self._waiting.put_nowait(
            NightNotice(
                site=live.name,
                title=f"{live.description.name}: {words}",
                # Mailed to people: nobody is to take it for the hub's own words.
                text=f"Its gateway says: {event.message}" if event.message else "",
                severity=severity,
                # The gateway's own, by which a repetition is known, unless it is nonsense.
                time_us=event.time_us if abs(event.time_us - now_us) < _OLDEST_US else now_us,
            )
        )

    async def run(self) -> None:
        """Write them down until cancelled."""
        while True:
            if await self._add_notice(await self._waiting.get()):
                self._deliver()

    async def _add_notice(self, notice: NightNotice) -> bool:
        """Write one down, when the database can; give whether anybody is to be told."""
        while True:
            try:
                async with self._database.write() as connection:
                    now_us = self._clock.wall_ns() // 1000
                    return await add_night_notice(connection, notice, now_us)
            except StoreDown as error:
                _LOG.warning("a message about the night of %s waits: %s", notice.site, error)
                await asyncio.sleep(_RETRY_S)
