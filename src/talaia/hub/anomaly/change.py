"""Changes of level at several paces: the newest samples against a much longer stretch before.

A step, a spike, a slow departure and a change of pace each show at one of the paces; that they are
judged together keeps a single noisy sample from counting for much.
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
    fading_peak,
    format_duration,
    format_number,
    keep_newest,
)
from talaia.hub.anomaly.rarity import Rarity, rate_together

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["ChangePointDetector"]

# Newest samples that make a mean; the stretch before it is 32 times as long.
_PACES = (1, 3, 12, 24)
_BEFORE = 32
_KEPT = _PACES[-1] * (_BEFORE + 1)
# As NumPy adds up: in so many lanes, and more than so many values by halves.
_LANES, _ADDED_IN_LANES = 8, 128


class ChangePointDetector(AnomalyDetector, kw_only=True):
    """Scores how unusual the newest changes of level are, for this signal."""

    faster_many: ClassVar[bool] = True
    rarities: list[Rarity] = msgspec.field(default_factory=lambda: [Rarity() for _ in _PACES])
    # Twice as long as needed, so that it is moved down once in a while only.
    values: Floats = msgspec.field(default_factory=lambda: np.zeros(2 * _KEPT))
    times: Floats = msgspec.field(default_factory=lambda: np.zeros(2 * _KEPT))
    # One past the newest sample.
    end: int = 0
    # For each pace how rare its change is, the change itself, and the greatest one of late.
    scores: list[float] = msgspec.field(default_factory=lambda: [0.0] * len(_PACES))
    changes: list[float] = msgspec.field(default_factory=lambda: [0.0] * len(_PACES))
    peak: list[float] = msgspec.field(default_factory=lambda: [0.0] * len(_PACES))

    def see(self, time_us: int, value: float) -> float:
        """Score the newest sample: the mean square of its rarities at all paces."""
        sizes = self._measure_newest(time_us, value)
        for at, size in enumerate(sizes):
            if size >= 0.0:
                self.scores[at] = self.rarities[at].rate_magnitude(size)
                # What it was forgiven for is the greatest of late.
                self.peak[at] = max(size, self.peak[at] * 0.98)
        return math.sqrt(sum(score * score for score in self.scores) / len(_PACES))

    def _measure_newest(self, time_us: int, value: float) -> list[float]:
        """Take the newest sample; give its change at each pace, -1 where too few came."""
        if self.end == len(self.values):
            self.values[:_KEPT] = self.values[_KEPT:]
            self.times[:_KEPT] = self.times[_KEPT:]
            self.end = _KEPT
        self.values[self.end], self.times[self.end] = clamp_value(value), time_us
        self.end += 1
        sizes = [-1.0] * len(_PACES)
        for at, pace in enumerate(_PACES):
            # With less before it, a signal that drifts changes more with every sample.
            if self.end < (_BEFORE + 1) * pace:
                break
            newest, before = self._mean_levels(pace)
            self.changes[at] = newest - before
            sizes[at] = abs(newest - before)
        return sizes

    def see_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """Score samples in their order (n,), as `see` does one by one; see `Rarity.rate_many`."""
        return self.rate_many(times, values)[0]

    def magnitudes(self) -> tuple[float, ...]:
        """Give the change at each pace."""
        return tuple(abs(change) for change in self.changes)

    def rate_many(self, times: NDArray[np.int64], values: Floats) -> tuple[Floats, Floats]:
        """See `AnomalyDetector.rate_many`."""
        sizes = self.measure_many(times, values)
        scores = self.score_sizes(sizes, rate_together(self.rarities, sizes))
        return scores, np.maximum(sizes, 0.0).T

    def measure_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """Take samples as `see_many` does; give the sizes of their changes, which nobody has rated.

        Returns:
            paces × n, -1 where too few came before.

        """
        sizes, at = np.empty((len(_PACES), len(values))), 0
        # At the beginning paces join in one by one.
        while at < len(values) and self.end < _KEPT:
            sizes[:, at] = self._measure_newest(int(times[at]), float(values[at]))
            at += 1
        if at < len(values):
            self._measure_block(times[at:], values[at:], sizes[:, at:])
        return sizes

    def _measure_block(self, times: NDArray[np.int64], values: Floats, sizes: Floats) -> None:
        first = _KEPT - 1
        line = np.concatenate(
            (self.values[self.end - first : self.end], np.clip(values, -LARGEST, LARGEST))
        )
        keep_newest(self.times, self.end, times.astype(np.float64))
        self.end = keep_newest(self.values, self.end, line[first:])
        for at, pace in enumerate(_PACES):
            kept = line[first - pace * (_BEFORE + 1) + 1 :]
            newest = _moving_sums(kept[pace * _BEFORE :], pace) / pace
            before = _moving_sums(kept[: len(kept) - pace], pace * _BEFORE) / (pace * _BEFORE)
            changes = newest - before
            self.changes[at] = float(changes[-1])
            np.abs(changes, out=sizes[at])

    def score_sizes(self, sizes: Floats, rarities: Floats) -> Floats:
        """Score changes (n,) by how rare they are at each pace (both paces × n)."""
        self.scores = rarities[:, -1].tolist()
        self.peak = [fading_peak(*one) for one in zip(self.peak, sizes, strict=True)]
        scores: Floats = np.sqrt((rarities * rarities).sum(axis=0) / len(_PACES))
        return scores

    def _mean_levels(self, pace: int) -> tuple[float, float]:
        split = self.end - pace
        first = max(0, split - _BEFORE * pace)
        newest = float(self.values[split : self.end].sum()) / pace
        return newest, float(self.values[first:split].sum()) / (split - first)

    def why(self) -> str:
        """Name the pace at which the change is rarest."""
        at = max(range(len(_PACES)), key=lambda pace: self.scores[pace])
        pace = _PACES[at]
        if self.end < (_BEFORE + 1) * pace:
            return "too few samples yet"
        newest, before = self._mean_levels(pace)
        first = max(0, self.end - pace - _BEFORE * pace)
        while_s = (self.times[self.end - 1] - self.times[first]) / 1e6
        what = (
            format_number(newest)
            if pace == 1
            else f"the mean of the newest {pace}, {format_number(newest)}"
        )
        way = "above" if newest >= before else "below"
        return (
            f"{what} {self.unit}".rstrip()
            + f" is {format_number(abs(newest - before))} {self.unit}".rstrip()
            + f" {way} the {format_number(before)} {self.unit}".rstrip()
            + f" of the last {format_duration(while_s)}, a change greater than nearly all before"
        )

    def forgive(self) -> bool:
        """Count changes like those of late as usual."""
        for rarity, peak in zip(self.rarities, self.peak, strict=True):
            rarity.learn_magnitude(peak)
        return True


def _moving_sums(values: Floats, length: int) -> Floats:
    """Give the sum of each stretch of so many values.

    The values of a stretch are added up in the order in which NumPy adds those of one stretch, so
    the sums are the very same; but what two stretches have in common is added up once.
    """
    if length > _ADDED_IN_LANES:
        half = length // 2 // _LANES * _LANES
        if 2 * half == length:
            halves = _moving_sums(values, half)
            return halves[:-half] + halves[half:]
        earlier = _moving_sums(values[: len(values) - length + half], half)
        later = _moving_sums(values[half:], length - half)
        return earlier + later
    many = len(values) - length + 1
    if length < _LANES:
        return _sum_shifted(values, range(length), many)
    # Every eighth value, for each of eight lanes; then the lanes in pairs, and what is left over.
    whole = length // _LANES * _LANES
    sums = _sum_shifted(values, range(0, whole, _LANES), many + _LANES - 1)
    for apart in (1, 2, 4):
        sums = sums[:-apart] + sums[apart:]
    for shift in range(whole, length):
        sums += values[shift : shift + many]
    return sums


def _sum_shifted(values: Floats, shifts: Sequence[int], many: int) -> Floats:
    sums: Floats = values[shifts[0] : shifts[0] + many].copy()
    for shift in shifts[1:]:
        sums += values[shift : shift + many]
    return sums
