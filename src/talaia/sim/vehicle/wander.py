"""Drives about by itself and avoids what the lidar sees. Pure: a scan in, velocities out."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from talaia.sim.vehicle.vehicle import RADIUS

__all__ = ["Wander"]

CRUISE = 0.18
"""m/s where the way is free."""
SPIN = 1.2
"""rad/s on the spot."""
CLEARANCE = 0.08
"""Room kept around the vehicle (m)."""
SIGHT = 2.5
"""A way free for so long is as good as any longer one (m)."""

Array = npt.NDArray[np.float64]


class Wander:
    """Prefers long free ways near its heading, and a side that changes now and then.

    Args:
        seed: decides which side, and for how long.

    """

    def __init__(self, seed: int = 0) -> None:
        """Start without a preference."""
        # A stream of its own, apart from the world's.
        self._rng = np.random.default_rng([seed, 77])
        # The side it leans to in open space (-1 to 1), and for how long still (s).
        self._leaning = 0.0
        self._left_s = 0.0
        # Turn rate while it turns on the spot (rad/s); 0 while it drives.
        self._spinning = 0.0
        # The ways that are weighed (rad): every 10°, straight ahead in the place 17.
        self._headings = np.radians(np.arange(-170.0, 181.0, 10.0))

    def choose_velocity(
        self, seconds: float, ranges: npt.NDArray[np.float32]
    ) -> tuple[float, float]:
        """Choose speed (m/s) and turn (rad/s).

        Args:
            seconds: since the last call.
            ranges: distances all around from straight ahead, counter-clockwise (m); not finite
                where nothing was met.

        """
        self._left_s -= seconds
        if self._left_s <= 0.0:
            self._left_s = float(self._rng.uniform(6.0, 18.0))
            self._leaning = float(self._rng.uniform(-1.0, 1.0))
        free = self._free_ways(ranges)
        ahead = float(free[17])
        if self._spinning:
            if ahead < 0.7 and float(free.max()) > ahead + 0.1:
                # It turns on until the way ahead is free, or no other is freer.
                return 0.0, self._spinning
            self._spinning = 0.0
        worth = np.minimum(free, SIGHT) - 0.45 * np.abs(self._headings)
        worth = worth + 0.5 * self._leaning * np.sin(self._headings)
        heading = float(self._headings[int(np.argmax(worth))])
        # Far aside, or hardly a way ahead: it turns on the spot first.
        if abs(heading) > 1.2 or ahead < 0.12:
            side = heading if heading else self._leaning
            self._spinning = math.copysign(SPIN, side)
            return 0.0, self._spinning
        # Slower the nearer something is ahead, and in turns.
        speed = min(CRUISE, 0.6 * (ahead - 0.06)) * max(0.0, math.cos(1.2 * heading))
        return max(0.0, speed), min(max(1.6 * heading, -SPIN), SPIN)

    def _free_ways(self, ranges: npt.NDArray[np.float32]) -> Array:
        """For each heading, how far the vehicle could drive straight on before it touched."""
        # Where nothing was met it is free as far as the lidar reaches.
        seen = np.where(np.isfinite(ranges), ranges, 8.0).astype(np.float64)
        bearings = np.arange(len(seen)) * (2 * math.pi / len(seen))
        turn = bearings[None, :] - self._headings[:, None]
        along = seen[None, :] * np.cos(turn)
        aside = np.abs(seen[None, :] * np.sin(turn))
        wide = RADIUS + CLEARANCE
        # Where a circle of that size, moving along, first touches what was seen.
        touch = along - np.sqrt(np.maximum(wide * wide - aside * aside, 0.0))
        in_way = (aside < wide) & (along > 0.0)
        free: Array = np.maximum(np.where(in_way, touch, 8.0).min(axis=1), 0.0)
        return free
