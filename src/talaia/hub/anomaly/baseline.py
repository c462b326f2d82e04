"""A robust baseline: median and spread of the newest samples, with drift and season."""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Sequence  # noqa: TC003 - msgspec reads the annotations

import msgspec
import numpy as np

from talaia.hub.anomaly.base import (
    SPREAD_OF_MEDIAN,
    AnomalyDetector,
    Floats,
    clamp_value,
    format_duration,
    format_number,
)

__all__ = ["Baseline", "Quartiles", "Sorted"]

# Newest samples from which the usual value comes.
_WINDOW = 500
# With fewer it has no opinion.
_LEAST = 30
# So many spreads from the baseline score one half.
_USUAL = 6.0
# A day in quarters of an hour.
_SLOTS = 96
_SLOT_US = 900_000_000
# However often a person says that it was none, the spread is taken no wider.
_MOST_TOLERANCE = 100.0


class Sorted(msgspec.Struct, kw_only=True):
    """The newest values, in the order they came and sorted."""

    # At most so many values.
    most: int
    # In the order they came; a ring once it is full.
    came: list[float] = msgspec.field(default_factory=list)
    # The same, sorted, so that quantiles cost no sorting.
    sorted: list[float] = msgspec.field(default_factory=list)
    # The place of the oldest in `came`, once that is full.
    at: int = 0

    def add_value(self, value: float) -> None:
        """Take a value in; the oldest leaves when there are too many."""
        if len(self.came) < self.most:
            self.came.append(value)
        else:
            # Floats that are equal are alike, so it does not matter which one goes.
            del self.sorted[bisect_left(self.sorted, self.came[self.at])]
            self.came[self.at] = value
            self.at = (self.at + 1) % self.most
        insort(self.sorted, value)

    def quantile(self, part: float) -> float:
        """Give the value that ``part`` (0 to 1) of all lie below, between neighbours by share."""
        return _quantile(self.sorted, part)

    def newest_values(self, count: int) -> list[float]:
        """Give the newest values, oldest first."""
        if len(self.came) < self.most:
            return self.came[-count:]
        turned = self.came[self.at :] + self.came[: self.at]
        return turned[-count:]


def _quantile(values: Sequence[float], part: float) -> float:
    place = (len(values) - 1) * part
    low = math.floor(place)
    high = min(low + 1, len(values) - 1)
    return values[low] + (values[high] - values[low]) * (place - low)


