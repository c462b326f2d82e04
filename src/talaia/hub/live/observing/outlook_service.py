"""Asks the planner when single requests can be observed, beside the event loop, one at a time."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, TypeVar
from zoneinfo import ZoneInfo

import msgspec

from talaia.hub.errors import HubBusy
from talaia.hub.live.observing.observing_sites import instrument_of
from talaia.hub.observing.newcomer import NewcomerChances, newcomer_chances
from talaia.hub.observing.outlook import NightSkies, RequestOutlook, request_outlook
from talaia.model.observing.states import RequestState
from talaia.planner.sky import TelescopePlace

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.clock import Clock
    from talaia.hub.live.observing.forecast_service import KeptForecast
    from talaia.model.observing.requests import Request, RequestGroup
    from talaia.model.site import Site

__all__ = ["MOST_OUTLOOKS", "OutlookService", "telescope_place"]

_Answer = TypeVar("_Answer")
# Requests of a group whose outlook is worked out: each takes some tenths of a second.
MOST_OUTLOOKS = 8
# Who comes when so many wait is told to come again.
_MOST_WAITING = 8


class OutlookService:
    """One thread's worth of looking ahead for all pages; whole plans are a `ForecastService`'s."""

    def __init__(self, clock: Clock) -> None:
        """Nothing is observed before ``clock`` says so."""
        self._clock = clock
        # Skies are no two threads' at once.
        self._turn = asyncio.Lock()
        self._waiting = 0
        self._skies: dict[TelescopePlace, NightSkies] = {}

    async def work_out(self, site: Site, requests: Sequence[Request]) -> list[RequestOutlook]:
        """Give the outlook of each of the first `MOST_OUTLOOKS` requests.

        Raises:
            HubBusy: so many wait that this one must come again.

        """
        place = telescope_place(site)
        if place is None:
            return []
        skies = self._skies.setdefault(place, NightSkies(place))
        now, zone, instrument = self.now(), ZoneInfo(site.zone), instrument_of(site)
        return await self._in_turn(
            lambda: [
                request_outlook(skies, request, instrument, now=now, zone=zone)
                for request in requests[:MOST_OUTLOOKS]
            ]
        )

    async def weigh_chances(
        self, site: Site, group: RequestGroup, kept: KeptForecast
    ) -> list[NewcomerChances]:
        """Give the chance of each of the first `MOST_OUTLOOKS` requests beside what waits already.

        Raises:
            HubBusy: so many wait that this one must come again.

        """
        place = telescope_place(site)
        if place is None:
            return []
        skies = self._skies.setdefault(place, NightSkies(place))
        now, instrument = self.now(), instrument_of(site)
        some = tuple(
            msgspec.structs.replace(request, id=str(at), state=RequestState.PENDING)
            for at, request in enumerate(group.requests[:MOST_OUTLOOKS])
        )
        asked = msgspec.structs.replace(group, requests=some)
        return await self._in_turn(
            lambda: newcomer_chances(kept.week, skies.find_sky, asked, instrument, now=now)
        )

    async def _in_turn(self, work: Callable[[], _Answer]) -> _Answer:
        if self._waiting >= _MOST_WAITING:
            raise HubBusy("many ask for the sky at once", "try again in a few seconds")
        self._waiting += 1
        try:
            async with self._turn:
                return await asyncio.to_thread(work)
        finally:
            self._waiting -= 1

    def now(self) -> float:
        """Give the time (s since the epoch, UTC)."""
        return self._clock.wall_ns() / 1e9


def telescope_place(site: Site) -> TelescopePlace | None:
    """Give where a site's telescope stands; None: its description does not say."""
    place = site.place
    if place is None:
        return None
    return TelescopePlace(place.latitude, place.longitude, place.elevation or 0.0)
