"""KNN-CAD: conformal anomaly detection by nearest neighbours, for one signal.

Written from the published description (Burnaev & Ishimtsev 2016, "Conformalized density- and
distance-based anomaly detection in time-series data"; Ishimtsev and others 2017, "Conformal k-NN
anomaly detector for univariate data streams"). The newest samples are a point; its strangeness is
the mean distance to its nearest neighbours among the earlier stretches; the score is the
conformal p-value of that strangeness among the earlier ones, on a logarithmic scale. Distances
are Euclidean, not Mahalanobis: the decision page says what both measure.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from talaia.hub.anomaly.base import (
    LARGEST,
    AnomalyDetector,
    Floats,
    clamp_value,
    format_number,
)
from talaia.hub.anomaly.rarity import Rarity

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Nearest"]

# Samples in a stretch, neighbours, stretches compared with, stretches before it has an opinion.
_LENGTH, _NEIGHBOURS, _STRETCHES, _LEAST = 19, 3, 1000, 40
_KEPT = _STRETCHES + 2 * _LENGTH
_MOST_FORGIVEN = 50
# The stretch that is compared with and begins earliest does so that much before the newest one.
_FARTHEST = _LENGTH + _STRETCHES - 1
# So many samples are scored at once, and so many lags (bytes): what that takes fits a processor's
# cache.
_BLOCK, _LAG_BYTES = 240, 800
# The nearest ones are sought among so many. Sums of products of a stretch are off by at most so
# many roundings, where values are between -1 and 1.
_CANDIDATES, _SUM_OFF = 5, 1_000.0
# So many stretches are multiplied at once: larger products are shared out among all cores, which
# for so small ones takes many times as long. And distances of so many are held at once: more of
# them would take fresh pages of memory each time, which costs more than the sums.
_PRODUCT_ROWS, _ROWS_AT_ONCE = 12, 60


class Nearest(AnomalyDetector, kw_only=True):
    """Scores how unlike any stretch of before the newest stretch is."""

    faster_many: ClassVar[bool] = True
    rarity: Rarity = msgspec.field(default_factory=Rarity)
    # Twice as long as needed, so that it is moved down once in a while only.
    values: Floats = msgspec.field(default_factory=lambda: np.zeros(2 * _KEPT))
    # One past the newest sample.
    end: int = 0
    score: float = 0.0
    distance: float = 0.0
    # The greatest distance of late, and the stretch that it was of: what a person may call usual.
    strangest: float = 0.0
    strange: Floats = msgspec.field(default_factory=lambda: np.zeros(_LENGTH))
    # Stretches that a person called usual, one behind the other.
    forgiven: Floats = msgspec.field(default_factory=lambda: np.zeros(0))

    def see(self, time_us: int, value: float) -> float:
        """Score the stretch that ends with this sample."""
        off = self._measure_newest(value)
        self.score = self.rarity.rate_magnitude(off) if off >= 0.0 else 0.0
        return self.score

    def _measure_newest(self, value: float) -> float:
        """Take the newest value; give how far off the nearest stretches are, -1 before it can."""
        if self.end == len(self.values):
            self.values[:_KEPT] = self.values[_KEPT:]
            self.end = _KEPT
        self.values[self.end] = clamp_value(value)
        self.end += 1
        # Neighbours do not overlap the stretch itself.
        have = min(self.end - 2 * _LENGTH + 1, _STRETCHES)
        if have < _LEAST - _LENGTH:
            return -1.0
        self.distance = self._nearest_distance(have)
        self.strangest *= 0.98
        if self.distance >= self.strangest:
            self.strangest = self.distance
            self.strange = self.values[self.end - _LENGTH : self.end].copy()
        return self.distance

    def see_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """Score samples in their order (n,), as `see` does one by one; see `Rarity.rate_many`."""
        return self.rate_many(times, values)[0]

    def magnitudes(self) -> tuple[float, ...]:
        """Give how far off the nearest stretches are."""
        return (self.distance,)

    def rate_many(self, times: NDArray[np.int64], values: Floats) -> tuple[Floats, Floats]:
        """See `AnomalyDetector.rate_many`."""
        offs = self.measure_many(values)
        scores = self.rarity.rate_many(offs)
        self.score = float(scores[-1])
        return scores, np.maximum(offs, 0.0)[:, None]

    def measure_many(self, values: Floats) -> Floats:
        """Take values as `see_many` does; give how far off the nearest stretches are, unrated.

        Returns:
            (n,), -1 before it can be told.

        """
        offs, at = np.empty(len(values)), 0
        while at < len(values):
            room = len(self.values) - self.end
            have = self.end - 2 * _LENGTH + 1
            # Until there are as many stretches as ever; and before the array is moved down.
            if have < _STRETCHES or room == 0 or len(self.forgiven):
                offs[at] = self._measure_newest(float(values[at]))
                at += 1
                continue
            upto = min(len(values), at + room)
            offs[at:upto] = self._measure_block(values[at:upto])
            at = upto
        return offs

    def _measure_block(self, values: Floats) -> Floats:
        first, many = self.end, len(values)
        self.values[first : first + many] = np.clip(values, -LARGEST, LARGEST)
        self.end += many
        seen = self.values[first - _LENGTH + 1 - _FARTHEST : self.end]
        squares = [
            _nearest_squares(seen[at : at + _BLOCK + _FARTHEST + _LENGTH - 1], min(_BLOCK, many - at))
            for at in range(0, many, _BLOCK)
        ]
        distances: Floats = np.sqrt(np.concatenate(squares)).sum(axis=1) / _NEIGHBOURS
        self.distance = float(distances[-1])
        strangest = -1
        for place, distance in enumerate(distances.tolist()):
            self.strangest *= 0.98
            if distance >= self.strangest:
                self.strangest, strangest = distance, place
        if strangest >= 0:
            end = first + strangest + 1
            self.strange = self.values[end - _LENGTH : end].copy()
        return distances

    def _nearest_distance(self, have: int) -> float:
        newest = self.values[self.end - _LENGTH : self.end]
        last = self.end - _LENGTH
        before = self.values[last - have - _LENGTH + 1 : last]
        stretches = sliding_window_view(before, _LENGTH)
        apart = _squared_distances(stretches, newest)
        if len(self.forgiven):
            apart = np.append(apart, _squared_distances(self.forgiven.reshape(-1, _LENGTH), newest))
        near = min(_NEIGHBOURS, len(apart))
        nearest = np.sqrt(np.partition(apart, near - 1)[:near])
        # A stretch that was called usual is usual by itself, without two others like it.
        if len(self.forgiven) and float(apart[have:].min()) < float(np.square(nearest.mean())):
            return math.sqrt(float(apart[have:].min()))
        return float(nearest.mean())

    def why(self) -> str:
        """Tell how far off the nearest stretches are."""
        off = self.distance / math.sqrt(_LENGTH)
        return (
            f"the newest {_LENGTH} samples look like none of before: even the nearest "
            f"{_NEIGHBOURS} stretches are {format_number(off)} {self.unit}".rstrip()
            + " off in the mean, rarely so far"
        )

    def forgive(self) -> bool:
        """Take the strangest stretch of late among the usual ones."""
        kept = self.forgiven[-_LENGTH * (_MOST_FORGIVEN - 1) :]
        self.forgiven = np.concatenate([kept, self.strange])
        self.rarity.learn_magnitude(self.strangest)
        return True


def _squared_distances(stretches: Floats, newest: Floats) -> Floats:
    off = stretches - newest
    squares: Floats = np.einsum("ij,ij->i", off, off)
    return squares


def _nearest_squares(values: Floats, many: int) -> Floats:
    """Give the squared distances of the newest stretches to the nearest ones before them.

    Args:
        values: the newest stretches (``many``, each a sample later), and `_FARTHEST` before them.
        many: how many stretches.

    Returns:
        many × `_NEIGHBOURS`, in any order.

    """
    low, high = float(values.min()), float(values.max())
    middle, half = 0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low
    if half == 0.0:
        return np.zeros((many, _NEIGHBOURS))
    scaled = (values - middle) / half
    # Which are near is found in 32 bits and, where these do not tell, in 64; how near, by sums of
    # squares that leave nothing small beside the great.
    squares, unsure = _sought_squares(scaled, np.arange(many), np.float32)
    if len(unsure):
        squares[unsure], still = _sought_squares(scaled, unsure, np.float64)
        unsure = unsure[still]
    squares *= half * half
    if len(unsure):
        squares[unsure] = _least_of(_lagged_distances(values, many)[unsure], _NEIGHBOURS)[0]
    return squares


def _sought_squares(
    scaled: Floats, rows: NDArray[np.int64], kind: type[np.floating[Any]]
) -> tuple[Floats, NDArray[np.int64]]:
    """Seek the nearest stretches by rough distances in numbers of a kind.

    Args:
        scaled: see `_nearest_squares`, between -1 and 1.
        rows: which of the newest stretches.
        kind: of 32 or 64 bits.

    Returns:
        Squared distances (rows × `_NEIGHBOURS`), and the places in ``rows`` of those that the
        rough ones do not tell for certain.

    """
    stretches = sliding_window_view(scaled, _LENGTH)
    newest = stretches[_FARTHEST + rows]
    rough, places = _least_of(_rough_distances(stretches, newest, rows, kind), _CANDIDATES)
    off = stretches[rows[:, None] + places] - newest[:, None]
    squares = np.partition(np.einsum("ijk,ijk->ij", off, off), _NEIGHBOURS - 1)[:, :_NEIGHBOURS]
    # All others are at least as far as the last that was found, but for what a sum is off.
    least = rough[:, -1] + np.einsum("ij,ij->i", newest, newest) - _SUM_OFF * np.finfo(kind).eps
    farthest = squares.max(axis=1)
    return squares, np.flatnonzero((farthest > least) & (farthest > 0.0))


def _rough_distances(
    stretches: Floats, newest: Floats, rows: NDArray[np.int64], kind: type[np.floating[Any]]
) -> NDArray[Any]:
    """Give the squared distances of stretches to all those before them, by products.

    Args:
        stretches: all, between -1 and 1.
        newest: of these, those whose distances are asked for.
        rows: which of the newest these are, rising.
        kind: of the numbers to reckon in.

    Returns:
        rows × `_STRETCHES`, the farthest first, each less its own square.

    """
    # |b|² - 2ab of each pair as one product: the square of b stands in a row of its own.
    others = np.empty((_LENGTH + 1, len(stretches)), kind)
    others[:_LENGTH] = stretches.T
    np.einsum("ij,ij->i", stretches, stretches, out=others[_LENGTH], casting="same_kind")
    mine = np.ones((len(newest), _LENGTH + 1), kind)
    np.multiply(newest, -2.0, out=mine[:, :_LENGTH], casting="same_kind")
    apart = np.empty((len(newest), _STRETCHES), kind)
    for at in range(0, len(rows), _ROWS_AT_ONCE):
        some = rows[at : at + _ROWS_AT_ONCE] - rows[at]
        columns = others[:, rows[at] : rows[at] + some[-1] + _STRETCHES]
        upto, wide = at + len(some), columns.shape[1]
        # With room for one more in each row: see below.
        room = np.empty(len(some) * (wide + 1), kind)
        made = room[: len(some) * wide].reshape(len(some), wide)
        for row in range(0, len(some), _PRODUCT_ROWS):
            rest = slice(row, row + _PRODUCT_ROWS)
            np.matmul(mine[at:upto][rest], columns, out=made[rest])
        # Each row is held against other columns, as many further as it is later.
        if some[-1] == len(some) - 1:
            # So those of rows one after the other are a slanting band, which in rows of one more
            # stands upright.
            apart[at:upto] = room.reshape(len(some), wide + 1)[:, :_STRETCHES]
            continue
        for place, row in enumerate(some.tolist()):
            apart[at + place] = made[place, row : row + _STRETCHES]
    return apart


def _least_of(apart: NDArray[Any], many: int) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Give the least of each row (rows × many), and their places; what they were is overwritten."""
    flat, least = apart.reshape(-1), np.empty((len(apart), many), apart.dtype)
    places = np.empty((len(apart), many), np.int64)
    begins = np.arange(0, apart.size, apart.shape[1])
    for at in range(many):
        # A few searches for the least take a third of the time of a partition.
        found = places[:, at] = apart.argmin(axis=1)
        found = found + begins
        least[:, at] = flat[found]
        flat[found] = np.inf
    return least, places


def _lagged_distances(values: NDArray[Any], many: int) -> NDArray[Any]:
    """Give the squared distances of the newest stretches to all those before them.

    Args:
        values: see `_nearest_squares`; of 32 or 64 bits, as what is given.
        many: how many stretches.

    Returns:
        many × `_STRETCHES`, the farthest first.

    """
    kind = values.dtype
    apart = np.empty((many, _STRETCHES), kind)
    rows = many + _LENGTH - 1
    newest = values[_FARTHEST:][:, None]
    # Row by row what each sample is held against; the column says how far before.
    earlier = sliding_window_view(values, _STRETCHES)[:rows]
    # Made once: fresh memory for each step would cost more than the sums.
    lags_at_once = _LAG_BYTES // kind.itemsize
    one, two, four, eight = (np.empty((rows - less, lags_at_once), kind) for less in (0, 1, 3, 7))
    for lag in range(0, _STRETCHES, lags_at_once):
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
