"""Request groups looked up for somebody: what they do not see is as if it were not there."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.api.access import number_of, who_of
from talaia.hub.api.observing.group_access import group_deeds, is_waiting, may_ever
from talaia.hub.api.observing.request_forms import request_shape
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.observing_schemas import GroupShape
from talaia.hub.auth.permissions import Right
from talaia.hub.observing.proposal_access import proposal_access

if TYPE_CHECKING:
    from fastapi import Request

    from talaia.hub.api.observing.group_access import GroupDeed
    from talaia.hub.observing.proposal_access import ProposalAccess, ProposalRole
    from talaia.hub.store.observing.proposals import KeptProposal, ProposalStore
    from talaia.hub.store.observing.request_rows import KeptGroup
    from talaia.hub.store.observing.request_store import RequestStore

__all__ = ["FoundGroup", "GroupLookup", "access_of", "group_shape", "role_of"]


class FoundGroup(NamedTuple):
    """A group, its proposal, and what the person who asks may with them."""

    kept: KeptGroup
    proposal: KeptProposal
    access: ProposalAccess
    deeds: list[GroupDeed]


class GroupLookup:
    """Finds groups and proposals, with the rights of whoever asks."""

    def __init__(self, proposals: ProposalStore, requests: RequestStore) -> None:
        """Find them in these."""
        self._proposals = proposals
        self._requests = requests

    async def find_group(
        self, site: str, group: str, request: Request, deed: GroupDeed | None = None
    ) -> FoundGroup:
        """Find a group that somebody may see, and with which they may do something now.

        Raises:
            ApiProblem: 404 it is not there, or not open to them; 403 they may not do it; 409 it
                cannot be done as the group stands.

        """
        kept = await self._requests.find_group(site, number_of(group, "request group"))
        if kept is None:
            raise _unknown("request group")
        found = await self.open_group(kept, request, "request group")
        if deed is None or deed in found.deeds:
            return found
        if not may_ever(deed, found.access, mine=kept.user == who_of(request).user):
            raise ApiProblem(403, "forbidden", "you do not have the right to do this")
        stand = ", ".join(sorted({one.state.value for one in kept.group.requests}))
        raise ApiProblem(409, "state", f"that cannot be done now: the group is {stand}")

    async def open_group(self, kept: KeptGroup, request: Request, what: str) -> FoundGroup:
        """Give a group with what somebody may do.

        Raises:
            ApiProblem: 404, it is not open to them; ``what`` says what is not there.

        """
        proposal = await self._proposals.find_proposal(kept.site, kept.group.proposal)
        if proposal is None:
            raise _unknown(what)
        access = access_of(proposal, request)
        if not access.sees:
            raise _unknown(what)
        mine = kept.user == who_of(request).user
        return FoundGroup(kept, proposal, access, group_deeds(kept, access, mine=mine))

    async def asked_proposal(self, site: str, name: str, request: Request) -> KeptProposal:
        """Find a proposal in whose name somebody asks.

        Raises:
            ApiProblem: 422 it is not there, or not open to them; 403 they are no member.

        """
        found = await self._proposals.find_proposal(site, name)
        access = access_of(found, request) if found is not None else None
        if found is None or access is None or not access.sees:
            raise ApiProblem(422, "invalid", f"proposal: there is no proposal {name!r}")
        if not access.asks:
            raise ApiProblem(403, "forbidden", "you are no member of this proposal")
        return found


def access_of(proposal: KeptProposal, request: Request) -> ProposalAccess:
    """Give what whoever asks may with a proposal."""
    return proposal_access(
        who_of(request).grants,
        proposal.site,
        role_of(proposal, request),
        is_open=proposal.is_open,
    )


def role_of(proposal: KeptProposal, request: Request) -> ProposalRole | None:
    """Give what whoever asks is in a proposal; None: no member."""
    who = who_of(request)
    # A token has some of its person's rights: that person's memberships are not among them
    # unless it may ask for observations at all.
    if who.script and not who.grants.has_right(Right.REQUEST, proposal.site):
        return None
    return proposal.role_of(who.user)


def group_shape(found: FoundGroup, user: int) -> GroupShape:
    """Write a group for a page of this account."""
    kept, group = found.kept, found.kept.group
    return GroupShape(
        id=group.id,
        proposal=group.proposal,
        name=group.name,
        requester=group.requester,
        mine=kept.user == user,
        operator=group.operator,
        urgency=group.urgency,
        priority=group.priority,
        created_us=round(group.created_at * 1e6),
        submitted_us=kept.submitted_us,
        approved_us=kept.approved_us,
        approved_by=kept.approved_by,
        waits=is_waiting(kept),
        charge_s=kept.charge,
        requests=[
            request_shape(request, charge)
            for request, charge in zip(group.requests, kept.charges, strict=True)
        ],
        may=found.deeds,
    )


def _unknown(what: str) -> ApiProblem:
    return ApiProblem(404, "unknown", f"there is no such {what}")
