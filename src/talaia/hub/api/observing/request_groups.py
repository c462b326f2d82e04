"""Request groups: handed in or kept as drafts; requests listed, each with its log."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import msgspec
from fastapi import APIRouter, Query, Request

from talaia.hub.api.access import address_of, live_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.admission import GroupAdmission
from talaia.hub.api.observing.group_lookup import access_of, group_shape
from talaia.hub.api.observing.night_forms import why_not_shape
from talaia.hub.api.observing.request_forms import read_group, request_shape
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.query_params import Word  # noqa: TC001 - FastAPI reads it
from talaia.hub.api.schemas.observing_schemas import (
    GroupAsk,
    GroupShape,
    ObservationShape,
    RequestDetail,
    RequestList,
    RequestLogLine,
    RequestRow,
    WhyNotShape,
)
from talaia.hub.live.observing.observing_sites import instrument_of
from talaia.hub.observing.charging import request_charge
from talaia.hub.store.observing.request_queries import GroupRefused, RequestFilter
from talaia.hub.store.observing.request_rows import KeptGroup
from talaia.model.observing.requests import Urgency
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.observing.group_lookup import GroupLookup
    from talaia.hub.live.observing.night_board import NightBoard
    from talaia.hub.live.observing.observing_sites import ObservingNews
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.observations import KeptObservation, ObservationStore
    from talaia.hub.store.observing.proposals import KeptProposal, ProposalStore
    from talaia.hub.store.observing.request_queries import RequestLine, RequestSummary
    from talaia.hub.store.observing.request_store import RequestStore

__all__ = ["RequestPages"]


class RequestPages:
    """The routes by which requests are asked for and found."""

    def __init__(
        self,
        *,
        proposals: ProposalStore,
        requests: RequestStore,
        observations: ObservationStore,
        lookup: GroupLookup,
        board: NightBoard,
        news: ObservingNews,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Keep them in ``requests``; gateways are told what changes by ``news``."""
        self._proposals = proposals
        self._requests = requests
        self._observations = observations
        self._lookup = lookup
        # Why each is not observed now, as its gateway said.
        self._board = board
        self._news = news
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/request-groups"
        router.post(at, status_code=201)(self.add)
        router.get(at + "/{group}")(self.group)
        router.put(at + "/{group}")(self.replace)
        router.post(at + "/{group}/clone", status_code=201)(self.clone)
        router.get("/api/sites/{site}/requests")(self.find)
        router.get("/api/sites/{site}/requests/{number}")(self.detail)
        return router

    async def find(
        self,
        *,
        request: Request,
        site: str,
        proposal: Word = "",
        state: RequestState | None = None,
        text: Word = "",
        mine: bool = False,
        waiting: bool = False,
        before: Annotated[int | None, Query(ge=0, le=2**53)] = None,
        limit: Annotated[int, Query(ge=1, le=500)] = 100,
    ) -> RequestList:
        """List the requests that are open to you, the newest first.

        ``waiting``: handed in and not yet approved. ``before`` is the id of the last one of a
        page, for the next page.
        """
        user = who_of(request).user
        seen = {
            kept.id
            for kept in await self._proposals.list_proposals(site)
            if (not proposal or kept.id == proposal) and access_of(kept, request).sees
        }
        asked = RequestFilter(
            proposals=seen,
            user=user if mine else None,
            states={state} if state is not None else (),
            text=text,
            waiting=waiting,
            before=before,
        )
        found, more = await self._requests.list_requests(site, asked, limit)
        # A database may compare names without regard to case; a right does not.
        reasons = self._board.night_of(site).why_not
        rows = [
            _row_shape(one, user, why_not_shape(reasons.get(str(one.id))))
            for one in found
            if one.proposal in seen
        ]
        return RequestList(requests=rows, more=more)

    async def detail(self, site: str, number: str, request: Request) -> RequestDetail:
        """Give a request with its group, the log of its states and its observations."""
        wanted = number_of(number, "request")
        found = await self._requests.find_request(site, wanted)
        if found is None:
            raise ApiProblem(404, "unknown", "there is no such request")
        kept, at = found
        group = await self._lookup.open_group(kept, request, "request")
        observed = await self._observations.observations_of(site, wanted)
        return RequestDetail(
            request=request_shape(kept.group.requests[at], kept.charges[at]),
            group=group_shape(group, who_of(request).user),
            why_not=why_not_shape(self._board.night_of(site).why_not.get(number)),
            log=[_line_shape(line) for line in await self._requests.read_log(wanted)],
            observations=[_observation_shape(one) for one in observed],
        )

    async def group(self, site: str, group: str, request: Request) -> GroupShape:
        """Give a request group as it stands, and what you may do with it."""
        found = await self._lookup.find_group(site, group, request)
        return group_shape(found, who_of(request).user)

    async def add(self, site: str, asked: GroupAsk, request: Request) -> GroupShape:
        """Hand requests in, or keep them as a draft."""
        proposal = await self._lookup.asked_proposal(site, asked.proposal, request)
        kept = self._read(asked, proposal, request)
        admit = GroupAdmission(kept, live_of(request).description, self._now())
        try:
            number = await self._requests.add_group(kept, None if asked.draft else admit)
        except GroupRefused as error:
            raise ApiProblem(422, "refused", str(error)) from error
        kind = "request kept as a draft" if asked.draft else "request submitted"
        self._record(request, kind, kept, number)
        self._news.requests_changed(site)
        return await self.group(site, str(number), request)

    async def replace(self, site: str, group: str, asked: GroupAsk, request: Request) -> GroupShape:
        """Write a draft anew. It stays one (``draft``): it is submitted by a request of its own."""
        await self._lookup.find_group(site, group, request, "edit")
        if not asked.draft:
            raise ApiProblem(422, "invalid", "draft: expected true; submit it after that")
        proposal = await self._lookup.asked_proposal(site, asked.proposal, request)
        kept = self._read(asked, proposal, request)
        if not await self._requests.replace_draft(int(group), kept, who_of(request).name):
            raise ApiProblem(409, "state", "it is no draft any more")
        self._record(request, "request draft changed", kept, int(group))
        return await self.group(site, group, request)

    async def clone(self, site: str, group: str, request: Request) -> GroupShape:
        """Make a draft of your own that asks the same once more."""
        found = await self._lookup.find_group(site, group, request)
        if not found.access.asks:
            raise ApiProblem(403, "forbidden", "you are no member of this proposal")
        who, asked = who_of(request), found.kept.group
        again = msgspec.structs.replace(
            asked,
            requester=who.name,
            requests=tuple(
                msgspec.structs.replace(one, state=RequestState.DRAFT) for one in asked.requests
            ),
        )
        kept = KeptGroup(group=again, site=site, user=who.user, charges=found.kept.charges)
        number = await self._requests.add_group(kept, None)
        self._record(request, "request kept as a draft", kept, number)
        return await self.group(site, str(number), request)

    def _read(self, asked: GroupAsk, proposal: KeptProposal, request: Request) -> KeptGroup:
        who, site = who_of(request), live_of(request).description
        # An approver's own needs nobody else.
        waits = proposal.needs_approval and not access_of(proposal, request).approves
        straight = not asked.draft and not waits
        state = RequestState.PENDING if straight else RequestState.DRAFT
        group = read_group(asked, who.name, state)
        instrument = instrument_of(site)
        return KeptGroup(
            group=group,
            site=site.site,
            user=who.user,
            charges=tuple(request_charge(one, instrument) for one in group.requests),
            submitted_us=0 if asked.draft else self._clock.wall_ns() // 1000,
        )

    def _record(self, request: Request, kind: str, kept: KeptGroup, number: int) -> None:
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=kept.site,
            message=f"{number} of {kept.group.proposal}: {len(kept.group.requests)} requests,"
            f" charged {kept.charge / 3600:.2f} h",
        )

    def _now(self) -> float:
        return self._clock.wall_ns() / 1e9


