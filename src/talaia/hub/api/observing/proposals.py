"""Proposals: made and changed by admins of their site, seen by whom they concern."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, known_live_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.group_lookup import access_of, role_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.ability_schemas import AbilitiesShape, FieldShape, SettingRangeShape
from talaia.hub.api.schemas.observing_schemas import (
    MemberAsk,
    MemberShape,
    ProposalAsk,
    ProposalChange,
    ProposalList,
    ProposalShape,
)
from talaia.hub.auth.permissions import Right
from talaia.hub.errors import NameTaken, UnknownPerson
from talaia.hub.live.observing.observing_sites import is_observatory
from talaia.hub.observing.quotas import ProposalLimits
from talaia.hub.observing.site_abilities import site_abilities
from talaia.hub.store.observing.proposals import KeptProposal, ProposalInUse
from talaia.model.observing.requests import Urgency

if TYPE_CHECKING:
    from talaia.hub.live.observing.observing_sites import ObservingNews
    from talaia.hub.observing.site_abilities import SiteAbilities
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.proposals import ProposalStore

__all__ = ["ProposalPages"]


class ProposalPages:
    """The routes of proposals."""

    def __init__(self, store: ProposalStore, news: ObservingNews, audit: Audit) -> None:
        """Keep them in ``store``; gateways are told what changes by ``news``."""
        self._store = store
        self._news = news
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/proposals"
        router.get(at)(self.overview)
        router.post(at, status_code=201)(self.add)
        router.put(at + "/{proposal}", status_code=204)(self.change)
        router.delete(at + "/{proposal}", status_code=204)(self.remove)
        router.put(at + "/{proposal}/members", status_code=204)(self.set_member)
        return router

    async def overview(self, site: str, request: Request) -> ProposalList:
        """List the proposals that are open to you, and what you may do at the site's nights."""
        grants = who_of(request).grants
        found = [
            shape
            for kept in await self._store.list_proposals(site)
            if (shape := _proposal_shape(kept, request)) is not None
        ]
        described = live_of(request).description
        may_request = grants.has_right(Right.REQUEST, site)
        return ProposalList(
            observes=is_observatory(described),
            may_request=may_request,
            may_approve=grants.has_right(Right.APPROVE, site),
            may_arm=grants.has_right(Right.ARM, site),
            may_manage=grants.has_right(Right.ADMIN, site),
            abilities=_abilities_shape(site_abilities(described)) if may_request else None,
            proposals=found,
        )

    async def add(self, site: str, asked: ProposalAsk, request: Request) -> None:
        """Make a proposal; its members are set one by one."""
        if not is_observatory(known_live_of(request).description):
            raise ApiProblem(
                409,
                "no_night",
                "this site does not observe by itself: it has no night:",
            )
        try:
            await self._store.add_proposal(_read_proposal(site, asked.id, asked))
        except NameTaken as error:
            raise ApiProblem(409, "taken", str(error)) from error
        self._changed(request, site, "proposal added", f"{asked.id}: {_in_words(asked)}")

    async def change(
        self, site: str, proposal: str, asked: ProposalChange, request: Request
    ) -> None:
        """Change a proposal, or end it (not ``active``)."""
        if not await self._store.change_proposal(_read_proposal(site, proposal, asked)):
            raise _unknown()
        self._changed(request, site, "proposal changed", f"{proposal}: {_in_words(asked)}")

    async def remove(self, site: str, proposal: str, request: Request) -> None:
        """Remove a proposal for which nothing was ever asked."""
        try:
            if not await self._store.remove_proposal(site, proposal):
                raise _unknown()
        except ProposalInUse as error:
            raise ApiProblem(409, "in_use", str(error)) from error
        self._changed(request, site, "proposal removed", proposal)

    async def set_member(
        self, site: str, proposal: str, asked: MemberAsk, request: Request
    ) -> None:
        """Let an account be in a proposal, in another role, or no more."""
        try:
            if not await self._store.set_member(site, proposal, asked.name, asked.role):
                raise _unknown()
        except UnknownPerson as error:
            raise ApiProblem(404, "unknown", str(error)) from error
        role = asked.role.value if asked.role is not None else "no member"
        self._changed(request, site, "proposal member", f"{proposal}: {asked.name}: {role}")

    def _changed(self, request: Request, site: str, kind: str, message: str) -> None:
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=site,
            message=message,
        )
        self._news.requests_changed(site)


def _unknown() -> ApiProblem:
    return ApiProblem(404, "unknown", "there is no such proposal")


def _abilities_shape(abilities: SiteAbilities | None) -> AbilitiesShape | None:
    if abilities is None:
        return None
    said = abilities._asdict()
    for name in ("exposure", "binning", "gain"):
        said[name] = SettingRangeShape(**said[name]._asdict()) if said[name] is not None else None
    field = abilities.field
    said["field"] = (
        FieldShape(
            width=field.width,
            height=field.height,
            position_angle=field.position_angle,
            rotates=field.rotator is not None,
        )
        if field is not None
        else None
    )
    return AbilitiesShape(**said)


def _proposal_shape(kept: KeptProposal, request: Request) -> ProposalShape | None:
    """Write a proposal for somebody; None: it is not open to them."""
    role, access = role_of(kept, request), access_of(kept, request)
    if not access.sees:
        return None
    # Who is in it is for those who are, and for those who decide on it.
    named = role is not None or access.approves
    return ProposalShape(
        id=kept.id,
        title=kept.title,
        share=kept.share,
        hours_allocated=kept.limits.hours,
        person_hours=kept.limits.person_hours,
        max_priority=kept.limits.max_priority,
        urgencies=sorted(kept.limits.urgencies),
        active=kept.limits.active,
        is_open=kept.is_open,
        needs_approval=kept.needs_approval,
        used_s=kept.account.used,
        promised_s=kept.account.promised,
        role=role,
        may_ask=access.asks,
        may_lead=access.leads,
        members=[MemberShape(name=member.name, role=member.role) for member in kept.members]
        if named
        else [],
    )


def _read_proposal(site: str, proposal: str, asked: ProposalChange) -> KeptProposal:
    return KeptProposal(
        site=site,
        id=proposal,
        title=asked.title,
        share=asked.share,
        limits=ProposalLimits(
            hours=asked.hours_allocated,
            person_hours=asked.person_hours,
            max_priority=asked.max_priority,
            urgencies=frozenset(asked.urgencies) - {Urgency.NORMAL},
            active=asked.active,
        ),
        is_open=asked.is_open,
        needs_approval=asked.needs_approval,
    )


def _in_words(asked: ProposalChange) -> str:
    said = [f"{asked.hours_allocated:g} h", f"share {asked.share:g}"]
    said += [urgency.value for urgency in asked.urgencies]
    said += ["open"] if asked.is_open else []
    said += ["needs approval"] if asked.needs_approval else []
    return ", ".join([*said, "active" if asked.active else "ended"])
