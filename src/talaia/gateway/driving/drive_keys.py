"""Characters for a robot that is driven by ``w``, ``x``, ``a``, ``d`` and ``s``. Pure.

The founding vehicle's teleoperation adds a step to its velocity for each character and keeps it
until ``s``. Sent again and again, as a velocity is, 25 letters in 1.2 s would be five times its
limit. So characters are counted here: what has been sent adds up to at most what is asked for and
what the description allows, and ``s`` sets both to zero.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.site import KeyMode

if TYPE_CHECKING:
    from talaia.model.site import Drive

__all__ = ["HALT", "KeyCounter", "strongest_key"]

HALT = "s"
# Up and down of each axis, by index: 0 speed, 1 turn.
LETTERS = (("w", "x"), ("a", "d"))
# A limit of 0.5 holds five steps of 0.1, whatever their floating-point sum says.
ROUNDING = 1e-6


def strongest_key(drive: Drive, linear: float, angular: float) -> str:
    """Give the character of a velocity (m/s, rad/s): the stronger direction, by the limits."""
    reverse = drive.max_speed if drive.max_reverse is None else drive.max_reverse
    limit = drive.max_speed if linear >= 0 else reverse
    ahead = abs(linear) / limit if limit else 0.0
    aside = abs(angular) / drive.max_turn
    if ahead == 0.0 and aside == 0.0:
        return HALT
    if ahead >= aside:
        return "w" if linear > 0 else "x"
    return "a" if angular > 0 else "d"


class KeyCounter:
    """What has been sent to one robot, and what is to be sent next."""

    def __init__(self, drive: Drive) -> None:
        """Begin as after an ``s``."""
        self._drive = drive
        keys = drive.keys
        # Robots of this mode move only while a character keeps coming; nothing is counted for them.
        self._repeats = keys.mode is KeyMode.REPEAT
        # m/s and rad/s that one character adds; None where the description does not know.
        self._steps = (keys.speed_step, keys.turn_step)
        # Characters since the last ``s``, by axis: positive for ``w`` and ``a``.
        self._counts = [0, 0]
        # The newest character sent, "" before the first; what `sent` shows when nothing adds up.
        self._last = ""

    @property
    def velocity(self) -> tuple[float, float]:
        """What was sent adds up to (m/s, rad/s); NaN on an axis whose step is not described."""
        speed, turn = (
            count * step if step is not None else (math.nan if count else 0.0)
            for count, step in zip(self._counts, self._steps, strict=True)
        )
        # A robot that repeats chooses its velocity itself; no sum of ours would be true.
        if self._repeats and self._last not in ("", HALT):
            return math.nan, math.nan
        return speed, turn

    @property
    def sent(self) -> str:
        """What was sent since the last ``s``, as a person reads it: ``w × 3, a``."""
        if self._repeats:
            return self._last
        words = []
        for count, letters in zip(self._counts, LETTERS, strict=True):
            if count:
                letter = letters[0] if count > 0 else letters[1]
                words.append(letter if abs(count) == 1 else f"{letter} × {abs(count)}")
        return ", ".join(words) or self._last

    def next_key(
        self,
        wished: tuple[float, float],
        share: float = 1.0,
        measured: tuple[float, float] = (math.nan, math.nan),
    ) -> str:
        """Give the one character to send now; empty when all has been said.

        Args:
            wished: m/s forward and rad/s counter-clockwise; within the limits already.
            share: of the limits that may be used now, 0 to 1.
            measured: what the robot says of itself; NaN where it says nothing.

        """
        if self._repeats:
            # Sent each time it is asked for: this robot takes silence for letting go.
            self._last = strongest_key(self._drive, *wished)
            return self._last
        targets = [
            self._target_count(axis, wish, share, measured[axis])
            for axis, wish in enumerate(wished)
        ]
        key = self._key_towards(targets)
        # "s" sets both axes to zero at the robot, so both counts as well.
        if key == HALT:
            self._counts = [0, 0]
        elif key:
            axis = 0 if key in LETTERS[0] else 1
            self._counts[axis] += 1 if key == LETTERS[axis][0] else -1
        self._last = key or self._last
        return key

    def _key_towards(self, targets: list[int]) -> str:
        if targets == [0, 0]:
            # Said again each time: of all characters it is the one that must arrive.
            # Speed before turn: of two axes that both lag, one character at a time can be sent.
            return HALT
        for axis, target in enumerate(targets):
            count = self._counts[axis]
            if count == target:
                continue
            # Going back towards zero, or past it.
            back = abs(target) < abs(count) or target * count < 0
            if back and self._steps[axis] is None:
                # Whether one ``x`` undoes one ``w`` is not known of this robot.
                return HALT
            return LETTERS[axis][0] if target > count else LETTERS[axis][1]
        return ""

    def _target_count(self, axis: int, wish: float, share: float, measured: float) -> int:
        """Give how many characters on an axis, with sign."""
        if wish == 0.0:
            return 0
        sign = 1 if wish > 0 else -1
        step = self._steps[axis]
        if step is None:
            return sign if share > 0.0 else 0
        limit = self._axis_limit(axis, sign) * share
        # A press moves it by one step even when less was asked for, if that is allowed at all.
        # ROUNDING: 0.3 / 0.1 is 2.999… in floating point; floor would lose a step.
        count = min(
            math.floor(limit / step + ROUNDING), max(1, math.floor(abs(wish) / step + ROUNDING))
        )
        if math.isfinite(measured) and measured * sign + step > limit + step * ROUNDING:
            # It goes as fast as it may already, whatever was counted.
            count = min(count, max(0, self._counts[axis] * sign))
            # Half a step over is more than noise of the measurement: come back to rest.
            if measured * sign > limit + step / 2:
                count = 0
        return sign * count

    def _axis_limit(self, axis: int, sign: int) -> float:
        drive = self._drive
        if axis == 1:
            return drive.max_turn
        if sign > 0 or drive.max_reverse is None:
            return drive.max_speed
        return drive.max_reverse
