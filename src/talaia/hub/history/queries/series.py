"""What a reader of the history gets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time

from talaia.hub.history.blocks.block import BlockSamples

__all__ = ["HistoryGap", "Series", "empty_series"]


class HistoryGap(NamedTuple):
    """From ``from_us`` to ``to_us`` (µs since the epoch) samples are missing, and why."""

    from_us: int
    to_us: int
    reason: str


class Series(NamedTuple):
    """One channel over a window; the arrays have the shape (n,) and are in order of time.

    Attributes:
        time_us: microseconds since the epoch, UTC.
        value: the readings; NaN where it is a text, or where the robot said NaN.
        texts: position in the arrays to text.
        exact: these are all samples of the window; otherwise the least and the greatest of each
            pixel stand for the rest.
        gaps: where samples are known to be missing.

    """

    address: str
    time_us: NDArray[np.int64]
    value: NDArray[np.float64]
    texts: dict[int, str]
    exact: bool
    gaps: list[HistoryGap]

    def samples(self) -> BlockSamples:
        """Give the points alone."""
        return BlockSamples(self.time_us, self.value, self.texts)


def empty_series(address: str, gaps: list[HistoryGap]) -> Series:
    """Give the series of a channel that has nothing to show."""
    return Series(
        address, np.empty(0, np.int64), np.empty(0, np.float64), {}, exact=True, gaps=gaps
    )
