"""The unit of each part of a signal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.site import SignalType

if TYPE_CHECKING:
    from talaia.model.site import Channel, Signal

__all__ = ["channel_unit"]

_OF_PART = {"x": "m", "y": "m", "yaw": "rad", "lat": "°", "lon": "°", "alt": "m"}


def channel_unit(signal: Signal, channel: Channel) -> str:
    """Give the unit of a channel: parts of positions have units of their own."""
    if signal.type is SignalType.POSITION:
        return _OF_PART.get(channel.part, "")
    return signal.unit
