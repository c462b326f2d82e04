"""Other hubs as an admin manages them, and the door by which their signed heads come in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from talaia.clock import SECOND
from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.common import (
    HeadsAsk,
    HeadsKept,
    NewWitnessedHub,
    WitnessedHubAsk,
    WitnessedHubList,
    WitnessedHubShape,
)
from talaia.hub.auth.passwords import check_name
from talaia.hub.auth.rate_limiter import RateLimiter
from talaia.hub.errors import HeadsRefused, WeakPassword
from talaia.hub.store.witnessed_hubs import MOST_HUBS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from talaia.clock import Clock
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.witnessed_hubs import WitnessedHubs

__all__ = ["WitnessedHubPages"]


class WitnessedHubPages:
    """The routes of other hubs' heads."""

    def __init__(self, *, hubs: WitnessedHubs, audit: Audit, clock: Clock) -> None:
        """Work on ``hubs``; what does not fit together is told in ``audit``, too."""
        self._hubs = hubs
        self._audit = audit
        self._clock = clock
        # By address; a hub asks once a minute at the most, but several may be behind one address.
        self._pace = RateLimiter(burst=60, per_s=1.0)

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/audit/hubs")(self.overview)
        router.post("/api/audit/hubs")(self.add)
        router.delete("/api/audit/hubs/{hub}", status_code=204)(self.remove)
        router.get("/api/audit/hubs/{hub}/heads", response_class=StreamingResponse)(self.export)
        router.post("/api/heads")(self.receive)
        return router

    async def overview(self) -> WitnessedHubList:
        """List the hubs whose signed heads are kept here, the newest first."""
        return WitnessedHubList(
            hubs=[
                WitnessedHubShape(**{**hub._asdict(), "id": str(hub.id)})
                for hub in await self._hubs.list_hubs()
            ]
        )

    async def add(self, asked: WitnessedHubAsk, request: Request) -> NewWitnessedHub:
        """Let another hub leave its heads here. Its token is shown once and opens nothing else."""
        try:
            check_name(asked.name)
        except WeakPassword as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        made = await self._hubs.add_hub(asked.name, asked.keep_days)
        if made is None:
            raise ApiProblem(409, "busy", f"there are {MOST_HUBS} hubs; remove some first")
        self._append_record(request, "other hub added", f"{asked.name}, {asked.keep_days} days")
        return NewWitnessedHub(id=str(made[0]), token=made[1])

    async def remove(self, hub: str, request: Request) -> None:
        """Remove another hub with all heads that it has left here."""
        name = await self._hubs.remove_hub(number_of(hub, "hub"))
        if name is None:
            raise ApiProblem(404, "unknown", "there is no such hub")
        self._append_record(request, "other hub removed", f"{name}, with its heads")

    async def export(self, hub: str) -> StreamingResponse:
        """Give a hub's heads as lines, for ``talaia audit verify --heads`` on its machine."""
        number = number_of(hub, "hub")
        if number not in {one.id for one in await self._hubs.list_hubs()}:
            raise ApiProblem(404, "unknown", "there is no such hub")
        return StreamingResponse(
            self._write_lines(number),
            media_type="text/plain; charset=utf-8",
            headers={"Content-Disposition": f'attachment; filename="audit-heads-{number}.log"'},
        )

    async def receive(self, asked: HeadsAsk, request: Request) -> HeadsKept:
        """Leave signed heads here, as another hub; those that are here already do no harm."""
        address = address_of(request)
        wait_ns = self._pace.request_turn(address, self._clock.monotonic_ns())
        if wait_ns:
            raise ApiProblem(429, "busy", "too many tries; wait a little", -(-wait_ns // SECOND))
        found = await self._hubs.find_hub(asked.token)
        if found is None:
            self._audit.append_record("other hub refused", address=address, good=False)
            raise ApiProblem(401, "unauthorized", "this hub is not known here, or was removed")
        number, name = found
        try:
            problem = await self._hubs.keep_heads(number, asked.key, asked.lines)
        except HeadsRefused as error:
            if await self._hubs.mark_refused(number, str(error)):
                self._tell_problem(address, name, str(error))
            raise ApiProblem(422, "heads", str(error)) from error
        if problem:
            self._tell_problem(address, name, problem)
        return HeadsKept(kept=len(asked.lines))

    async def _write_lines(self, number: int) -> AsyncIterator[str]:
        async for line in self._hubs.iterate_lines(number):
            yield f"{line}\n"

    def _tell_problem(self, address: str, name: str, problem: str) -> None:
        self._audit.append_record(
            "other hub's log does not fit",
            address=address,
            message=f"{name}: {problem}",
            good=False,
        )

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        who = who_of(request).name
        self._audit.append_record(kind, who=who, address=address_of(request), message=message)
