"""The joints of the vehicle's base as `/joint_states` tells them, and what its motors do. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.sim.vehicle.drives.kinematics import (
    TRACK,
    WHEEL_RADIUS,
    WHEELBASE,
    DriveKind,
    Velocity,
    front_angles,
    mecanum_rates,
    side_rates,
)

if TYPE_CHECKING:
    from talaia.sim.vehicle.world import Motion

__all__ = ["Drivetrain", "JointReading"]

_SIDES = ("left", "right")
_CORNERS = ("front left", "front right", "rear left", "rear right")


class JointReading(NamedTuple):
    """Where a joint stands (rad) and how fast it moves (rad/s)."""

    name: str
    position: float
    velocity: float


class Drivetrain:
    """Counts how far the wheels have turned.

    Args:
        kind: which wheels they are.

    Attributes:
        motors: what they are called; one for each driven wheel.

    """

    def __init__(self, kind: DriveKind) -> None:
        """Begin with all at zero."""
        self._kind = kind
        self.motors = _CORNERS if kind is DriveKind.HOLONOMIC else _SIDES
        # Of each wheel that the world does not count itself (rad).
        self._turned = [0.0] * 4

    def rates(self, motion: Motion) -> tuple[float, ...]:
        """Give how fast the motors turn (rad/s), in their order."""
        if self._kind is DriveKind.HOLONOMIC:
            return mecanum_rates(Velocity(motion.speed, motion.turn, motion.slip))
        return side_rates(motion.speed, motion.turn)

    def pass_time(self, seconds: float, motion: Motion, steering: float) -> list[JointReading]:
        """Let the wheels turn for a while, and give how all joints are then."""
        rates = self.rates(motion)
        if self._kind is DriveKind.HOLONOMIC:
            names = [f"mecanum_{corner.replace(' ', '_')}_joint" for corner in _CORNERS]
            return self._turn_wheels(seconds, names, rates)
        rear = [
            JointReading(f"wheel_{side}_joint", angle, rate)
            for side, angle, rate in zip(_SIDES, (motion.left, motion.right), rates, strict=True)
        ]
        if self._kind is DriveKind.DIFFERENTIAL:
            return rear
        steered = [
            JointReading(f"steering_{side}_joint", angle, 0.0)
            for side, angle in zip(_SIDES, front_angles(steering), strict=True)
        ]
        # Each rolls the way it points: what its place on the base moves along that.
        fronts = [
            (
                math.cos(angle) * (motion.speed - side * motion.turn * TRACK / 2)
                + math.sin(angle) * motion.turn * WHEELBASE
            )
            / WHEEL_RADIUS
            for side, angle in zip((1, -1), front_angles(steering), strict=True)
        ]
        names = [f"wheel_front_{side}_joint" for side in _SIDES]
        return [*rear, *steered, *self._turn_wheels(seconds, names, tuple(fronts))]

    def _turn_wheels(
        self, seconds: float, names: list[str], rates: tuple[float, ...]
    ) -> list[JointReading]:
        found = []
        for index, (name, rate) in enumerate(zip(names, rates, strict=True)):
            self._turned[index] += rate * seconds
            found.append(JointReading(name, self._turned[index], rate))
        return found
