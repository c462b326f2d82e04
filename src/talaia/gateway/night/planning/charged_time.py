"""Block time that was charged here and that the hub's hours do not have yet. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.model.observing.requests import Proposal

__all__ = ["TimeCharge", "add_charge", "charged_seconds", "seconds_left"]

# More single charges than a hub that is away for weeks leaves; then the older ones become one for
# each proposal.
MOST_CHARGES = 2000


class TimeCharge(msgspec.Struct, frozen=True, kw_only=True):
    """What one update charged.

    Attributes:
        number: of the update.
        proposal: who pays.
        seconds: beyond what was charged for the same try before.

    """

    number: int
    proposal: str
    seconds: float


def add_charge(charges: list[TimeCharge], charge: TimeCharge) -> None:
    """Add one more to the charges."""
    charges.append(charge)
    if len(charges) <= MOST_CHARGES:
        return
    older, newer = charges[: MOST_CHARGES // 2], charges[MOST_CHARGES // 2 :]
    # By the newest number: rather counted a little longer than not at all.
    number = older[-1].number
    merged = [
        TimeCharge(number=number, proposal=proposal, seconds=seconds)
        for proposal, seconds in charged_seconds(older).items()
    ]
    charges[:] = [*merged, *newer]


def charged_seconds(charges: Iterable[TimeCharge]) -> dict[str, float]:
    """Add up what each proposal was charged (s)."""
    found: dict[str, float] = {}
    for charge in charges:
        found[charge.proposal] = found.get(charge.proposal, 0.0) + charge.seconds
    return found


def seconds_left(proposals: Iterable[Proposal], charged: Mapping[str, float]) -> dict[str, float]:
    """Give what each proposal has left (s), by the hub's hours and what came since."""
    return {
        one.id: (one.hours_allocated - one.hours_used) * 3600.0 - charged.get(one.id, 0.0)
        if one.active
        else 0.0
        for one in proposals
    }
