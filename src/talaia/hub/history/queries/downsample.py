"""Make a series small enough to draw, without losing what the eye looks for.

A chart draws so many pixels; more than the least and the greatest value of each cannot be seen.
Pixels are anchored to the epoch, not to the window, so that a chart that is moved by a little
gets the same points again and does not flicker.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = [
    "bucket_extremes",
    "bucket_starts",
    "distinct_positions",
    "edges_of",
    "pixel_width",
    "steps_of",
]


def pixel_width(span_us: int, width: int, multiple_us: int = 1) -> int:
    """Give the pixel's width (µs) with which a window never covers more than ``width`` of them.

    Args:
        span_us: how long the window is, both ends included.
        width: pixels of the chart; with one, everything is one pixel, and the answer is 0.
        multiple_us: the answer is a multiple of this.

    """
    if width < 2:
        return 0
    # An anchored pixel may stick out at either end: plan for one pixel less.
    least = -(-span_us // (width - 1))
    return max(1, -(-least // multiple_us)) * multiple_us


def bucket_starts(time_us: NDArray[np.int64], width_us: int) -> NDArray[np.intp]:
    """Give where each bucket of ``width_us`` begins in times that are in order.

    Width 0 means one bucket for all.
    """
    if not time_us.size:
        return np.empty(0, np.intp)
    if width_us == 0:
        return np.zeros(1, np.intp)
    bucket = time_us // width_us
    return np.concatenate(([0], np.flatnonzero(bucket[1:] != bucket[:-1]) + 1))


def bucket_extremes(
    value: NDArray[np.float64], starts: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Find for each group the position of its first least and first greatest value.

    NaN counts as neither; a group of nothing but NaN answers with its first position.
    """
    sizes = np.diff(np.append(starts, value.size))
    group = np.repeat(np.arange(starts.size), sizes)

    def first_equal(wanted: NDArray[np.float64]) -> NDArray[np.intp]:
        hits = np.flatnonzero(value == wanted[group])[::-1]
        found = starts.astype(np.intp, copy=True)
        # Of several assignments to one place the last stays, which is the first hit.
        found[group[hits]] = hits
        return found

    # fmin and fmax pass over NaN.
    return (
        first_equal(np.fmin.reduceat(value, starts)),
        first_equal(np.fmax.reduceat(value, starts)),
    )


def distinct_positions(lists: Sequence[NDArray[np.intp]]) -> NDArray[np.intp]:
    """Give the positions of all lists, each once and in order.

    `numpy.unique` hashes first, which takes five times as long as to sort what is nearly in order.
    """
    positions = np.sort(np.concatenate(lists), kind="stable")
    is_new = np.empty(positions.size, np.bool_)
    is_new[:1] = True
    np.not_equal(positions[1:], positions[:-1], out=is_new[1:])
    return positions[is_new]


def edges_of(starts: NDArray[np.intp], size: int) -> NDArray[np.intp]:
    """Give the first and the last position of each group, each once and in order.

    This is how texts are thinned: they have no least and no greatest.
    """
    return distinct_positions((starts, np.append(starts[1:], size) - 1))


def steps_of(value: NDArray[np.float64], starts: NDArray[np.intp]) -> NDArray[np.intp]:
    """Give the last position of each group, and one with another value if there is any.

    This is how states are thinned: what is drawn up to the next point must be what held last.
    """
    last = np.append(starts[1:], value.size) - 1
    low, high = bucket_extremes(value, starts)
    held = value[last]
    other = np.where(value[high] != held, high, low)
    return distinct_positions((last, other[value[other] != held]))
