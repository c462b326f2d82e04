"""The time of day: the newest hours against the same hours of the days before.

The day is cut into slots of five minutes, each with the mean of its samples; so the memory is
bounded whatever the rate. A signal with a daily rhythm that leaves it, if only by staying still
when it should move, differs from every one of the days before.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, ClassVar

import msgspec
import numpy as np

from talaia.hub.anomaly.base import (
    LARGEST,
    AnomalyDetector,
    Floats,
    clamp_value,
    fading_peak,
    format_number,
)
from talaia.hub.anomaly.rarity import Rarity

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Season"]

# Five minutes.
_SLOT_US = 300_000_000
# Slots of a day.
_DAY = 288
# Days that are compared with.
_DAYS = 3
# So many slots ago those days had the same hour, one day in each row.
_BACK = _DAY * np.arange(1, _DAYS + 1)[:, None]
# Hours that are compared.
_HOURS = 4
_WINDOW = _HOURS * 12
_KEPT = (_DAYS + 1) * _DAY
# So few samples of a slot are looked at one by one.
_FEW = 8
# As NumPy adds up: in so many lanes.
_LANES = 8
# With fewer slots in common two stretches are not compared.
_LEAST = 2


def _empty_slots() -> Floats:
    return np.full(_KEPT, np.nan)


class Season(AnomalyDetector, kw_only=True):
    """Scores how far the newest hours are from the same hours of each of the days before."""

    faster_many: ClassVar[bool] = True
    rarity: Rarity = msgspec.field(default_factory=Rarity)
    # The mean of each slot, in a ring; NaN where nothing came.
    means: Floats = msgspec.field(default_factory=_empty_slots)
    # Samples in each slot.
    counts: Floats = msgspec.field(default_factory=lambda: np.zeros(_KEPT))
    # The newest slot, counted since 1970; -1: none yet.
    slot: int = -1
    # Means of the last hours and of the same hours of the nearest day, for `why`.
    now: float = 0.0
    then: float = 0.0
    # How far these are apart; below 0: nothing to compare with.
    off: float = -1.0
    # The greatest of late: what a person may call usual.
    peak: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score the newest hours with this sample in them."""
        off = self._measure_newest(time_us, value)
        return self.rarity.rate_magnitude(off) if off >= 0.0 else 0.0

    def _measure_newest(self, time_us: int, value: float) -> float:
        """Take the newest sample; give how far off the hours are, below 0 without a day before."""
        value = clamp_value(value)
        slot = time_us // _SLOT_US
        self._move_slot(slot)
        at = self.slot % _KEPT
        self.counts[at] += 1.0
        mean = self.means[at]
        self.means[at] = value if np.isnan(mean) else mean + (value - mean) / self.counts[at]
        self._compare_days()
        if self.off >= 0.0:
            self.peak = max(self.off, self.peak * 0.98)
        return self.off

    def see_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """Score samples in their order (n,), as `see` does one by one; see `Rarity.rate_many`."""
        return self.rate_many(times, values)[0]

    def magnitudes(self) -> tuple[float, ...]:
        """Give how far the hours are from the nearest day's."""
        return (max(0.0, self.off),)

    def rate_many(self, times: NDArray[np.int64], values: Floats) -> tuple[Floats, Floats]:
        """See `AnomalyDetector.rate_many`."""
        offs = self.measure_many(times, values)
        return self.rarity.rate_many(offs), np.maximum(offs, 0.0)[:, None]

    def measure_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """Take samples as `see_many` does; give how far off the hours are, which nobody has rated.

        Returns:
            (n,), below 0 where there is no day to compare with.

        """
        offs = np.empty(len(values))
        slots = times // _SLOT_US
        # All of a slot are compared with the same hours.
        edges = [0, *(np.flatnonzero(np.diff(slots)) + 1).tolist(), len(values)]
        for first, upto in itertools.pairwise(edges):
            if upto - first < _FEW:
                for at in range(first, upto):
                    offs[at] = self._measure_newest(int(times[at]), float(values[at]))
                continue
            offs[first:upto] = self._measure_slot(int(slots[first]), values[first:upto])
        return offs

    def _measure_slot(self, slot: int, values: Floats) -> Floats:
        self._move_slot(slot)
        at = self.slot % _KEPT
        count, mean = float(self.counts[at]), float(self.means[at])
        means = []
        for value in np.clip(values, -LARGEST, LARGEST).tolist():
            count += 1.0
            # Of a slot without samples there is no mean, and NaN is not equal to itself.
            mean = mean + (value - mean) / count if count > 1.0 else value
            means.append(mean)
        self.counts[at], self.means[at] = count, mean
        offs = self._compare_means(np.array(means))
        if self.off < 0.0:
            return np.full(len(values), -1.0)
        self.peak = fading_peak(self.peak, offs)
        return offs

    def _compare_means(self, means: Floats) -> Floats:
        """Compare the hours with those of the days before, for each mean of the newest slot."""
        slots = np.arange(self.slot - _WINDOW + 1, self.slot + 1)
        now = self.means[slots % _KEPT]
        thens = self.means[(slots - _BACK) % _KEPT]
        boths = ~(np.isnan(now) | np.isnan(thens))
        self.off = -1.0
        days: list[tuple[float, int]] = []
        means_now = np.empty((_DAYS, len(means)))
        for then, both, there in zip(thens, boths, boths.sum(axis=1).tolist(), strict=True):
            if there < _LEAST:
                continue
            hours, row = now[both], means_now[len(days)]
            if both[-1]:
                _sums_ending(hours, means, row)
            else:
                row[:] = hours.sum()
            days.append((float(then[both].sum()) / there, there))
        if not days:
            return np.full(len(means), np.inf)
        means_now = means_now[: len(days)]
        means_now /= np.array([[float(there)] for _, there in days])
        apart = np.abs(means_now - np.array([[mean] for mean, _ in days]))
        nearest = int(apart[:, -1].argmin())
        self.now, self.then = float(means_now[nearest, -1]), days[nearest][0]
        self.off = float(apart[nearest, -1])
        offs: Floats = apart.min(axis=0)
        return offs

    def _move_slot(self, slot: int) -> None:
        """Go on to a slot; those in between had no samples. Times that go back stay where it is."""
        if self.slot < 0:
            self.slot = slot
        # New slots take the places of the oldest; after a long pause each place is emptied once.
        for index in range(max(self.slot + 1, slot - _KEPT + 1), slot + 1):
            self.means[index % _KEPT], self.counts[index % _KEPT] = np.nan, 0.0
        self.slot = max(self.slot, slot)

    def _compare_days(self) -> None:
        slots = np.arange(self.slot - _WINDOW + 1, self.slot + 1)
        now = self.means[slots % _KEPT]
        self.off = -1.0
        for day in range(1, _DAYS + 1):
            then = self.means[(slots - day * _DAY) % _KEPT]
            both = ~np.isnan(now) & ~np.isnan(then)
            if int(both.sum()) < _LEAST:
                continue
            mean_now, mean_then = float(now[both].mean()), float(then[both].mean())
            if self.off < 0.0 or abs(mean_now - mean_then) < self.off:
                self.now, self.then, self.off = mean_now, mean_then, abs(mean_now - mean_then)

    def why(self) -> str:
        """Compare with the day that comes nearest."""
        if self.off < 0.0:
            return "no earlier day to compare with yet"
        return (
            f"the mean of the last {_HOURS} h, {format_number(self.now)} {self.unit}".rstrip()
            + f", is {format_number(self.off)} {self.unit}".rstrip()
            + f" away from the same hours of the nearest of the last {_DAYS} days"
            + f" ({format_number(self.then)} {self.unit}".rstrip()
            + ")"
        )

    def forgive(self) -> bool:
        """Count such a distance as usual."""
        self.rarity.learn_magnitude(self.peak)
        return True


def _sums_ending(values: Floats, last: Floats, sums: Floats) -> None:
    """Give the sums of up to 128 values, for each that may stand in place of the last one (n,).

    They are added up in the order in which NumPy adds them, so the sums are the very same.
    """
    if len(values) % _LANES:
        np.add(last, float(values[:-1].sum()), out=sums)
        return
    # Every eighth value in a lane, and the last one at the end of the last lane.
    values[-1] = 0.0
    lanes = values.reshape(-1, _LANES).sum(axis=0).tolist()
    one, two, three, four, five, six, seven, eight = lanes
    np.add(last, eight, out=sums)
    sums += seven
    sums += five + six
    sums += (one + two) + (three + four)
