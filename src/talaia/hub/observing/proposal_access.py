"""Who sees a proposal and its requests, and who may ask in its name. Pure; see decision 0090."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.auth.permissions import Right

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants

__all__ = ["ProposalAccess", "ProposalRole", "proposal_access"]


class ProposalRole(StrEnum):
    """What somebody is in a proposal."""

    PRINCIPAL_INVESTIGATOR = "principal_investigator"
    MEMBER = "member"


class ProposalAccess(NamedTuple):
    """What somebody may with a proposal.

    Attributes:
        sees: its requests, with their targets.
        asks: requests in its name.
        leads: changes requests of others in it, and ends them.
        approves: lets its requests be observed.

    """

    sees: bool = False
    asks: bool = False
    leads: bool = False
    approves: bool = False


def proposal_access(
    grants: Grants, site: str, role: ProposalRole | None, *, is_open: bool
) -> ProposalAccess:
    """Work out what a person may.

    Args:
        grants: the person's rights.
        site: whose proposal it is.
        role: the person's in the proposal; none: no member.
        is_open: whoever may view the site sees its requests.

    """
    approves = grants.has_right(Right.APPROVE, site)
    requests = grants.has_right(Right.REQUEST, site)
    return ProposalAccess(
        sees=role is not None or approves or (is_open and grants.has_right(Right.VIEW, site)),
        # Membership gives no right, and the right no membership: it takes both.
        asks=role is not None and requests,
        leads=approves or (role is ProposalRole.PRINCIPAL_INVESTIGATOR and requests),
        approves=approves,
    )
