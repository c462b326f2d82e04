"""The velocity in what a client publishes: a Twist or TwistStamped, as JSON or CDR. Pure."""

from __future__ import annotations

import struct
from typing import NamedTuple

import msgspec

__all__ = ["PublishedVelocity", "read_velocity"]

_STAMPED = "TwistStamped"
_TWIST = "Twist"
# Of CDR: the encapsulation's kind, by its second byte, and what stands before the content.
_LITTLE_ENDIAN, _BIG_ENDIAN = 1, 0
_ENCAPSULATION = 4
# Of the six numbers of a Twist.
_LINEAR_X, _LINEAR_Y, _ANGULAR_Z = 0, 1, 5


class PublishedVelocity(NamedTuple):
    """Forward (m/s), counter-clockwise (rad/s) and to the left (m/s), as in REP-103."""

    linear: float
    angular: float
    lateral: float = 0.0


# Only what drives a vehicle is read of a Twist; the rest may be anything.
class _Linear(msgspec.Struct, frozen=True):
    x: float = 0.0
    y: float = 0.0


class _Angular(msgspec.Struct, frozen=True):
    z: float = 0.0


class _Twist(msgspec.Struct, frozen=True):
    linear: _Linear = _Linear()
    angular: _Angular = _Angular()


class _TwistStamped(msgspec.Struct, frozen=True):
    twist: _Twist = _Twist()


def read_velocity(encoding: str, schema: str, data: bytes) -> PublishedVelocity | str:
    """Read a message of a client, or say what is wrong with it.

    Args:
        encoding: ``json`` or ``cdr``.
        schema: name of its type, such as ``geometry_msgs/msg/Twist`` or ``geometry_msgs/Twist``.
        data: the message.

    """
    # ROS 1 and ROS 2 write the package before it in different ways.
    kind = schema.rpartition("/")[2]
    if kind not in {_TWIST, _STAMPED}:
        return f"a device is driven by geometry_msgs/Twist or TwistStamped, not by {schema[:100]!r}"
    match encoding:
        case "json":
            return _read_json(data, stamped=kind == _STAMPED)
        case "cdr":
            return _read_cdr(data, stamped=kind == _STAMPED)
        case _:
            return f"messages are read as json or cdr, not as {encoding[:100]!r}"


def _read_json(data: bytes, *, stamped: bool) -> PublishedVelocity | str:
    try:
        if stamped:
            twist = msgspec.json.decode(data, type=_TwistStamped).twist
        else:
            twist = msgspec.json.decode(data, type=_Twist)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        return f"not the JSON of a velocity: {str(error)[:200]}"
    return PublishedVelocity(twist.linear.x, twist.angular.z, twist.linear.y)


def _read_cdr(data: bytes, *, stamped: bool) -> PublishedVelocity | str:
    if len(data) < _ENCAPSULATION or data[1] not in {_LITTLE_ENDIAN, _BIG_ENDIAN}:
        return "not the CDR of a velocity: its first four bytes name no plain CDR"
    # Each machine writes its own order and says which.
    order = "<" if data[1] == _LITTLE_ENDIAN else ">"
    content = data[_ENCAPSULATION:]
    try:
        # Of the content, for the encapsulation does not count for alignment.
        begin = 0
        if stamped:
            # Seconds and nanoseconds, then the frame's name with its length before it.
            (length,) = struct.unpack_from(f"{order}8xI", content)
            # Numbers of eight bytes stand at multiples of eight.
            begin = (12 + length + 7) // 8 * 8
        numbers = struct.unpack_from(f"{order}6d", content, begin)
    except struct.error:
        return f"not the CDR of a velocity: {len(data)} bytes are too few"
    return PublishedVelocity(numbers[_LINEAR_X], numbers[_ANGULAR_Z], numbers[_LINEAR_Y])
