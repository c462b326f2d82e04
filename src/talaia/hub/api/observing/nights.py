"""The night of a site: how it stands, what is planned, armed and disarmed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.group_lookup import access_of
from talaia.hub.api.observing.night_forms import night_state_shape, plan_shape
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.observing_schemas import (
    NightAnswer,
    NightArmAsk,
    ReasonAsk,
    SiteNightShape,
)
from talaia.hub.live.observing.observing_sites import is_observatory

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from talaia.clock import Clock
    from talaia.hub.live.observing.night_board import NightBoard
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.proposals import ProposalStore
    from talaia.hub.store.observing.request_queries import PlannedRequest
    from talaia.hub.store.observing.request_store import RequestStore

__all__ = ["NightPages", "seen_requests"]


class NightPages:
    """The routes of nights."""

    def __init__(
        self,
        *,
        board: NightBoard,
        proposals: ProposalStore,
        requests: RequestStore,
        simulated: Collection[str],
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Answer from ``board``; who sees which request is asked of the stores."""
        self._simulated = frozenset(simulated)
        self._board = board
        self._proposals = proposals
        self._requests = requests
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/night"
        router.get(at)(self.night)
        router.post(at + "/arm")(self.arm)
        router.post(at + "/disarm")(self.disarm)
        return router

    async def night(self, site: str, request: Request) -> SiteNightShape:
        """Tell how the night stands and what its gateway plans, as it said last."""
        night = self._board.night_of(site)
        plan = night.plan.plan if night.plan is not None else None
        planned = [block.request for block in plan.blocks] if plan is not None else []
        seen = await seen_requests(self._proposals, self._requests, request, planned)
        return SiteNightShape(
            online=live_of(request).online,
            simulated=site in self._simulated,
            time_lapse=self._time_lapse() if site in self._simulated else "",
            state=night_state_shape(night.state, night.state_us) if night.state else None,
            plan=plan_shape(plan, seen) if plan is not None else None,
        )

    def _time_lapse(self) -> str:
        """Name the simulated site whose gateway says that it lives faster than people do."""
        for name in self._simulated:
            state = self._board.night_of(name).state
            if state is not None and state.speed > 0.0:
                return name
        return ""

    async def arm(self, asked: NightArmAsk, request: Request) -> NightAnswer:
        """Let the night run by itself; the gateway's own rules still say when a roof opens."""
        if asked.until_us and asked.until_us <= self._clock.wall_ns() // 1000:
            raise ApiProblem(422, "invalid", "until_us: expected a moment to come, or 0")
        return await self._ask(request, armed=True, until=asked.until_us / 1e6)

    async def disarm(self, asked: ReasonAsk, request: Request) -> NightAnswer:
        """End it: the exposure is aborted, telescope and roof park and close."""
        return await self._ask(request, armed=False, why=asked.why)

    async def _ask(
        self, request: Request, *, armed: bool, until: float = 0.0, why: str = ""
    ) -> NightAnswer:
        live, who = live_of(request), who_of(request)
        if not is_observatory(live.description):
            raise ApiProblem(409, "no_night", "this site does not observe by itself")
        if live.link is None:
            raise ApiProblem(409, "offline", "the site's gateway is not connected")
        answer = await self._board.ask_gateway(live, who.name, armed=armed, until=until, why=why)
        refused = answer.refused if answer is not None else "the gateway has not answered"
        self._audit.append_record(
            "night armed" if armed else "night disarmed",
            who=who.name,
            address=address_of(request),
            site=live.name,
            message=refused or why,
            good=not refused,
        )
        if answer is None:
            # It may have been done: the next state of the night tells.
            raise ApiProblem(409, "no_answer", "the gateway has not answered; look how it stands")
        heard_us = self._clock.wall_ns() // 1000
        return NightAnswer(state=night_state_shape(answer, heard_us), refused=refused)


async def seen_requests(
    proposals: ProposalStore, requests: RequestStore, request: Request, ids: Iterable[str]
) -> dict[str, PlannedRequest]:
    """Give those of these requests that are open to whoever asks, by their ids."""
    site = live_of(request).name
    listed = await proposals.list_proposals(site)
    seen = {kept.id for kept in listed if access_of(kept, request).sees}
    found = await requests.describe_requests(site, ids) if seen else {}
    return {one: known for one, known in found.items() if known.proposal in seen}
