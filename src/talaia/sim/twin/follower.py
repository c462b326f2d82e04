"""What the twin does next: follow, rehearse, wait or be put back. Pure: states and times come in.

The rule that bounds the error: a share of it is taken away in each period, and what stays beyond
the limits for too long is taken away whole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.model.twins.twin import TwinMode

if TYPE_CHECKING:
    from talaia.model.twins.twin import Twin

__all__ = ["Correction", "TwinDifference", "TwinFollower", "VehicleState", "difference_of"]

SILENT_NS = SECOND
"""Nothing heard of the robot for so long: it is not known where it is."""
COMMAND_NS = SECOND // 2
"""A command counts for so long, as on the robot itself."""
MOVING = 0.03
"""Faster than this (m/s, and rad/s tenfold) the robot moves."""
IDLE_NS = 2 * SECOND
"""Nobody has driven the twin for so long: a robot that moves ends the rehearsal."""


@dataclass(frozen=True)
class VehicleState:
    """Where a vehicle is (m, rad) and how it moves (m/s, rad/s)."""

    x: float
    y: float
    yaw: float
    speed: float = 0.0
    turn: float = 0.0

    @property
    def finite(self) -> bool:
        """Whether all of it are numbers; a broken odometry must not move the twin anywhere."""
        return all(map(math.isfinite, (self.x, self.y, self.yaw, self.speed, self.turn)))


class TwinDifference(NamedTuple):
    """The robot less the twin: distance (m, at least 0), heading (rad, -π to π), speed (m/s)."""

    pose: float
    heading: float
    speed: float


class Correction(NamedTuple):
    """By how much the twin is moved now: m in the floor's axes, and rad."""

    x: float
    y: float
    yaw: float


NOWHERE = Correction(0.0, 0.0, 0.0)


def difference_of(real: VehicleState, twin: VehicleState) -> TwinDifference:
    """Compare two states."""
    return TwinDifference(
        math.hypot(real.x - twin.x, real.y - twin.y),
        # The short way round: 359° and 1° are 2° apart.
        math.remainder(real.yaw - twin.yaw, 2 * math.pi),
        real.speed - twin.speed,
    )


class TwinFollower:
    """One twin's mode, what it is driven by, and how it is drawn to the robot.

    Attributes:
        mode: what it does now.
        resets: how often it was put where the robot is.

    """

    def __init__(self, twin: Twin) -> None:
        """Wait for the robot."""
        self._twin = twin
        self.mode = TwinMode.WAITING
        self.resets = 0
        self._real: VehicleState | None = None
        self._heard_ns = 0
        # What the robot was told, and the twin alone: speed, turn, and when (monotonic).
        self._told: tuple[float, float, int] | None = None
        self._driven: tuple[float, float, int] | None = None
        # When the twin alone was last told to move; zeros are no driving.
        self._moved_ns = 0
        # Since when the error is beyond the limits; none while it is not.
        self._beyond_ns: int | None = None

    def hear_robot(self, state: VehicleState, now_ns: int) -> None:
        """Take where the robot is. What is no number is not heard."""
        if state.finite:
            self._real, self._heard_ns = state, now_ns

    def hear_command(self, speed: float, turn: float, now_ns: int) -> None:
        """Take a velocity that the robot was told."""
        if math.isfinite(speed) and math.isfinite(turn):
            self._told = (speed, turn, now_ns)

    def drive_alone(self, speed: float, turn: float, now_ns: int) -> None:
        """Take a velocity for the twin alone; the first that is not zero begins a rehearsal."""
        if not (math.isfinite(speed) and math.isfinite(turn)):
            return
        if self.mode is TwinMode.FOLLOWING and (speed or turn):
            self.mode = TwinMode.REHEARSING
        self._driven = (speed, turn, now_ns)
        if speed or turn:
            self._moved_ns = now_ns

    def follow_robot(self) -> None:
        """End a rehearsal: the twin is put where the robot is."""
        if self.mode is TwinMode.REHEARSING:
            # Counted by nobody as a reset: no model was wrong.
            self.mode = TwinMode.WAITING

    def wanted_velocity(self, now_ns: int) -> tuple[float, float]:
        """Give what moves the twin now: speed (m/s) and turn (rad/s)."""
        if self.mode is TwinMode.REHEARSING:
            return _fresh_velocity(self._driven, now_ns) or (0.0, 0.0)
        if self.mode is TwinMode.WAITING or self._real is None:
            return 0.0, 0.0
        # Without a command the robot may drive by itself, and tells only how fast it is.
        told = _fresh_velocity(self._told, now_ns)
        return told if told is not None else (self._real.speed, self._real.turn)

    def correct_twin(self, twin: VehicleState, seconds: float, now_ns: int) -> Correction:
        """Say by how much the twin is to be moved, after a period of ``seconds``."""
        real = self._real
        if real is None or now_ns - self._heard_ns > SILENT_NS:
            if self.mode is TwinMode.FOLLOWING:
                self.mode = TwinMode.WAITING
            self._beyond_ns = None
            return NOWHERE
        if self.mode is TwinMode.REHEARSING:
            self._end_idle_rehearsal(real, now_ns)
            if self.mode is TwinMode.REHEARSING:
                return NOWHERE
        whole = _step_to(real, twin)
        if self.mode is TwinMode.WAITING:
            # Heard for the first time, or again: where it stood before means nothing.
            self.mode = TwinMode.FOLLOWING
            return whole
        if self._is_lost(difference_of(real, twin), now_ns):
            self.resets += 1
            self._beyond_ns = None
            return whole
        share = min(1.0, self._twin.follow_rate * seconds)
        return Correction(whole.x * share, whole.y * share, whole.yaw * share)

    def difference(self, twin: VehicleState) -> TwinDifference | None:
        """Give how far robot and twin are apart; none while they are not to be the same."""
        if self.mode is not TwinMode.FOLLOWING or self._real is None:
            return None
        return difference_of(self._real, twin)

    def _end_idle_rehearsal(self, real: VehicleState, now_ns: int) -> None:
        moves = abs(real.speed) > MOVING or abs(real.turn) > 10 * MOVING
        if moves and now_ns - self._moved_ns > IDLE_NS:
            self.mode = TwinMode.WAITING

    def _is_lost(self, error: TwinDifference, now_ns: int) -> bool:
        twin = self._twin
        if error.pose <= twin.reset_beyond and abs(error.heading) <= twin.reset_turn:
            self._beyond_ns = None
            return False
        if self._beyond_ns is None:
            self._beyond_ns = now_ns
        return now_ns - self._beyond_ns >= twin.reset_after * SECOND


def _fresh_velocity(
    told: tuple[float, float, int] | None, now_ns: int
) -> tuple[float, float] | None:
    if told is None or now_ns - told[2] > COMMAND_NS:
        return None
    return told[:2]


def _step_to(real: VehicleState, twin: VehicleState) -> Correction:
    yaw = math.remainder(real.yaw - twin.yaw, 2 * math.pi)
    return Correction(real.x - twin.x, real.y - twin.y, yaw)
