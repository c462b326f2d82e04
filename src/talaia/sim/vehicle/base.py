"""Who moves the vehicle: commands, keys, wandering, STOP and the time-out. Pure: times come in.

In order: STOP (latched until released) > a command from outside (``/cmd_vel``, ``/control``) >
a goal > wandering. A command from outside ends both for good; they must be asked for again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING

from talaia.clock import MS
from talaia.sim.vehicle.drives.kinematics import (
    MAX_SPEED,
    MAX_STEERING,
    MAX_TURN,
    STEERING_RATE,
    DriveKind,
    Velocity,
    limit_velocity,
    steering_for,
    turn_of,
)

if TYPE_CHECKING:
    from talaia.sim.vehicle.autonomy.goal import Goal

__all__ = ["MAX_SPEED", "MAX_TURN", "STANDSTILL_NS", "Base", "Change", "MotionSource", "Ramp"]

STANDSTILL_NS = 500 * MS
"""So long after the last command the vehicle stands still."""
BRAKING_NS = 80 * MS
"""Part of that: a control period and the time it takes to brake from full speed."""

KEYS = {
    "w": (0.15, 0.0),
    "x": (-0.15, 0.0),
    "a": (0.0, 1.0),
    "d": (0.0, -1.0),
    "s": (0.0, 0.0),
}
"""What the keys of the CloudConnect contract ask for, each until its own time-out."""


class MotionSource(StrEnum):
    """What moved the vehicle, or stopped it."""

    TWIST = "cmd_vel"
    STEERING = "ackermann_cmd"
    KEY = "control"
    WANDER = "wander"
    GOAL = "goal_pose"
    TIME_OUT = "timeout"
    STOP = "stop"


@dataclass(frozen=True)
class Change:
    """A new wanted velocity.

    Attributes:
        speed: forward (m/s).
        turn: counter-clockwise (rad/s).
        lateral: to the left (m/s), of a base that moves sideways.
        steering: angle of the wheels (rad), of a base whose wheels steer.

    """

    source: MotionSource
    speed: float
    turn: float
    lateral: float = 0.0
    steering: float = 0.0


class Base:
    """Decides the wanted velocity.

    Every method that may change it returns the change, or None when all stays as it was.

    Args:
        wandering: it drives about by itself from the start.
        drive: what its wheels allow.

    """

    def __init__(
        self, *, wandering: bool = False, drive: DriveKind = DriveKind.DIFFERENTIAL
    ) -> None:
        """Start standing still."""
        self._drive = drive
        # The velocity that is wanted now, and what asked for it.
        self._wanted = Change(MotionSource.TIME_OUT, 0.0, 0.0)
        # Monotonic time of the last command from outside; none while no time-out is due.
        self._commanded_ns: int | None = None
        # STOP is latched: commands are refused until it is released.
        self._stopped = False
        # It drives about by itself until the next command from outside or STOP.
        self._wandering = wandering
        # Where it drives by itself; none: nowhere.
        self._goal: Goal | None = None

    @property
    def wanted(self) -> Change:
        """The velocity that is wanted now, and what asked for it."""
        return self._wanted

    @property
    def speed(self) -> float:
        """Wanted, forward (m/s)."""
        return self._wanted.speed

    @property
    def turn(self) -> float:
        """Wanted, counter-clockwise (rad/s)."""
        return self._wanted.turn

    @property
    def steers(self) -> bool:
        """Whether its wheels steer."""
        return self._drive is DriveKind.ACKERMANN

    @property
    def drives_itself(self) -> bool:
        """Whether it can wander and go to a goal: that needs turns on the spot."""
        return not self.steers

    @property
    def wandering(self) -> bool:
        """Whether it drives about by itself."""
        return self._wandering

    @property
    def goal(self) -> Goal | None:
        """Where it drives by itself."""
        return self._goal

    @property
    def stopped(self) -> bool:
        """Whether STOP is latched."""
        return self._stopped

    def set_velocity(
        self, now_ns: int, speed: float, turn: float, *, lateral: float = 0.0
    ) -> Change | None:
        """Take a velocity from outside, cut to the vehicle's limits.

        A value that is not finite is no velocity; such a command stands for standing still.
        """
        wanted = Velocity(speed, turn, lateral)
        return self._accept_command(now_ns, self._make_change(MotionSource.TWIST, wanted))

    def steer_wheels(self, now_ns: int, speed: float, steering: float) -> Change | None:
        """Take a speed and an angle of the wheels from outside; without effect on other bases."""
        if not self.steers:
            return None
        if not (math.isfinite(speed) and math.isfinite(steering)):
            speed, steering = 0.0, self._wanted.steering
        speed = limit_velocity(self._drive, Velocity(speed, 0.0)).speed
        steering = min(max(steering, -MAX_STEERING), MAX_STEERING)
        turn = turn_of(speed, steering)
        return self._accept_command(
            now_ns, Change(MotionSource.STEERING, speed, turn, steering=steering)
        )

    def press_key(self, now_ns: int, key: str) -> Change | None:
        """Take a key of the CloudConnect contract. Other keys change nothing."""
        asked = KEYS.get(key)
        if asked is None:
            return None
        return self._accept_command(now_ns, self._make_change(MotionSource.KEY, Velocity(*asked)))

    def set_wander_velocity(self, speed: float, turn: float) -> Change | None:
        """Take where wandering would go; without effect unless it is on."""
        if not self._wandering:
            return None
        return self._want_velocity(Change(MotionSource.WANDER, speed, turn))

    def set_goal(self, goal: Goal) -> bool:
        """Take where it is to drive by itself; says whether that was accepted.

        STOP refuses it, and so does a base that cannot turn on the spot.
        """
        if self._stopped or not self.drives_itself:
            return False
        if not all(map(math.isfinite, (goal.x, goal.y, goal.yaw))):
            return False
        self._wandering = False
        self._commanded_ns = None
        self._goal = goal
        return True

    def set_goal_velocity(self, velocity: tuple[float, float] | None) -> Change | None:
        """Take how it would go to its goal, none when it is there; no effect without a goal."""
        if self._goal is None:
            return None
        if velocity is None:
            self._goal = None
        return self._want_velocity(Change(MotionSource.GOAL, *(velocity or (0.0, 0.0))))

    def switch_wandering(self, *, on: bool) -> tuple[bool, Change | None]:
        """Turn wandering on or off; says whether that was accepted.

        STOP refuses it, and so does a base that cannot turn on the spot.
        """
        if on:
            if self._stopped or not self.drives_itself:
                return False, None
            self._wandering = True
            self._goal = None
            return True, None
        was, self._wandering = self._wandering, False
        return True, self._want_velocity(Change(MotionSource.WANDER, 0.0, 0.0)) if was else None

    def latch_stop(self, *, engaged: bool) -> Change | None:
        """Latch STOP, or release it. A release never moves anything."""
        self._stopped = engaged
        if not engaged:
            return None
        self._wandering = False
        self._goal = None
        self._commanded_ns = None
        return self._want_velocity(self._make_change(MotionSource.STOP, Velocity(0.0, 0.0)))

    def pass_time(self, now_ns: int) -> Change | None:
        """Notice that the last command is too old."""
        if self._commanded_ns is None:
            return None
        # Braking begins early enough that the vehicle stands when the time is over.
        if now_ns - self._commanded_ns < STANDSTILL_NS - BRAKING_NS:
            return None
        self._commanded_ns = None
        return self._want_velocity(self._make_change(MotionSource.TIME_OUT, Velocity(0.0, 0.0)))

    def _make_change(self, source: MotionSource, asked: Velocity) -> Change:
        """Make of a velocity what the wheels can do of it; where none is asked they stay turned."""
        speed, turn, lateral = limit_velocity(self._drive, asked)
        if not self.steers:
            return Change(source, speed, turn, lateral)
        steering = steering_for(Velocity(speed, turn), self._wanted.steering)
        return Change(source, speed, turn_of(speed, steering), steering=steering)

    def _accept_command(self, now_ns: int, change: Change) -> Change | None:
        if self._stopped:
            return None
        self._wandering = False
        self._goal = None
        self._commanded_ns = now_ns
        return self._want_velocity(change)

    def _want_velocity(self, change: Change) -> Change | None:
        # A time-out at standstill changes nothing and is not logged. The same velocity from another
        # source is: the log says who moves the vehicle.
        before, self._wanted = self._wanted, change
        same = replace(before, source=change.source) == change
        if same and (before.source == change.source or change.source is MotionSource.TIME_OUT):
            return None
        return change


class Ramp:
    """Bounds how fast the wanted velocity is taken up; braking is quicker than speeding up."""

    # Bounds of acceleration: m/s² for the first two, rad/s² for the turn.
    SPEED_UP = 2.5
    BRAKE = 5.0
    TURN_UP = 15.0
    TURN_BRAKE = 60.0

    def __init__(self) -> None:
        """Start standing still."""
        self.speed = 0.0
        self.turn = 0.0
        self.lateral = 0.0
        # Angle of steered wheels (rad).
        self.steering = 0.0

    def follow_velocity(
        self, seconds: float, speed: float, turn: float, *, lateral: float = 0.0
    ) -> None:
        """Move all towards what is wanted (m/s, rad/s) for a while."""
        faster, slower = self.SPEED_UP * seconds, self.BRAKE * seconds
        self.speed = _step_towards(self.speed, speed, faster, slower)
        self.lateral = _step_towards(self.lateral, lateral, faster, slower)
        self.turn = _step_towards(
            self.turn, turn, self.TURN_UP * seconds, self.TURN_BRAKE * seconds
        )

    def turn_wheels(self, seconds: float, steering: float) -> None:
        """Turn steered wheels towards an angle (rad) for a while."""
        most = STEERING_RATE * seconds
        self.steering = _step_towards(self.steering, steering, most, most)


def _step_towards(value: float, goal: float, faster: float, slower: float) -> float:
    braking = abs(goal) < abs(value) or goal * value < 0
    most = slower if braking else faster
    return goal if abs(goal - value) <= most else value + math.copysign(most, goal - value)
