"""Sites, their history and their events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import msgspec
from fastapi import APIRouter, Query, Request, Response

from talaia.hub.api.access import live_of, who_of
from talaia.hub.api.described import describe, list_devices, summarise
from talaia.hub.api.people_shapes import DeviceList
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.shapes import (
    EventList,
    EventShape,
    Health,
    HistoryAnswer,
    SiteShape,
    SiteSummary,
)
from talaia.hub.auth.permissions import sees_signal, sees_site
from talaia.hub.policy import Need, allows

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.history.series import Series
    from talaia.hub.live.sites import Sites
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit

__all__ = ["SitePages"]

_MOST_SERIES = 100
_TIMES = Query(ge=0, le=2**53)


class SitePages:
    """The routes of sites."""

    def __init__(self, sites: Sites, history: History, audit: Audit, clock: Clock) -> None:
        """Answer from what is live, what is stored and what was written down."""
        self._sites = sites
        self._history = history
        self._audit = audit
        self._clock = clock

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter()
        router.get("/api/health")(self.health)
        router.get("/api/sites")(self.overview)
        router.get("/api/devices")(self.devices)
        router.get("/api/sites/{site}")(self.one)
        router.get("/api/sites/{site}/history", response_model=HistoryAnswer)(self.history)
        router.get("/api/sites/{site}/events")(self.events)
        return router

    async def health(self) -> Health:
        """Say that the hub answers; no more, since nobody has to be signed in."""
        return Health(ok=True)

    async def overview(self, request: Request) -> list[SiteSummary]:
        """List the sites that are open to you."""
        grants = who_of(request).grants
        now = self._clock.monotonic_ns()
        return [
            summarise(live, grants, now)
            for live in self._sites
            if sees_site(grants, live.description)
        ]

    async def devices(self, request: Request) -> DeviceList:
        """List all devices that are open to you, with how each is."""
        grants, now = who_of(request).grants, self._clock.monotonic_ns()
        return DeviceList(
            devices=[each for live in self._sites for each in list_devices(live, grants, now)]
        )

    async def one(self, request: Request, site: str) -> SiteShape:
        """Describe a site as far as it is open to you."""
        return describe(live_of(request), who_of(request).grants)

    async def history(
        self,
        request: Request,
        site: str,
        channel: Annotated[list[str], Query(min_length=1, max_length=_MOST_SERIES)],
        from_us: Annotated[int, _TIMES],
        to_us: Annotated[int, _TIMES],
        width: Annotated[int, Query(ge=1, le=10_000)] = 1000,
    ) -> Response:
        """Read a window of some channels, thinned to ``width`` pixels with the spikes kept."""
        if from_us >= to_us:
            raise ApiProblem(422, "invalid", "from_us must be before to_us")
        live, grants = live_of(request), who_of(request).grants
        signals = {each.address: (each.device, each.signal) for each in live.channels}
        for address in channel:
            if address not in signals or not sees_signal(
                grants, live.description, *signals[address]
            ):
                raise ApiProblem(404, "unknown", f"there is no channel {address!r}")
        found = await self._history.read(site, list(dict.fromkeys(channel)), from_us, to_us, width)
        # Encoded by msgspec: whole columns at a time, and NaN becomes null.
        body = msgspec.json.encode({"series": [_series(each) for each in found]})
        return Response(body, media_type="application/json")

    async def events(
        self, request: Request, site: str, limit: Annotated[int, Query(ge=1, le=1000)] = 100
    ) -> EventList:
        """List what happened at a site lately, of the devices you may view."""
        live, grants = live_of(request), who_of(request).grants
        entries = await self._audit.recent(site, limit)
        return EventList(
            events=[
                EventShape(
                    time_us=entry.time_us,
                    kind=entry.kind,
                    device=entry.device,
                    who=entry.who,
                    message=entry.message,
                    good=entry.good,
                )
                for entry in entries
                if allows(Need.VIEW, grants, live.description, entry.device)
            ]
        )


def _series(series: Series) -> dict[str, object]:
    texts = series.texts
    said: dict[str, object] = {
        "address": series.address,
        "kind": "exact" if series.exact else "minmax",
        "t_us": series.time_us.tolist(),
        "v": series.value.tolist(),
        "gaps": [
            {"from_us": gap.from_us, "to_us": gap.to_us, "reason": gap.reason}
            for gap in series.gaps
        ],
    }
    if texts:
        said["text"] = [texts.get(at, "") for at in range(len(series.time_us))]
    return said
