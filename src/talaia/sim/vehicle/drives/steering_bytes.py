"""Ackermann's message as bytes, for machines where its package is not installed. Pure."""

from __future__ import annotations

import struct
from typing import NamedTuple

__all__ = ["HASH", "TYPE", "WantedSteering", "read_steering"]

TYPE = "ackermann_msgs/msg/AckermannDriveStamped"
HASH = "RIHS01_48ca7612a08d3bb72744fd98b71b7cf2ea24c6ad50fa4e1aa0bbad963c90d8cf"
"""By which others know the version of the type that is read here (REP-2011)."""
_HEAD = 4
"""Of CDR: two bytes of its kind, the second odd where the least byte comes first, and two more."""
_ALIGNED = 4


class WantedSteering(NamedTuple):
    """What is asked for: m/s, and the angle of the steered wheels (rad)."""

    speed: float
    angle: float


def read_steering(raw: bytes) -> WantedSteering:
    """Read the speed and the angle of an AckermannDriveStamped.

    Raises:
        struct.error: it is shorter than one.

    """
    order = "<" if raw[1] & 1 else ">"
    # A stamp of two numbers, then the frame's name with its length and a zero at its end.
    (length,) = struct.unpack_from(f"{order}I", raw, _HEAD + 8)
    begin = 12 + length
    begin = _HEAD + (begin + _ALIGNED - 1) // _ALIGNED * _ALIGNED
    angle, _, speed, _, _ = struct.unpack_from(f"{order}5f", raw, begin)
    return WantedSteering(speed, angle)
