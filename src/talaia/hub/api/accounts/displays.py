"""Displays as an admin manages them, and the door by which a screen comes in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.clock import SECOND
from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import (
    DisplayAsk,
    DisplayList,
    DisplayOpenAsk,
    DisplayShape,
    NewDisplay,
)
from talaia.hub.auth.passwords import check_name
from talaia.hub.auth.rate_limiter import RateLimiter
from talaia.hub.errors import WeakPassword
from talaia.hub.store.accounts.displays import MOST_DISPLAYS

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.access import Access
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.ports import DescribedSites
    from talaia.hub.store.accounts.displays import Displays
    from talaia.hub.store.audit import Audit

__all__ = ["DisplayPages"]


class DisplayPages:
    """The routes of displays."""

    def __init__(
        self,
        *,
        displays: Displays,
        access: Access,
        seats: SocketSessions,
        sites: DescribedSites,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Work on ``displays``; the sockets of one that is revoked are closed at once."""
        self._displays = displays
        # Hands the token to the browser, in the session's cookie.
        self._access = access
        self._seats = seats
        self._sites = sites
        self._audit = audit
        self._clock = clock
        # Tries to come in, by address: a token of 256 bits is not guessed, the database is spared.
        self._pace = RateLimiter(burst=20, per_s=0.5)

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/displays")(self.overview)
        router.post("/api/displays")(self.add)
        router.delete("/api/displays/{display}", status_code=204)(self.remove)
        router.post("/api/displays/open", status_code=204)(self.open)
        return router

    async def overview(self) -> DisplayList:
        """List all displays, the newest first."""
        return DisplayList(
            displays=[
                DisplayShape(
                    id=str(one.id),
                    name=one.name,
                    sites=list(one.sites),
                    created_us=one.created_us,
                    used_us=one.used_us,
                )
                for one in await self._displays.list_displays()
            ]
        )

    async def add(self, asked: DisplayAsk, request: Request) -> NewDisplay:
        """Make a display that shows some sites. Its token is shown once, behind ``/display#``."""
        try:
            check_name(asked.name)
        except WeakPassword as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        for site in asked.sites:
            if self._sites.find_site(site) is None:
                raise ApiProblem(422, "invalid", f"there is no site {site!r}")
        made = await self._displays.add_display(asked.name, asked.sites)
        if made is None:
            raise ApiProblem(409, "busy", f"there are {MOST_DISPLAYS} displays; revoke some first")
        self._append_record(request, "display made", f"{asked.name}: {', '.join(asked.sites)}")
        return NewDisplay(id=str(made[0]), token=made[1])

    async def remove(self, display: str, request: Request) -> None:
        """Revoke a display; what it shows ends at once."""
        name = await self._displays.revoke_display(number_of(display, "display"))
        if name is None:
            raise ApiProblem(404, "unknown", "there is no such display")
        await self._seats.follow()
        self._append_record(request, "display revoked", name)

    async def open(self, asked: DisplayOpenAsk, request: Request, response: Response) -> None:
        """Let a screen in by its token, which it keeps in a cookie from then on."""
        address = address_of(request)
        wait_ns = self._pace.request_turn(address, self._clock.monotonic_ns())
        if wait_ns:
            raise ApiProblem(429, "busy", "too many tries; wait a little", -(-wait_ns // SECOND))
        found = await self._displays.find_session(asked.token)
        if found is None:
            self._audit.append_record("display refused", address=address, good=False)
            raise ApiProblem(401, "unauthorized", "this display is not known, or was revoked")
        self._access.set_display_cookie(response, asked.token)
        self._audit.append_record("display opened", address=address, message=found.who.name)

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        who = who_of(request).name
        self._audit.append_record(kind, who=who, address=address_of(request), message=message)
