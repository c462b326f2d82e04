"""A small arm on the vehicle's deck whose joints are moved by their velocities. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import MS
from talaia.sim.vehicle.drives.drivetrain import JointReading

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["ARM_JOINTS", "ArmJoint", "JoggedArm"]

_STANDSTILL_NS = 500 * MS
# rad/s²
_ACCELERATION = 4.0


class ArmJoint(NamedTuple):
    """A joint with its ends (rad) and its greatest speed (rad/s)."""

    name: str
    low: float
    high: float
    max_speed: float


ARM_JOINTS = (
    ArmJoint("shoulder_pan_joint", -2.8, 2.8, 1.0),
    ArmJoint("shoulder_lift_joint", -1.2, 1.2, 1.0),
    ArmJoint("elbow_joint", -2.0, 2.0, 1.0),
)
"""In the order of a command's numbers."""


class JoggedArm:
    """Moves its joints as it is told, and stands 0.5 s after the last command."""

    def __init__(self) -> None:
        """Begin in the middle of every joint's way."""
        self._wanted = [0.0] * len(ARM_JOINTS)
        self._speeds = [0.0] * len(ARM_JOINTS)
        self._angles = [0.0] * len(ARM_JOINTS)
        self._commanded_ns: int | None = None
        self._stopped = False

    def set_velocities(self, now_ns: int, wanted: Sequence[float]) -> bool:
        """Take a velocity for each joint (rad/s); says whether that was accepted.

        Another number of them is no command, as for a robot's own controller, and neither is what
        is not finite.
        """
        if self._stopped or len(wanted) != len(ARM_JOINTS) or not all(map(math.isfinite, wanted)):
            return False
        self._wanted = [
            min(max(value, -joint.max_speed), joint.max_speed)
            for value, joint in zip(wanted, ARM_JOINTS, strict=True)
        ]
        self._commanded_ns = now_ns
        return True

    def latch_stop(self, *, engaged: bool) -> None:
        """Stand, and take nothing until it is released."""
        self._stopped = engaged
        self._commanded_ns = None

    def pass_time(self, now_ns: int, seconds: float) -> list[JointReading]:
        """Let time pass, and give how the joints are then."""
        if self._commanded_ns is not None and now_ns - self._commanded_ns >= _STANDSTILL_NS:
            self._commanded_ns = None
        if self._commanded_ns is None:
            self._wanted = [0.0] * len(ARM_JOINTS)
        found = []
        for index, joint in enumerate(ARM_JOINTS):
            more = self._wanted[index] - self._speeds[index]
            step = min(abs(more), _ACCELERATION * seconds)
            speed = self._speeds[index] + math.copysign(step, more)
            angle = self._angles[index] + speed * seconds
            # Its ends are hard: it stands there.
            held = min(max(angle, joint.low), joint.high)
            self._speeds[index] = speed if held == angle else 0.0
            self._angles[index] = held
            found.append(JointReading(joint.name, held, self._speeds[index]))
        return found
