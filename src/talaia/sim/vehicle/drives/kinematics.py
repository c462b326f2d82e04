"""What wheels make of a wanted velocity: differential, holonomic and steered. Pure.

By REP-103: x forward, y to the left, turns counter-clockwise; metres, seconds and radians.
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import NamedTuple

__all__ = [
    "MAX_SPEED",
    "MAX_STEERING",
    "MAX_TURN",
    "STEERING_RATE",
    "TRACK",
    "WHEELBASE",
    "WHEEL_RADIUS",
    "DriveKind",
    "Velocity",
    "front_angles",
    "limit_velocity",
    "mecanum_rates",
    "side_rates",
    "steering_for",
    "turn_of",
]

MAX_SPEED = 0.22
"""m/s, as a TurtleBot3; of a holonomic base in every direction."""
MAX_TURN = 2.84
"""rad/s, as a TurtleBot3."""
WHEEL_RADIUS = 0.033
TRACK = 0.16
"""Between the left and the right wheels (m)."""
WHEELBASE = 0.12
"""Between the front and the rear wheels (m), where there are four."""
MAX_STEERING = 0.5
"""Greatest angle of the steered wheels to each side (rad): a circle of 0.22 m radius."""
STEERING_RATE = 2.0
"""How fast that angle changes (rad/s)."""


class DriveKind(StrEnum):
    """What the wheels allow."""

    DIFFERENTIAL = "differential"
    HOLONOMIC = "holonomic"
    ACKERMANN = "ackermann"


class Velocity(NamedTuple):
    """Of the base: forward and to the left (m/s), counter-clockwise (rad/s)."""

    speed: float
    turn: float
    lateral: float = 0.0


def limit_velocity(kind: DriveKind, wanted: Velocity) -> Velocity:
    """Cut a velocity to what a base of this kind can do; what is not finite is standing still.

    A base with steered wheels has no rate of turn of its own: see `steering_for`.
    """
    # NaN would pass the bounds below.
    if not all(map(math.isfinite, wanted)):
        return Velocity(0.0, 0.0)
    speed = _within(wanted.speed, MAX_SPEED)
    turn = _within(wanted.turn, MAX_TURN)
    if kind is not DriveKind.HOLONOMIC:
        return Velocity(speed, turn)
    lateral = _within(wanted.lateral, MAX_SPEED)
    # Its way stays as it is wanted: the motors' limit is that of the way, not of each axis.
    much = max(1.0, math.hypot(speed, lateral) / MAX_SPEED)
    return Velocity(speed / much, turn, lateral / much)


def steering_for(wanted: Velocity, now: float) -> float:
    """Give the angle of the wheels (rad) with which a base turns as is wanted.

    No angle turns a base that stands: its wheels stay as they are, at the angle ``now``.
    """
    if wanted.speed == 0:
        return now
    return _within(math.atan(wanted.turn * WHEELBASE / wanted.speed), MAX_STEERING)


def turn_of(speed: float, steering: float) -> float:
    """Give how fast a base with wheels at this angle turns while it rolls (rad/s)."""
    return speed * math.tan(_within(steering, MAX_STEERING)) / WHEELBASE


def front_angles(steering: float) -> tuple[float, float]:
    """Give the angles of the left and the right front wheel (rad).

    Both stand at right angles to the way to the point that the base turns about, so that neither
    slips; the inner one is turned by more.
    """
    slope = math.tan(_within(steering, MAX_STEERING))
    left, right = (
        math.atan(slope / (1.0 + side * slope * TRACK / (2 * WHEELBASE))) for side in (-1, 1)
    )
    return left, right


def side_rates(speed: float, turn: float) -> tuple[float, float]:
    """Give how fast wheels at the left and at the right turn that do not slip (rad/s)."""
    aside = turn * TRACK / 2
    return (speed - aside) / WHEEL_RADIUS, (speed + aside) / WHEEL_RADIUS


def mecanum_rates(moved: Velocity) -> tuple[float, float, float, float]:
    """Give how fast wheels with slanted rollers turn (rad/s): front left, right; rear left, right.

    The rollers of all four point to the middle, seen from above.
    """
    aside = moved.turn * (TRACK + WHEELBASE) / 2
    return (
        (moved.speed - moved.lateral - aside) / WHEEL_RADIUS,
        (moved.speed + moved.lateral + aside) / WHEEL_RADIUS,
        (moved.speed + moved.lateral - aside) / WHEEL_RADIUS,
        (moved.speed - moved.lateral + aside) / WHEEL_RADIUS,
    )


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
