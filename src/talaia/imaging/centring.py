"""Bring a target into the middle of the picture by solving and going on. Pure.

The mount is asked for a place that is off by as much as it missed. That needs no mount that can be
synced, and leaves alone what it knows of other parts of the sky.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from talaia.imaging.tangent_plane import angular_distance

__all__ = ["Centring", "CentringStep"]


class CentringStep(NamedTuple):
    """What comes next.

    Attributes:
        error: of the last picture (arc seconds); NaN before the first.
        done: the target stands in the middle.
        ra: where the mount is to go now (°, J2000).
        dec: (°, J2000).
        problem: why it gave up; empty otherwise.

    """

    error: float
    done: bool
    ra: float
    dec: float
    problem: str = ""


class Centring:
    """One target that is to be centred."""

    def __init__(self, ra: float, dec: float, *, tolerance: float = 5.0, tries: int = 5) -> None:
        """Begin; the mount has been sent to the target (°, J2000).

        Args:
            ra: of the target.
            dec: of the target.
            tolerance: so near is near enough (arc seconds).
            tries: pictures at the most.

        """
        self._target = ra, dec
        # What the mount was asked for last.
        self._asked = ra, dec
        self._tolerance, self._left = tolerance, tries
        self._last_error = math.inf

    def add_solution(self, ra: float, dec: float) -> CentringStep:
        """Hear where the middle of the picture really was (°, J2000)."""
        error = angular_distance(ra, dec, *self._target) * 3600.0
        self._left -= 1
        if error <= self._tolerance:
            return CentringStep(error, True, *self._asked)  # noqa: FBT003 - it is done
        step = CentringStep(error, False, *self._asked)  # noqa: FBT003
        if self._left <= 0:
            return step._replace(problem=f"it is still {error:.0f} ″ off after the last try")
        # A mount that does not follow must not be sent farther and farther away.
        if error > 2.0 * self._last_error and error > 60.0:
            return step._replace(
                problem=f"it got worse: {self._last_error:.0f} to {error:.0f} ″ off"
            )
        self._last_error = error
        turned = (self._target[0] - ra + 180.0) % 360.0 - 180.0
        east = (self._asked[0] + turned) % 360.0
        north = max(-90.0, min(90.0, self._asked[1] + self._target[1] - dec))
        self._asked = east, north
        return step._replace(ra=east, dec=north)
