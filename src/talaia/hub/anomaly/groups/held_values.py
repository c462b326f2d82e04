"""Samples of several signals, of any rates and with gaps, as rows on a common step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.hub.anomaly.base import Floats  # noqa: TC001 - msgspec reads the annotations

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["NEVER", "HeldValues", "bounded_values"]

# Before all times.
NEVER = -(2**62)
# A value is held for so many of its signal's usual intervals, between these bounds (steps).
_HELD, _LEAST_HELD, _MOST_HELD = 5.0, 10.0, 600.0
# Squares of such values, and sums of them, still fit into a float.
_LARGEST = 1e150


def bounded_values(values: Floats) -> Floats:
    """Give values, or the largest whose squares are still numbers."""
    # Least and greatest one by one: `clip` takes three times as long for so few.
    bounded: Floats = np.minimum(np.maximum(values, -_LARGEST), _LARGEST)
    return bounded


class HeldValues(msgspec.Struct, kw_only=True):
    """The newest value of each signal, how old it is, and how long it may stand for one now.

    Attributes:
        count: of the signals.
        newest_us: time of the newest row (µs).
        gathering: number of the step that samples are gathered for.
        gathered: values (one a signal) that came for that step; NaN where none did.
        values: the newest of each signal; NaN before there is one.
        ages: of those (steps).
        holds: so old they may be (steps).
        came: so many rows had a value of the signal itself.

    """

    count: int
    newest_us: int = NEVER
    gathering: int = NEVER
    gathered: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    values: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    ages: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    holds: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    came: Floats = msgspec.field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Make room for as many signals as there are."""
        # What was kept over a restart has its room already.
        if len(self.values) != self.count:
            self.values, self.gathered = np.full((2, self.count), np.nan)
            self.ages, self.holds = np.full(self.count, np.inf), np.full(self.count, _MOST_HELD)
            self.came = np.zeros(self.count)

    def begin_step(self, step: int) -> None:
        """Gather for a newer step."""
        self.gathered[:] = np.nan
        self.gathering = step

    def hold_row(self, time_us: int, steps: int, values: Floats) -> Floats:
        """Take the row of a step in.

        Args:
            time_us: of the row.
            steps: so many after the row before.
            values: one for each signal, NaN or infinite where there is none.

        Returns:
            The row, with values from before where they are not too old; else NaN.

        """
        self.newest_us = time_us
        here = np.isfinite(values)
        np.copyto(self.values, bounded_values(values), where=here)
        self.ages += steps
        self.ages[here] = 0.0
        self.came += here
        return np.where(self.ages <= self.holds, self.values, np.nan)

    def learn_holds(self, rows: int, unknown: NDArray[np.bool_]) -> None:
        """Learn how long values may be held from the ``rows`` that were seen.

        Args:
            rows: so many there were.
            unknown: signals of which too little was seen: they are never held, nor used.

        """
        self.holds = np.clip(_HELD * rows / np.maximum(self.came, 1.0), _LEAST_HELD, _MOST_HELD)
        self.holds[unknown] = -1.0
