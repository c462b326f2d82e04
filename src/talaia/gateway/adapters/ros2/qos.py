"""Which quality of service a subscription asks for, by what the publishers offer. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Collection

__all__ = ["QosProfile", "fits", "quality_for"]


class QosProfile(NamedTuple):
    """Of a publisher: what it offers. Of a subscription: what it asks for."""

    reliable: bool
    latched: bool


def quality_for(offered: Collection[QosProfile]) -> QosProfile:
    """Ask for the most that every publisher offers; a subscription that asks more hears nothing."""
    return QosProfile(
        reliable=all(offer.reliable for offer in offered),
        latched=all(offer.latched for offer in offered),
    )


def fits(asked: QosProfile, offered: Collection[QosProfile]) -> bool:
    """Tell whether a subscription hears all publishers.

    One that asks for less than it could is left alone: changing it would lose messages.
    """
    return all(
        (offer.reliable or not asked.reliable) and (offer.latched or not asked.latched)
        for offer in offered
    )
