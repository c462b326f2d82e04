"""What somebody may do with a request group as it stands. Pure; see decision 0090."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from talaia.hub.observing.proposal_access import ProposalAccess
    from talaia.hub.store.observing.request_rows import KeptGroup

__all__ = ["CANCELABLE", "GroupDeed", "group_deeds", "is_waiting", "may_ever"]

GroupDeed = Literal["edit", "submit", "withdraw", "approve", "cancel", "retry"]
CANCELABLE = frozenset(
    {RequestState.DRAFT, RequestState.PENDING, RequestState.FAILURE_LIMIT_REACHED}
)


def is_waiting(kept: KeptGroup) -> bool:
    """Tell whether a group is handed in and waits to be approved."""
    states = {request.state for request in kept.group.requests}
    return kept.submitted_us > 0 and RequestState.DRAFT in states


def group_deeds(kept: KeptGroup, access: ProposalAccess, *, mine: bool) -> list[GroupDeed]:
    """List what a person may do with a group now.

    Args:
        kept: the group.
        access: the person's to its proposal.
        mine: the person asked for it.

    """
    states = {request.state for request in kept.group.requests}
    handles = access.leads or (mine and access.asks)
    found: list[GroupDeed] = []
    if handles and kept.submitted_us == 0 and states == {RequestState.DRAFT}:
        found += ["edit", "submit"]
    if handles and kept.submitted_us and states & {RequestState.DRAFT, RequestState.PENDING}:
        found.append("withdraw")
    if access.approves and is_waiting(kept):
        found.append("approve")
    if handles and states & CANCELABLE:
        found.append("cancel")
    if access.approves and RequestState.FAILURE_LIMIT_REACHED in states:
        found.append("retry")
    return found


def may_ever(deed: GroupDeed, access: ProposalAccess, *, mine: bool) -> bool:
    """Tell whether a person may do it with a group that is in the right state."""
    if deed in {"approve", "retry"}:
        return access.approves
    return access.leads or (mine and access.asks)
