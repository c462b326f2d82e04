"""Asks the planner for outlooks and forecasts, beside the event loop and one at a time."""

from __future__ import annotations

import asyncio
import heapq
from typing import TYPE_CHECKING, NamedTuple, TypeVar
from zoneinfo import ZoneInfo

from talaia.hub.errors import HubBusy
from talaia.hub.live.observing.observing_sites import instrument_of
from talaia.hub.observing.outlook import NightSkies, RequestOutlook, request_outlook
from talaia.planner.from_requests import make_night
from talaia.planner.session import PlanningSession
from talaia.planner.sky import TelescopePlace
from talaia.planner.week import NightChances, forecast_nights

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.clock import Clock
    from talaia.hub.store.observing.proposals import ProposalStore
    from talaia.hub.store.observing.request_store import RequestStore
    from talaia.model.observing.plan import Plan, WhyNot
    from talaia.model.observing.requests import Proposal, Request, RequestGroup
    from talaia.model.site import Site

__all__ = ["MOST_OUTLOOKS", "NightForecast", "OutlookService", "telescope_place"]

_Answer = TypeVar("_Answer")
# Requests of a group whose outlook is worked out: each takes some tenths of a second.
MOST_OUTLOOKS = 8
# Who comes when so many wait is told to come again.
_MOST_WAITING = 8
# A forecast is asked for by every page that is open (s).
_FRESH_S = 60.0
# One of seven nights takes seven times as long, and changes by as much less (s).
_WEEK_FRESH_S = 600.0
# Of more groups a week is planned with those of the highest priority: minutes of this thread, in
# which no other forecast is made, are not for what hardly any night reaches.
_WEEK_GROUPS = 1_000


class NightForecast(NamedTuple):
    """A plan of the night to come, and why other requests are not in it.

    Attributes:
        plan: as of its making.
        reasons: why each of the others is not observed as it begins.

    """

    plan: Plan
    reasons: tuple[WhyNot, ...]


class OutlookService:
    """One thread's worth of planning for all pages."""

    def __init__(self, requests: RequestStore, proposals: ProposalStore, clock: Clock) -> None:
        """Forecast what is kept in the stores; ``clock`` says from when on."""
        self._requests = requests
        self._proposals = proposals
        self._clock = clock
        # Skies are no two threads' at once.
        self._turn = asyncio.Lock()
        self._waiting = 0
        self._skies: dict[TelescopePlace, NightSkies] = {}
        # By site, with its revision and when it was made (s).
        self._forecasts: dict[str, tuple[int, float, NightForecast]] = {}
        self._weeks: dict[str, tuple[int, float, list[NightChances]]] = {}

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

    async def forecast_night(self, site: Site) -> NightForecast | None:
        """Plan the night to come with what waits now; None: nobody knows where the telescope is.

        Raises:
            HubBusy: so many wait that this one must come again.
            StoreDown: what waits cannot be read.

        """
        place = telescope_place(site)
        if place is None:
            return None
        pending = await self._requests.pending_set(site.site)
        now, kept = self.now(), self._forecasts.get(site.site)
        if kept is not None and kept[0] == pending.revision and now - kept[1] < _FRESH_S:
            return kept[2]
        proposals = [one.planned() for one in await self._proposals.list_proposals(site.site)]
        groups = [one.group for one in pending.groups]
        forecast = await self._in_turn(
            lambda: _forecast(site, place, now, proposals=proposals, groups=groups)
        )
        self._forecasts[site.site] = pending.revision, now, forecast
        return forecast

    async def forecast_week(self, site: Site) -> list[NightChances] | None:
        """Give chances of what waits for tonight and six nights more; None: as above.

        Raises:
            HubBusy: so many wait that this one must come again.
            StoreDown: what waits cannot be read.

        """
        place = telescope_place(site)
        if place is None:
            return None
        pending = await self._requests.pending_set(site.site)
        now, kept = self.now(), self._weeks.get(site.site)
        if kept is not None and kept[0] == pending.revision and now - kept[1] < _WEEK_FRESH_S:
            return kept[2]
        proposals = [one.planned() for one in await self._proposals.list_proposals(site.site)]
        waiting = (one.group for one in pending.groups)
        groups = heapq.nlargest(_WEEK_GROUPS, waiting, key=lambda group: group.priority)
        week = await self._in_turn(
            lambda: forecast_nights(
                place, now, instrument=instrument_of(site), proposals=proposals, groups=groups
            )
        )
        self._weeks[site.site] = pending.revision, now, week
        return week

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


def _forecast(
    site: Site,
    place: TelescopePlace,
    now: float,
    *,
    proposals: Sequence[Proposal],
    groups: Sequence[RequestGroup],
) -> NightForecast:
    problem = make_night(
        place, now, instrument=instrument_of(site), proposals=proposals, groups=groups
    )
    session = PlanningSession(problem)
    begin = max(now, problem.start)
    plan = session.plan(begin)
    planned = {block.request for block in plan.blocks}
    reasons = session.why_not(begin) if len(problem.table) else ()
    return NightForecast(plan, tuple(one for one in reasons if one.request not in planned))
