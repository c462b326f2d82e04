"""Whether a request group fits its proposal: time, priority, urgency. Pure; says all that is wrong.

Time counts as used when it was observed and as promised while it waits, so that ten people who ask
at once cannot promise the same hours ten times.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.observing.requests import Urgency

if TYPE_CHECKING:
    from talaia.model.observing.requests import RequestGroup

__all__ = ["ProposalLimits", "TimeAccount", "quota_problems"]

_HOUR = 3600.0


class ProposalLimits(NamedTuple):
    """What a proposal allows.

    Attributes:
        hours: block time in all (h).
        person_hours: of each member (h); 0: as much as there is.
        max_priority: of a group.
        urgencies: which may be asked for; normal always may.
        active: an ended one takes no requests.

    """

    hours: float
    person_hours: float = 0.0
    max_priority: float = 20.0
    urgencies: frozenset[Urgency] = frozenset()
    active: bool = True


class TimeAccount(NamedTuple):
    """Time that was observed, and time that is asked for and still waits (s)."""

    used: float = 0.0
    promised: float = 0.0


def quota_problems(
    group: RequestGroup,
    charge: float,
    limits: ProposalLimits,
    *,
    proposal: TimeAccount,
    person: TimeAccount,
) -> list[str]:
    """List why a group cannot be asked for, in words; empty: it can.

    Args:
        group: what is asked.
        charge: its estimate (s).
        limits: of the proposal.
        proposal: what the proposal has used and promised, without this group.
        person: likewise, of who asks.

    """
    found = []
    if not limits.active:
        found.append("the proposal has ended and takes no requests")
    if group.priority > limits.max_priority:
        found.append(
            f"priority {group.priority:g} is more than this proposal may ask"
            f" (up to {limits.max_priority:g})"
        )
    if group.urgency is not Urgency.NORMAL and group.urgency not in limits.urgencies:
        found.append(f"this proposal may not ask for {group.urgency.value}")
    accounts = [("the proposal", limits.hours, proposal)]
    if limits.person_hours:
        accounts.append(("your share of it", limits.person_hours, person))
    for whose, hours, account in accounts:
        left = hours * _HOUR - account.used - account.promised
        if charge > left:
            found.append(
                f"it is charged {_hours(charge)}, and {whose} has {_hours(max(0.0, left))} left:"
                f" {_hours(account.used)} used and {_hours(account.promised)} asked for"
                f" of {hours:g} h"
            )
    return found


def _hours(seconds: float) -> str:
    return f"{seconds / _HOUR:.2f} h"
