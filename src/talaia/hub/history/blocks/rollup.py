"""Sums of many samples: least, greatest, sum, last and count of each bucket of time.

Buckets are anchored to the epoch: bucket ``b`` of width ``w`` holds the times ``b <= t < b + w``
where ``b`` is a multiple of ``w``. Each width of `WIDTHS` is for charts of another length. The
least and the greatest carry their own time, so that a spike is drawn where it was.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time

from talaia.hub.history.queries.downsample import bucket_extremes, bucket_starts

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "WIDTHS",
    "Cells",
    "RollupPiece",
    "cover_window",
    "finest_width",
    "join_cells",
    "merge_cells",
    "summarise_samples",
    "tier_for",
    "widen_cells",
]

SECOND = 1_000_000
# Chosen so that a day, a week, a month and a year at 1000 pixels take 3 000 to 9 000 rows.
WIDTHS = tuple(s * SECOND for s in (5, 30, 120, 600, 3_600, 21_600, 86_400))
# A row costs about as much as 40 compressed samples: with fewer a bucket, reading the samples
# themselves is as quick, and the rows would be most of the disk.
WORTH = 64
# How much wider than asked for a pixel may become so that it holds whole buckets. It is that much
# only where a pixel is little wider than the narrowest buckets, and at most 1.5 elsewhere.
COARSER = 2.0
# Buckets a pixel may be made of: more of them make it fit better, and take longer to read.
_MOST_BUCKETS = 9


class Cells(NamedTuple):
    """Summaries side by side; all arrays have the shape (n,).

    Attributes:
        bucket_us: where the bucket begins.
        samples: how many there were.
        numbers: how many of them were finite; the mean is ``total / numbers``.
        total: sum of the finite values.
        squares: sum of the squared distances of the finite values from their mean; NaN in rows
            that were written before there was such a column.
        low: least value, infinities included; NaN if there was nothing but NaN.
        low_us: when that was.
        high: greatest value.
        high_us: when that was.
        last: the last value, whatever it was.
        last_us: when that was.

    """

    bucket_us: NDArray[np.int64]
    samples: NDArray[np.int64]
    numbers: NDArray[np.int64]
    total: NDArray[np.float64]
    squares: NDArray[np.float64]
    low: NDArray[np.float64]
    low_us: NDArray[np.int64]
    high: NDArray[np.float64]
    high_us: NDArray[np.int64]
    last: NDArray[np.float64]
    last_us: NDArray[np.int64]

    def newest_cell(self) -> Cells:
        """Give the last cell alone."""
        return _select_cells(self, np.array([-1]))


_INTS, _FLOATS = np.empty(0, np.int64), np.empty(0, np.float64)
_NONE = Cells(_INTS, _INTS, _INTS, _FLOATS, _FLOATS, _FLOATS, _INTS, _FLOATS, _INTS, _FLOATS, _INTS)


def summarise_samples(
    time_us: NDArray[np.int64], value: NDArray[np.float64], width_us: int
) -> Cells:
    """Sum up samples in order of time; width 0 makes one cell of all that begins at the first."""
    starts = bucket_starts(time_us, width_us)
    if not starts.size:
        return _select_cells(_NONE, starts)
    ends = np.append(starts[1:], time_us.size)
    finite = np.isfinite(value)
    low, high = bucket_extremes(value, starts)
    first = time_us[starts]
    sizes = ends - starts
    numbers = np.add.reduceat(finite.astype(np.int64), starts)
    # A sum beyond all floats is infinite, and shown as that.
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.add.reduceat(np.where(finite, value, 0.0), starts)
        mean = np.repeat(total / np.maximum(numbers, 1), sizes)
        squares = np.add.reduceat(np.where(finite, value - mean, 0.0) ** 2, starts)
    return Cells(
        bucket_us=first // width_us * width_us if width_us else first,
        samples=sizes,
        numbers=numbers,
        total=total,
        squares=squares,
        low=value[low],
        low_us=time_us[low],
        high=value[high],
        high_us=time_us[high],
        last=value[ends - 1],
        last_us=time_us[ends - 1],
    )


def join_cells(parts: Sequence[Cells]) -> Cells:
    """Put cells one after the other."""
    return Cells(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def merge_cells(cells: Cells) -> Cells:
    """Make one cell of all those with the same bucket; of equal times the later cell's is last."""
    cells = _select_cells(cells, np.argsort(cells.bucket_us, kind="stable"))
    starts = bucket_starts(cells.bucket_us, 1)
    if starts.size == cells.bucket_us.size:
        return cells
    low, _ = bucket_extremes(cells.low, starts)
    _, high = bucket_extremes(cells.high, starts)
    by_time = np.lexsort((cells.last_us, cells.bucket_us))
    last = by_time[np.append(starts[1:], by_time.size) - 1]
    sizes = np.diff(np.append(starts, cells.bucket_us.size))
    numbers = np.add.reduceat(cells.numbers, starts)
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.add.reduceat(cells.total, starts)
        mean = np.repeat(total / np.maximum(numbers, 1), sizes)
        apart = cells.total / np.maximum(cells.numbers, 1) - mean
        squares = np.add.reduceat(cells.squares + cells.numbers * apart**2, starts)
    return Cells(
        bucket_us=cells.bucket_us[starts],
        samples=np.add.reduceat(cells.samples, starts),
        numbers=numbers,
        total=total,
        squares=squares,
        low=cells.low[low],
        low_us=cells.low_us[low],
        high=cells.high[high],
        high_us=cells.high_us[high],
        last=cells.last[last],
        last_us=cells.last_us[last],
    )


def widen_cells(cells: Cells, width_us: int) -> Cells:
    """Sum cells up into wider ones; ``width_us`` is a multiple of what they have."""
    return merge_cells(cells._replace(bucket_us=cells.bucket_us // width_us * width_us))


def finest_width(time_us: NDArray[np.int64]) -> int:
    """Give the finest width worth its rows for samples in order of time; 0 if none is."""
    for width_us in WIDTHS:
        if time_us.size >= WORTH * bucket_starts(time_us, width_us).size:
            return width_us
    return 0


def tier_for(pixel_us: int) -> int:
    """Give the width of the buckets that fit a pixel best; 0 if they make it too wide."""
    fitting = []
    for width_us in WIDTHS:
        buckets = -(-pixel_us // width_us)
        if buckets <= _MOST_BUCKETS or width_us == WIDTHS[-1]:
            # Of two that fit as well, the one that has fewer rows.
            fitting.append((buckets * width_us, -width_us))
    wide_us, width_us = min(fitting)
    return -width_us if wide_us <= COARSER * pixel_us else 0


class RollupPiece(NamedTuple):
    """A stretch of time that buckets of one width fill exactly; width 0: the samples themselves."""

    width_us: int
    from_us: int
    past_us: int


def cover_window(from_us: int, past_us: int, width_us: int) -> list[RollupPiece]:
    """Cover a half-open window with buckets of ``width_us``, and its ends with narrower ones."""
    if from_us >= past_us:
        return []
    if not width_us:
        return [RollupPiece(0, from_us, past_us)]
    finer = max((w for w in WIDTHS if w < width_us), default=0)
    first, past = -(-from_us // width_us) * width_us, past_us // width_us * width_us
    if first >= past:
        return cover_window(from_us, past_us, finer)
    middle = RollupPiece(width_us, first, past)
    return [*cover_window(from_us, first, finer), middle, *cover_window(past, past_us, finer)]


def _select_cells(cells: Cells, order: NDArray[np.intp]) -> Cells:
    columns: list[NDArray[Any]] = [column[order] for column in cells]
    return Cells(*columns)