def _row_shape(one: RequestSummary, user: int, why_not: WhyNotShape | None) -> RequestRow:
    return RequestRow(
        id=str(one.id),
        group=str(one.group),
        group_name=one.group_name,
        proposal=one.proposal,
        requester=one.requester,
        mine=one.user == user,
        target=one.target,
        state=one.state,
        urgency=Urgency(one.urgency),
        priority=one.priority,
        charge_s=one.charge,
        start_us=one.start_us,
        end_us=one.end_us,
        changed_us=one.changed_us,
        waits=one.submitted and one.state is RequestState.DRAFT,
        # A plan of before knows nothing of what has happened since.
        why_not=why_not if one.state is RequestState.PENDING else None,
    )


def _line_shape(line: RequestLine) -> RequestLogLine:
    return RequestLogLine(
        time_us=line.time_us,
        who=line.who,
        before=RequestState(line.before) if line.before else None,
        after=RequestState(line.after),
        why=line.why,
    )


def _observation_shape(one: KeptObservation) -> ObservationShape:
    return ObservationShape(
        id=one.id,
        state=one.state,
        cause=one.cause,
        why=one.why,
        began_us=one.began_us,
        changed_us=one.changed_us,
        frames_done=one.frames_done,
        charge_s=one.block_s,
        files=one.files,
    )
