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
from typing import TYPE_CHECKING, ClassVar

import msgspec
import numpy as np

from talaia.hub.anomaly.base import (
    LARGEST,
    AnomalyDetector,
    Floats,
    clamp_value,
    format_number,
    keep_newest,
)
from talaia.hub.anomaly.rarity import Rarity
from talaia.hub.anomaly.stretch_search import (
    FARTHEST,
    LENGTH,
    NEIGHBOURS,
    STRETCHES,
    nearest_squares,
    stretches_of,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Nearest"]

# Stretches before it has an opinion.
_LEAST = 40
_KEPT = STRETCHES + 2 * LENGTH
_MOST_FORGIVEN = 50
# So many samples are compared at once: what that takes fits a processor's cache.
_BLOCK = 256


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
    strange: Floats = msgspec.field(default_factory=lambda: np.zeros(LENGTH))
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
        have = min(self.end - 2 * LENGTH + 1, STRETCHES)
        if have < _LEAST - LENGTH:
            return -1.0
        self.distance = self._nearest_distance(have)
        self.strangest *= 0.98
        if self.distance >= self.strangest:
            self.strangest = self.distance
            self.strange = self.values[self.end - LENGTH : self.end].copy()
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
        # Until there are as many stretches as ever; with some that are called usual always so.
        while at < len(values) and (self.end - 2 * LENGTH + 1 < STRETCHES or len(self.forgiven)):
            offs[at] = self._measure_newest(float(values[at]))
            at += 1
        if at < len(values):
            offs[at:] = self._measure_block(np.clip(values[at:], -LARGEST, LARGEST))
        return offs

    def _measure_block(self, values: Floats) -> Floats:
        before = FARTHEST + LENGTH - 1
        line = np.concatenate((self.values[self.end - before : self.end], values))
        self.end = keep_newest(self.values, self.end, values)
        squares = [
            nearest_squares(line[at : before + upto], upto - at)
            for at in range(0, len(values), _BLOCK)
            for upto in (min(at + _BLOCK, len(values)),)
        ]
        distances: Floats = np.sqrt(np.concatenate(squares)).sum(axis=1) / NEIGHBOURS
        self.distance = float(distances[-1])
        peak, strangest = self.strangest, -1
        for place, distance in enumerate(distances.tolist()):
            peak *= 0.98
            if distance >= peak:
                peak, strangest = distance, place
        self.strangest = peak
        if strangest >= 0:
            end = before + strangest + 1
            self.strange = line[end - LENGTH : end].copy()
        return distances

    def _nearest_distance(self, have: int) -> float:
        newest = self.values[self.end - LENGTH : self.end]
        last = self.end - LENGTH
        before = self.values[last - have - LENGTH + 1 : last]
        stretches = stretches_of(before)
        apart = _squared_distances(stretches, newest)
        if len(self.forgiven):
            apart = np.append(apart, _squared_distances(self.forgiven.reshape(-1, LENGTH), newest))
        near = min(NEIGHBOURS, len(apart))
        # In order, so that their mean is the same to the last bit as of many at once.
        nearest = np.sqrt(np.sort(np.partition(apart, near - 1)[:near]))
        # A stretch that was called usual is usual by itself, without two others like it.
        if len(self.forgiven) and float(apart[have:].min()) < float(np.square(nearest.mean())):
            return math.sqrt(float(apart[have:].min()))
        return float(nearest.mean())

    def why(self) -> str:
        """Tell how far off the nearest stretches are."""
        off = self.distance / math.sqrt(LENGTH)
        return (
            f"the newest {LENGTH} samples look like none of before: even the nearest "
            f"{NEIGHBOURS} stretches are {format_number(off)} {self.unit}".rstrip()
            + " off in the mean, rarely so far"
        )

    def forgive(self) -> bool:
        """Take the strangest stretch of late among the usual ones."""
        kept = self.forgiven[-LENGTH * (_MOST_FORGIVEN - 1) :]
        self.forgiven = np.concatenate([kept, self.strange])
        self.rarity.learn_magnitude(self.strangest)
        return True


def _squared_distances(stretches: Floats, newest: Floats) -> Floats:
    off = stretches - newest
    squares: Floats = np.einsum("ij,ij->i", off, off)
    return squares
