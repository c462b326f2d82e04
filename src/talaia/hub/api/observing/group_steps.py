"""What is done with a request group: handed in, taken back, approved, ended, tried again."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.admission import GroupAdmission
from talaia.hub.api.observing.group_access import CANCELABLE
from talaia.hub.api.observing.group_lookup import group_shape
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.observing_schemas import (  # noqa: TC001 - FastAPI reads them
    GroupShape,
    ReasonAsk,
)
from talaia.hub.observing.changes import ImpossibleChange
from talaia.hub.store.observing.request_queries import GroupRefused, GroupStep
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.observing.group_lookup import FoundGroup, GroupLookup
    from talaia.hub.live.observing.observing_sites import ObservingNews
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.request_store import RequestStore

__all__ = ["GroupStepPages"]

_DRAFT = frozenset({RequestState.DRAFT})
_OPEN = frozenset({RequestState.DRAFT, RequestState.PENDING})
_FAILED = frozenset({RequestState.FAILURE_LIMIT_REACHED})


class GroupStepPages:
    """The routes by which groups change their state."""

    def __init__(
        self,
        *,
        requests: RequestStore,
        lookup: GroupLookup,
        news: ObservingNews,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Change them in ``requests``; gateways are told by ``news``."""
        self._requests = requests
        self._lookup = lookup
        self._news = news
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/request-groups/{group}"
        router.post(at + "/submit")(self.submit)
        router.post(at + "/withdraw")(self.withdraw)
        router.post(at + "/approve")(self.approve)
        router.post(at + "/cancel")(self.cancel)
        router.post(at + "/retry")(self.retry)
        return router

    async def submit(self, site: str, group: str, asked: ReasonAsk, request: Request) -> GroupShape:
        """Hand a draft in; it is observed once it is approved, where its proposal needs that."""
        found = await self._lookup.find_group(site, group, request, "submit")
        straight = not found.proposal.needs_approval or found.access.approves
        step = GroupStep(
            states=_DRAFT,
            after=RequestState.PENDING if straight else RequestState.DRAFT,
            who=who_of(request).name,
            why=asked.why or "handed in",
            submitted=True,
        )
        return await self._change(found, step, request, "request submitted")

    async def withdraw(
        self, site: str, group: str, asked: ReasonAsk, request: Request
    ) -> GroupShape:
        """Take a group back for a change, or send it back to whoever asked."""
        found = await self._lookup.find_group(site, group, request, "withdraw")
        step = GroupStep(
            states=_OPEN,
            after=RequestState.DRAFT,
            who=who_of(request).name,
            why=asked.why or "taken back",
            submitted=False,
        )
        return await self._change(found, step, request, "request withdrawn")

    async def approve(
        self, site: str, group: str, asked: ReasonAsk, request: Request
    ) -> GroupShape:
        """Let a group that was handed in be observed."""
        found = await self._lookup.find_group(site, group, request, "approve")
        step = GroupStep(
            states=_DRAFT,
            after=RequestState.PENDING,
            who=who_of(request).name,
            why=asked.why or "approved",
            approved=True,
        )
        return await self._change(found, step, request, "request approved")

    async def cancel(self, site: str, group: str, asked: ReasonAsk, request: Request) -> GroupShape:
        """End all of a group that has not ended."""
        found = await self._lookup.find_group(site, group, request, "cancel")
        step = GroupStep(
            states=CANCELABLE,
            after=RequestState.CANCELED,
            who=who_of(request).name,
            why=asked.why or "canceled",
        )
        return await self._change(found, step, request, "request canceled")

    async def retry(self, site: str, group: str, asked: ReasonAsk, request: Request) -> GroupShape:
        """Let what failed too often be tried again, after somebody has looked at it."""
        found = await self._lookup.find_group(site, group, request, "retry")
        step = GroupStep(
            states=_FAILED,
            after=RequestState.PENDING,
            who=who_of(request).name,
            why=asked.why or "tried again",
        )
        return await self._change(found, step, request, "request tried again")

    async def _change(
        self, found: FoundGroup, step: GroupStep, request: Request, kind: str
    ) -> GroupShape:
        kept = found.kept
        site, number = kept.site, int(kept.group.id)
        now = self._clock.wall_ns() / 1e9
        # Held against the quotas when it is handed in; who approves decides for themselves.
        admit = GroupAdmission(kept, live_of(request).description, now) if step.submitted else None
        try:
            await self._requests.change_group(site, number, step, admit)
        except GroupRefused as error:
            raise ApiProblem(422, "refused", str(error)) from error
        except ImpossibleChange as error:
            raise ApiProblem(409, "state", str(error)) from error
        self._audit.append_record(
            kind,
            who=step.who,
            address=address_of(request),
            site=site,
            message=f"{number} of {kept.group.proposal}: {step.why}",
        )
        self._news.requests_changed(site)
        after = await self._lookup.find_group(site, kept.group.id, request)
        return group_shape(after, who_of(request).user)
