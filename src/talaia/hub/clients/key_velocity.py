"""The velocity that one character stands for, as the founding vehicle is driven. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.hub.clients.published_velocity import PublishedVelocity

if TYPE_CHECKING:
    from talaia.model.site import Drive

__all__ = ["key_velocity", "read_key"]


class _Key(msgspec.Struct, frozen=True):
    data: str


def read_key(data: bytes, rule: Drive) -> PublishedVelocity | str:
    """Read the JSON of a ``std_msgs/String`` with one character, or say what is wrong with it."""
    try:
        return key_velocity(msgspec.json.decode(data, type=_Key).data, rule)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        return f"not the JSON of a text: {str(error)[:200]}"


def key_velocity(key: str, rule: Drive) -> PublishedVelocity | str:
    """Give the velocity of a character, by a device's limits; or say that it has none."""
    match key:
        case "w":
            return PublishedVelocity(rule.max_speed, 0.0)
        case "x":
            reverse = rule.max_speed if rule.max_reverse is None else rule.max_reverse
            return PublishedVelocity(-reverse, 0.0)
        case "a":
            return PublishedVelocity(0.0, rule.max_turn)
        case "d":
            return PublishedVelocity(0.0, -rule.max_turn)
        case "s":
            return PublishedVelocity(0.0, 0.0)
        case _:
            return f"a device is driven by one of the characters w, x, a, d, s, not by {key[:20]!r}"
