"""How far a mount points from where it says: what plate solving and guiding are for. Pure."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["Offset", "PointingError", "moved_place"]


class Offset(NamedTuple):
    """A way on the sky (arc seconds)."""

    east: float
    north: float


class PointingError:
    """What the mount does not know of itself.

    A zero point that is minutes of arc off until a `correct` puts it right, a tube that bends by
    the altitude, an axis not quite at the pole that lets stars drift, and a worm that swings.
    """

    # Of the zero point, as somebody left it.
    LEFT = Offset(170.0, -120.0)
    # How far the tube's end hangs down when it points to the horizon (arc seconds).
    BEND = 45.0
    # Of a badly set polar axis (arc seconds a minute).
    DRIFT = Offset(0.7, 0.4)
    # The worm's turn (s) and how far it swings to each side (arc seconds).
    WORM_S, WORM = 480.0, 2.5

    def __init__(self) -> None:
        """Start as it was left."""
        self._zero = self.LEFT
        self._turned_s = 0.0

    def at(self, altitude: float) -> Offset:
        """Give how far the axis is from what the mount says, at an altitude (°)."""
        bend = self.BEND * math.cos(math.radians(altitude))
        worm = self.WORM * math.sin(2.0 * math.pi * self._turned_s / self.WORM_S)
        return Offset(self._zero.east + worm, self._zero.north - bend)

    def track(self, seconds: float) -> None:
        """Let the mount follow the sky for some time."""
        self._turned_s += seconds
        self.correct(Offset(self.DRIFT.east * seconds / 60.0, self.DRIFT.north * seconds / 60.0))

    def correct(self, by: Offset) -> None:
        """Move the axis, and not what the mount says."""
        self._zero = Offset(self._zero.east + by.east, self._zero.north + by.north)


def moved_place(ra: float, dec: float, by: Offset) -> tuple[float, float]:
    """Give the place (h, °) that lies a small way from another."""
    north = dec + by.north / 3600.0
    # Beside the pole a way to the east has no size; half an arc second from it is near enough.
    along = max(1e-4, math.cos(math.radians(dec)))
    return (ra + by.east / 3600.0 / along / 15.0) % 24.0, max(-90.0, min(90.0, north))
