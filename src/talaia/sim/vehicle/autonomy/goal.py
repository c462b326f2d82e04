"""Drives to a place on the floor: turns to it, goes there, turns as asked. Pure.

It plans no way around anything: it is a stand-in for a robot's own navigation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.sim.vehicle.world import Motion

__all__ = ["Goal", "choose_goal_velocity"]

CRUISE = 0.18
"""m/s."""
NEAR = 0.03
"""As near as this it is there (m)."""
ALIGNED = 0.03
"""As near as this it is turned (rad)."""
# Away from its way by more than this it turns on the spot (rad).
_ASIDE = 0.6
_FASTEST_TURN = 1.2


@dataclass(frozen=True)
class Goal:
    """Where it is to stand: metres and radians in its odometry's frame."""

    x: float
    y: float
    yaw: float


def choose_goal_velocity(motion: Motion, goal: Goal) -> tuple[float, float] | None:
    """Give speed (m/s) and turn (rad/s) towards a goal; none when it is reached."""
    away = math.hypot(goal.x - motion.x, goal.y - motion.y)
    if away <= NEAR:
        left = math.remainder(goal.yaw - motion.yaw, 2 * math.pi)
        return None if abs(left) <= ALIGNED else (0.0, _bounded_turn(2.0 * left))
    bearing = math.atan2(goal.y - motion.y, goal.x - motion.x)
    aside = math.remainder(bearing - motion.yaw, 2 * math.pi)
    if abs(aside) > _ASIDE:
        return 0.0, _bounded_turn(2.0 * aside)
    # Slower near the goal and while it is turned away, so that it does not circle the place.
    return min(CRUISE, 1.5 * away) * math.cos(aside), _bounded_turn(2.5 * aside)


def _bounded_turn(turn: float) -> float:
    return min(max(turn, -_FASTEST_TURN), _FASTEST_TURN)
