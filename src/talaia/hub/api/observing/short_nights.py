"""A night in minutes, at the push of a button: only at sites that are simulated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.night_forms import night_state_shape
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.observing_schemas import NightAnswer
from talaia.hub.live.observing.observing_sites import filters_of, instrument_of, is_observatory
from talaia.hub.observing.charging import request_charge
from talaia.hub.observing.proposal_access import ProposalRole
from talaia.hub.observing.quotas import ProposalLimits
from talaia.hub.observing.short_night import (
    PROPOSAL,
    SHORT_NIGHT_S,
    high_targets,
    night_targets,
    short_night_group,
    whole_night_group,
)
from talaia.hub.store.observing.proposals import KeptProposal
from talaia.hub.store.observing.request_rows import KeptGroup

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.clock import Clock
    from talaia.hub.live.observing.night_board import NightBoard
    from talaia.hub.live.observing.observing_sites import ObservingNews
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.proposals import ProposalStore
    from talaia.hub.store.observing.request_store import RequestStore

__all__ = ["ShortNightPages"]


_SHORT = high_targets, short_night_group


class ShortNightPages:
    """The route of the button; which sites are simulated says who starts the hub.

    A description could not: it comes from a gateway, and could belong to a real roof.
    """

    def __init__(
        self,
        *,
        simulated: Collection[str],
        proposals: ProposalStore,
        requests: RequestStore,
        board: NightBoard,
        news: ObservingNews,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Ask in ``requests`` for short frames, and arm by ``board``."""
        self._simulated = frozenset(simulated)
        self._proposals = proposals
        self._requests = requests
        self._board = board
        self._news = news
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.post("/api/sites/{site}/night/short")(self.begin)
        return router

    async def begin(self, site: str, request: Request) -> NightAnswer:
        """Ask for a few short frames of what is high now, and arm the night for half an hour.

        Where the site lives faster than people do it is a whole night.
        """
        live, who = live_of(request), who_of(request)
        if site not in self._simulated:
            raise ApiProblem(409, "not_simulated", "only a simulated site has nights in minutes")
        place = live.description.place
        if not is_observatory(live.description) or place is None:
            raise ApiProblem(409, "no_night", "this site does not observe by itself")
        if live.link is None:
            raise ApiProblem(409, "offline", "the site's gateway is not connected")
        now = self._clock.wall_ns() / 1e9
        state = self._board.night_of(site).state
        whole = state is not None and state.speed > 0.0
        choose, ask = (night_targets, whole_night_group) if whole else _SHORT
        targets = choose(place.latitude, place.longitude, now)
        group = ask(targets, filters_of(live.description) or (), who.name, now)
        instrument = instrument_of(live.description)
        await self._make_proposal(site, who.name)
        await self._requests.add_group(
            KeptGroup(
                group=group,
                site=site,
                user=who.user,
                charges=tuple(request_charge(one, instrument) for one in group.requests),
                submitted_us=round(now * 1e6),
            ),
            # No quota: nobody's time is used up in a simulator.
            lambda _proposal, _person: [],
        )
        self._news.requests_changed(site)
        # A time lapse is armed to the end of its own night, of which nobody here knows the times.
        until = 0.0 if whole else now + SHORT_NIGHT_S
        answer = await self._board.ask_gateway(live, who.name, armed=True, until=until)
        refused = answer.refused if answer is not None else "the gateway has not answered"
        self._audit.append_record(
            "short night",
            who=who.name,
            address=address_of(request),
            site=site,
            message=refused or ", ".join(target.name for target in targets),
            good=not refused,
        )
        if answer is None:
            raise ApiProblem(409, "no_answer", "the gateway has not answered; look how it stands")
        heard_us = self._clock.wall_ns() // 1000
        return NightAnswer(state=night_state_shape(answer, heard_us), refused=refused)

    async def _make_proposal(self, site: str, who: str) -> None:
        if await self._proposals.find_proposal(site, PROPOSAL) is None:
            await self._proposals.add_proposal(
                KeptProposal(
                    site=site,
                    id=PROPOSAL,
                    title="Nights in minutes",
                    share=0.1,
                    limits=ProposalLimits(hours=10_000.0),
                    is_open=True,
                    needs_approval=False,
                )
            )
        await self._proposals.set_member(site, PROPOSAL, who, ProposalRole.MEMBER)