class Baseline(AnomalyDetector, kw_only=True):
    """Scores the distance from the usual value in units of the usual spread.

    The usual value is the median of the newest samples, carried on by their drift, with what the
    time of day adds to it once a day has been seen.

    Attributes:
        tolerance: by how much the spread is taken wider, after a person said "not an anomaly".

    """

    tolerance: float = 1.0
    # Levels: values without what the time of day adds.
    recent: Sorted = msgspec.field(default_factory=lambda: Sorted(most=_WINDOW))
    # How far values were from the usual.
    offsets: Sorted = msgspec.field(default_factory=lambda: Sorted(most=_WINDOW))
    # The first time (µs); a second place is not used.
    times: Floats = msgspec.field(default_factory=lambda: np.zeros(2))
    # What each slot of the day adds; NaN where it was never seen.
    season: Floats = msgspec.field(default_factory=lambda: np.full(_SLOTS, np.nan))
    # Every slot has been seen, so the time of day is taken off.
    seasonal: bool = False
    # How far the newest samples have drifted from that median.
    drift: float = 0.0
    # Samples since the start.
    counted: int = 0
    # Of the newest sample, for `why`: its value, the usual one, and the spread.
    value: float = 0.0
    usual: float = 0.0
    spread: float = 0.0
    # The greatest number of spreads of late: what a person may call usual.
    peak: float = 0.0
    # So long the window reaches back (s), for `why`.
    length_s: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score one sample against those before it, then take it in."""
        value = clamp_value(value)
        slot = (time_us // _SLOT_US) % _SLOTS
        season = self._seasonal_offset(slot)
        level = value - season
        score = 0.0
        if len(self.recent.came) >= _LEAST:
            self.value = value
            self.usual = self.recent.quantile(0.5) + self.drift + season
            # A signal that hardly moves would have next to no spread.
            smallest = 0.01 * abs(self.usual) + 1e-12
            spread = SPREAD_OF_MEDIAN * self.offsets.quantile(0.5)
            self.spread = max(spread, smallest) * self.tolerance
            spreads = abs(value - self.usual) / self.spread
            # Fades, so that a word of a person means what was just shown.
            self.peak = max(spreads, self.peak * 0.98)
            score = spreads / (spreads + _USUAL)
            self.offsets.add_value(abs(value - self.usual))
        else:
            self.offsets.add_value(
                abs(level - self.recent.quantile(0.5)) if self.recent.came else 0.0
            )
        self._learn_sample(time_us, value, level, slot)
        return score

    def _seasonal_offset(self, slot: int) -> float:
        # Nothing is taken off before every slot of a day is known.
        return float(self.season[slot]) if self.seasonal else 0.0

    def _learn_sample(self, time_us: int, value: float, level: float, slot: int) -> None:
        if self.counted == 0:
            self.times[0] = time_us
        interval = max((time_us - float(self.times[0])) / 1e6 / max(self.counted, 1), 0.0)
        self.length_s = interval * min(self.counted, _WINDOW)
        if self.recent.came:
            known = self.season[slot]
            off = value - self.recent.quantile(0.5) - self.drift
            # Follows slowly: each sample moves its slot by a tenth of the difference.
            self.season[slot] = off if np.isnan(known) else known + (off - known) * 0.1
            if not self.seasonal and not np.isnan(self.season).any():
                # From here on the level is without season: what was learned with it does not fit.
                self.seasonal = True
                self.recent, self.offsets = Sorted(most=_WINDOW), Sorted(most=_WINDOW)
                self.drift = 0.0
        self.recent.add_value(level)
        self.counted += 1
        # Not with each sample: three parts are sorted for it.
        if self.counted % 25 == 0 and len(self.recent.came) >= _WINDOW:
            self.drift = self._estimate_drift()

    def _estimate_drift(self) -> float:
        """Give how far the value has gone since the median, if it goes on steadily."""
        newest, third = self.recent.newest_values(_WINDOW), _WINDOW // 3
        parts = (newest[:third], newest[third : 2 * third], newest[2 * third :])
        first, second, last = (_quantile(sorted(part), 0.5) for part in parts)
        # After a step one of the two is nothing, and so the step is no drift.
        if (second - first) * (last - second) <= 0.0:
            return 0.0
        return 1.5 * min(second - first, last - second, key=abs)

    def why(self) -> str:
        """Say how many spreads from the usual value."""
        if self.spread == 0.0:
            return "too few samples yet"
        off = self.value - self.usual
        way = "above" if off >= 0 else "below"
        return (
            f"{format_number(self.value)} {self.unit}".rstrip()
            + f" is {format_number(abs(off) / self.spread)} times the usual spread {way} the usual "
            + f"{format_number(self.usual)} {self.unit}".rstrip()
            + f" of the last {format_duration(self.length_s)}"
        )

    def forgive(self) -> bool:
        """Take the spread so much wider that the latest peak scores below one half."""
        wider = self.tolerance * max(1.0, 1.5 * self.peak / _USUAL)
        self.tolerance = min(wider, _MOST_TOLERANCE)
        self.peak = 0.0
        return True


class Quartiles(AnomalyDetector, kw_only=True):
    """The founding design's outliers: beyond ``k`` times the distance between the quartiles.

    Attributes:
        k: a sample just that far out scores one half. Charts take Tukey's 1.5.
        window: so many of the newest samples.

    """

    # With 1.5 silence would do better on NAB (decision 0186).
    k: float = 6.0
    recent: Sorted = msgspec.field(default_factory=lambda: Sorted(most=100))
    value: float = 0.0
    low: float = 0.0
    high: float = 0.0
    peak: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score one sample against the quartiles of those before it."""
        value = clamp_value(value)
        score = 0.0
        if len(self.recent.came) >= _LEAST:
            self.value = value
            self.low, self.high = self.recent.quantile(0.25), self.recent.quantile(0.75)
            out = max(self.low - value, value - self.high, 0.0)
            between = self.high - self.low
            times = out / between if between > 0.0 else (1e6 if out > 0.0 else 0.0)
            self.peak = max(times, self.peak * 0.98)
            score = times / (times + self.k)
        self.recent.add_value(value)
        return score

    def why(self) -> str:
        """Name the quartiles."""
        between = self.high - self.low
        way = "above the upper" if self.value > self.high else "below the lower"
        edge = self.high if self.value > self.high else self.low
        if self.low <= self.value <= self.high:
            return f"{format_number(self.value)} {self.unit}".rstrip() + " is between the quartiles"
        times = (
            f"{format_number(abs(self.value - edge) / between)} times" if between > 0.0 else "far"
        )
        return (
            f"{format_number(self.value)} {self.unit}".rstrip()
            + f" is {times} the distance of the quartiles {way} one, "
            + f"{format_number(edge)} {self.unit}".rstrip()
            + f", of the last {len(self.recent.came)} samples"
        )

    def forgive(self) -> bool:
        """Take ``k`` so much greater that the latest peak is well inside."""
        if self.peak < 1e6:
            self.k = max(self.k, 1.5 * self.peak)
        self.peak = 0.0
        return True
