"""What a driven device is told at one moment: a velocity, an angle to steer by, joints' speeds."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["STILL", "VelocityDemand"]


class VelocityDemand(NamedTuple):
    """One demand, as in REP-103.

    Attributes:
        linear: forward (m/s).
        angular: counter-clockwise (rad/s).
        lateral: to the left (m/s), of a base that moves sideways.
        steering: of the steered wheels, to the left (rad); an angle, and no velocity.
        joints: of each described joint, in order (rad/s or m/s).

    """

    linear: float
    angular: float
    lateral: float = 0.0
    steering: float = 0.0
    joints: tuple[float, ...] = ()

    @property
    def moves(self) -> bool:
        """Tell whether the device would move; wheels that are held at an angle do not."""
        return any((self.linear, self.angular, self.lateral, *self.joints))

    @property
    def asks(self) -> bool:
        """Tell whether it asks for anything, were it only to steer."""
        return self.moves or self.steering != 0.0


STILL = VelocityDemand(0.0, 0.0)
