"""The stretches of a signal that are nearest to the newest ones, for many of these at once.

Which are near is found by products of matrices, how near by sums of squares: so it takes a fraction
of the time of comparing each with all others, and nothing small is lost beside the great.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.hub.anomaly.base import Floats

__all__ = ["FARTHEST", "LENGTH", "NEIGHBOURS", "STRETCHES", "nearest_squares", "stretches_of"]

# Samples in a stretch, neighbours, stretches compared with.
LENGTH, NEIGHBOURS, STRETCHES = 19, 3, 1000
# The stretch that is compared with and begins earliest does so that much before the newest one.
FARTHEST = LENGTH + STRETCHES - 1
# So many lags are summed up at once (bytes): what that takes fits a processor's cache.
_LAG_BYTES = 800
# The nearest ones are sought among so many. Sums of products of a stretch are off by at most so
# many roundings, where values are between -1 and 1.
_CANDIDATES, _SUM_OFF = 5, 1_000.0
# So many stretches are multiplied at once: larger products are shared out among all cores, which
# for so small ones takes many times as long. Distances of so many are brought into line at once.
_PRODUCT_ROWS, _ROWS_AT_ONCE = 12, 48


def stretches_of(values: Floats) -> Floats:
    """Give all stretches of values that lie one behind the other in memory (n - 18, 19).

    A view, as `sliding_window_view` gives it, in a tenth of the time that it takes.
    """
    step = values.itemsize
    return np.ndarray((len(values) - LENGTH + 1, LENGTH), values.dtype, values, 0, (step, step))


def nearest_squares(values: Floats, many: int) -> Floats:
    """Give the squared distances of the newest stretches to the nearest ones before them.

    Each is the sum that there is for that stretch by itself, to the last bit, but where several
    distances differ by less than a sum is off.

    Args:
        values: the newest stretches (``many``, each a sample later), and `FARTHEST` before them.
        many: how many stretches.

    Returns:
        many × `NEIGHBOURS`, the least first.

    """
    low, high = float(values.min()), float(values.max())
    middle, half = 0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low
    if half == 0.0:
        return np.zeros((many, NEIGHBOURS))
    scaled = (values - middle) / half
    # Which are near is found in 32 bits and, where these do not tell, in 64; how near, by sums of
    # squares that leave nothing small beside the great.
    every = np.arange(many)
    squares, off = _sought_squares(values, scaled, every, np.float32)
    unsure = every[_is_unsure(squares, off, half)]
    if len(unsure):
        found, off = _sought_squares(values, scaled, unsure, np.float64)
        squares[unsure] = found
        unsure = unsure[_is_unsure(found, off, half)]
    if len(unsure):
        places = _least_of(_lagged_distances(scaled, many)[unsure], _CANDIDATES)[1]
        squares[unsure] = _exact_squares(values, unsure, places)
    return squares


def _is_unsure(squares: Floats, least: Floats, half: float) -> NDArray[np.bool_]:
    """Tell where others may be nearer (rows,); ``least``: squares of what they are off, scaled."""
    farthest = np.square(np.sqrt(squares[:, -1]) / half)
    unsure: NDArray[np.bool_] = (farthest > least) & (farthest > 0.0)
    return unsure


def _sought_squares(
    values: Floats, scaled: Floats, rows: NDArray[np.int64], kind: type[np.floating[Any]]
) -> tuple[Floats, Floats]:
    """Seek the nearest stretches by rough distances in numbers of a kind.

    Args:
        values: see `nearest_squares`.
        scaled: these between -1 and 1.
        rows: which of the newest stretches.
        kind: of 32 or 64 bits.

    Returns:
        Squared distances (rows × `NEIGHBOURS`), the least first, and the least that those which
        were not looked at have, of the scaled values (rows,).

    """
    stretches = stretches_of(scaled)
    norms = np.einsum("ij,ij->i", stretches, stretches)
    rough, places = _least_of(_rough_distances(stretches, norms, rows, kind), _CANDIDATES)
    # All others are at least as far as the last that was found, but for what a sum is off.
    least = rough[:, -1] + norms[FARTHEST + rows] - _SUM_OFF * np.finfo(kind).eps
    return _exact_squares(values, rows, places), least


def _exact_squares(values: Floats, rows: NDArray[np.int64], places: NDArray[np.int64]) -> Floats:
    """Give the least squared distances (rows × `NEIGHBOURS`) of candidates (rows × some)."""
    stretches = stretches_of(values)
    off = stretches[rows[:, None] + places]
    off -= stretches[FARTHEST + rows][:, None]
    squares: Floats = np.einsum("ijk,ijk->ij", off, off)
    squares.sort(axis=1)
    return squares[:, :NEIGHBOURS]


def _rough_distances(
    stretches: Floats, norms: Floats, rows: NDArray[np.int64], kind: type[np.floating[Any]]
) -> NDArray[Any]:
    """Give the squared distances of stretches to all those before them, by products.

    Args:
        stretches: all, between -1 and 1.
        norms: their squares.
        rows: which of the newest ones, whose distances are asked for; rising.
        kind: of the numbers to reckon in.

    Returns:
        rows × `STRETCHES` or more, the farthest first, each less its own square; infinite beyond
        these.

    """
    # |b|² - 2ab of each pair as one product: the square of b stands in a row of its own. Behind the
    # last one there is room for those that the last rows are not held against.
    others = np.zeros((LENGTH + 1, len(stretches) + _ROWS_AT_ONCE), kind)
    there = others[:, : len(stretches)]
    there[:LENGTH] = stretches.T
    there[LENGTH] = norms
    mine = np.ones((len(rows), LENGTH + 1), kind)
    np.multiply(stretches[FARTHEST + rows], -2.0, out=mine[:, :LENGTH], casting="same_kind")
    if rows[-1] - rows[0] == len(rows) - 1:
        return _multiply_next(mine, others[:, rows[0] :])
    apart = np.empty((len(rows), STRETCHES), kind)
    for at, row in enumerate(rows.tolist()):
        np.matmul(mine[at], others[:, row : row + STRETCHES], out=apart[at])
    return apart


def _multiply_next(mine: NDArray[Any], others: NDArray[Any]) -> NDArray[Any]:
    """Multiply each row with `STRETCHES` columns, that begin one further on for each next row."""
    # Of a product of many rows with all their columns these are a slanting band. In memory where
    # each row has one more than the product's, the band stands upright.
    wide = STRETCHES + _ROWS_AT_ONCE - 1
    upright = np.empty((len(mine), wide + 1), mine.dtype)
    memory = upright.reshape(-1)
    for at in range(0, len(mine), _ROWS_AT_ONCE):
        some = mine[at : at + _ROWS_AT_ONCE]
        begin = at * (wide + 1)
        made = memory[begin : begin + len(some) * wide].reshape(len(some), wide)
        columns = others[:, at : at + wide]
        for row in range(0, len(some), _PRODUCT_ROWS):
            part = slice(row, row + _PRODUCT_ROWS)
            np.matmul(some[part], columns, out=made[part])
    upright[:, STRETCHES:] = np.inf
    return upright


def _least_of(apart: NDArray[Any], many: int) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Give the least of each row (rows × many), and their places; what they were is overwritten."""
    flat, least = apart.reshape(-1), np.empty((many, len(apart)), apart.dtype)
    places = np.empty((many, len(apart)), np.int64)
    begins = np.arange(0, apart.size, apart.shape[1])
    for at in range(many):
        # A few searches for the least take a third of the time of a partition.
        apart.argmin(axis=1, out=places[at])
        found = places[at] + begins
        flat.take(found, out=least[at])
        flat[found] = np.inf
    return least.T, places.T


