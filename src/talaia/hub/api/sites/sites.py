"""Sites and their events."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request

from talaia.hub.api.access import live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.missions.fleet_schemas import SharedCommandList
from talaia.hub.api.records.query_params import Time  # noqa: TC001 - FastAPI reads it
from talaia.hub.api.records.sightings import seen_shape
from talaia.hub.api.schemas.account_schemas import DeviceList
from talaia.hub.api.schemas.common import (
    EventList,
    EventShape,
    Health,
    SiteShape,
    SiteSummary,
)
from talaia.hub.api.sites.shared_commands import list_shared_commands
from talaia.hub.api.sites.site_views import describe_site, list_devices, summarise_site
from talaia.hub.auth.permissions import Right, sees_site
from talaia.hub.live.detection.sightings import KIND as SIGHTING
from talaia.hub.store.audit import PART_OF_ANOMALY, AuditFilter
from talaia.model.units.conversion import shown_units

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from talaia.clock import Clock
    from talaia.hub.api.schemas.sighting_schemas import SeenShape
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.accounts.shown_units import ShownUnits
    from talaia.hub.store.audit import Audit, AuditRecord
    from talaia.hub.store.sites.sightings import SightingStore

__all__ = ["SitePages"]

# The audit log's kinds about notes begin so.
_NOTE = "note "
# No database holds a NUL.
_Text = Annotated[str | None, Query(max_length=200, pattern=r"^[^\x00]*$")]


class SitePages:
    """The routes of sites."""

    def __init__(
        self,
        *,
        sites: Sites,
        shown: ShownUnits,
        audit: Audit,
        sightings: SightingStore,
        clock: Clock,
    ) -> None:
        """Answer from what is live and what was written down."""
        self._sites = sites
        # In which units people want to see values.
        self._shown = shown
        self._audit = audit
        self._sightings = sightings
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/health")(self.health)
        router.get("/api/ready")(self.ready)
        router.get("/api/sites")(self.overview)
        router.get("/api/devices")(self.devices)
        router.get("/api/commands")(self.commands)
        router.get("/api/sites/{site}")(self.one)
        router.get("/api/sites/{site}/events")(self.events)
        return router

    async def health(self) -> Health:
        """Say that the hub answers; no more, since nobody has to be signed in."""
        return Health(ok=True)

    async def ready(self) -> Health:
        """Say that requests may be sent here: for load balancers."""
        # Of a hub that is one of several, `ClusterHub` answers before this.
        return Health(ok=True)

    async def overview(self, request: Request) -> list[SiteSummary]:
        """List the sites that are open to you."""
        grants = who_of(request).grants
        # The clock by which samples are stamped when they come.
        now = self._clock.monotonic_ns()
        return [
            summarise_site(live, grants, now)
            async for live in self._site_by_site()
            if sees_site(grants, live.description)
        ]

    async def devices(self, request: Request) -> DeviceList:
        """List all devices that are open to you, with how each is."""
        grants, now = who_of(request).grants, self._clock.monotonic_ns()
        return DeviceList(
            devices=[
                device
                async for live in self._site_by_site()
                for device in list_devices(live, grants, now)
            ]
        )

    async def commands(self, request: Request) -> SharedCommandList:
        """List the commands that sites have in common, for a group of them to be asked for one.

        Each is asked for site by site, as a page asks for a single one.
        """
        grants = who_of(request).grants
        sites = [
            live.description
            async for live in self._site_by_site()
            if sees_site(grants, live.description)
        ]
        # In a thread: it takes up to a millisecond for each site.
        return SharedCommandList(
            commands=await asyncio.to_thread(list_shared_commands, sites, grants)
        )

    async def _site_by_site(self) -> AsyncIterator[LiveSite]:
        """Go through all sites; to sum one up takes up to a millisecond, so a thousand a second."""
        for live in self._sites:
            yield live
            # Whoever drives is served between two of them.
            await asyncio.sleep(0)

    async def one(self, request: Request, site: str) -> SiteShape:
        """Describe a site as far as it is open to you.

        ``unit`` is that of values as they are stored, sent and exported. ``shown`` and
        ``shown_units`` say in which other one a page is to show them to you.
        """
        live, who = live_of(request), who_of(request)
        choice = await self._shown.choice_of(who)
        # In a thread: a rare unit may take the import of a library.
        ways = await asyncio.to_thread(shown_units, choice, live.description.shown_units)
        return describe_site(live, who.grants, ways)

    async def events(
        self,
        *,
        request: Request,
        site: str,
        limit: Annotated[int, Query(ge=1, le=1000)] = 100,
        from_us: Time = 0,
        to_us: Time = 2**53,
        before: Time | None = None,
        kind: _Text = None,
        who: _Text = None,
        device: _Text = None,
        text: _Text = None,
        good: bool | None = None,
    ) -> EventList:
        """List what happened at a site, newest first, of the devices you may view.

        ``from_us`` and ``to_us`` are both included. ``before`` is the id of the last one of a
        page, for the next page; ``kind`` is its beginning, or several with commas between;
        ``text`` stands anywhere in it.
        A device that the description no longer has is open to those who have a right on it.
        """
        devices = who_of(request).grants.devices(Right.VIEW, site)
        wanted = AuditFilter(
            site=site,
            from_us=from_us,
            # The log's own end is not included.
            to_us=to_us + 1,
            before=before,
            kind=kind,
            who=who,
            device=device,
            text=text,
            good=good,
            # A note stands at the moment that it is about, and not where somebody wrote it. What
            # joins an episode of anomalies is listed when somebody asks for anomalies.
            without=_NOTE if kind else f"{_NOTE},{PART_OF_ANOMALY}",
            # Rows of other devices do not count for ``limit`` and ``more``, either.
            devices=devices,
        )
        rows, more = await self._audit.find_records(wanted, limit)
        sighted = await self._sightings_of(site, rows)
        return EventList(
            more=more,
            events=[
                EventShape(
                    id=str(number),
                    time_us=entry.time_us,
                    kind=entry.kind,
                    device=entry.device,
                    who=entry.who,
                    message=entry.message,
                    good=entry.good,
                    sighting=sighted.get((entry.time_us, entry.device)),
                )
                for number, entry in rows
                # A database may compare names without regard to case; a right does not.
                if devices is None or entry.device in devices
            ],
        )

    async def _sightings_of(
        self, site: str, rows: Sequence[AuditRecord]
    ) -> dict[tuple[int, str], SeenShape]:
        """Find the sightings that lines are about, by the time and the device of the line."""
        times = {row.entry.time_us for row in rows if row.entry.kind == SIGHTING}
        found = await self._sightings.find_noted(site, times)
        return {
            (sighting.noted_us, sighting.sighted.camera.partition("/")[0]): seen_shape(sighting)
            for sighting in found
        }