def _lagged_distances(values: NDArray[Any], many: int) -> NDArray[Any]:
    """Give the squared distances of the newest stretches to all those before them.

    Args:
        values: see `nearest_squares`; of 32 or 64 bits, as what is given.
        many: how many stretches.

    Returns:
        many × `STRETCHES`, the farthest first.

    """
    kind = values.dtype
    apart = np.empty((many, STRETCHES), kind)
    rows = many + LENGTH - 1
    newest = values[FARTHEST:][:, None]
    # Row by row what each sample is held against; the column says how far before.
    earlier = sliding_window_view(values, STRETCHES)[:rows]
    # Made once: fresh memory for each step would cost more than the sums.
    lags_at_once = _LAG_BYTES // kind.itemsize
    one, two, four, eight = (np.empty((rows - less, lags_at_once), kind) for less in (0, 1, 3, 7))
    for lag in range(0, STRETCHES, lags_at_once):
        lags = slice(lag, lag + lags_at_once)
        # Squares of single samples, then of stretches of 2, 4, 8 and 16, which with 2 and 1 more
        # are a stretch: only sums, so nothing small is lost beside the great.
        np.subtract(newest, earlier[:, lags], out=one)
        np.multiply(one, one, out=one)
        np.add(one[1:], one[:-1], out=two)
        np.add(two[2:], two[:-2], out=four)
        np.add(four[4:], four[:-4], out=eight)
        part = apart[:, lags]
        np.add(eight[8 : 8 + many], eight[:many], out=part)
        np.add(part, two[16 : 16 + many], out=part)
        np.add(part, one[18 : 18 + many], out=part)
    return apart
