"""Detectors whose rule is read at a glance: still, silent, too fast, out of limits."""

from __future__ import annotations

import math

import msgspec

from talaia.hub.anomaly.base import AnomalyDetector, clamp_value, format_duration, format_number
from talaia.hub.anomaly.baseline import Sorted

__all__ = ["LimitsDetector", "Missing", "RateOfChange", "Still"]

# So many pauses or changes must have been seen before it has an opinion.
_LEAST = 30
# So many times the longest usual pause, or the fastest usual change, score one half.
_TIMES = 3.0


class Still(AnomalyDetector, kw_only=True):
    """A flat line: the value has not moved for far longer than it ever does.

    Attributes:
        within: a change up to this is none, in the unit of the values.
        after_s: with a number above 0, so long a standstill scores one half (s); otherwise
            three times the longest of before does.

    """

    within: float = 0.0
    after_s: float = 0.0
    # The value that stands; NaN before the first.
    held: float = math.nan
    # Since when it stands (µs).
    since_us: int = 0
    # When the newest sample came (µs).
    now_us: int = 0
    # The longest standstill of before (s); forgets slowly.
    longest_s: float = 0.0
    # How often it has moved.
    changes: int = 0
    score: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score how long the value has stood still."""
        # Written so that NaN, before the first sample, counts as a change.
        if not abs(value - self.held) <= self.within:
            if not math.isnan(self.held):
                self.changes += 1
                self.longest_s = max(self.longest_s * 0.999, (time_us - self.since_us) / 1e6)
            self.held, self.since_us = value, time_us
        self.now_us = time_us
        return self._rate_standstill()

    def _rate_standstill(self) -> float:
        still = (self.now_us - self.since_us) / 1e6
        usual = self.after_s or (_TIMES * self.longest_s if self.changes >= _LEAST else 0.0)
        return still / (still + usual) if usual > 0.0 and still > 0.0 else 0.0

    def why(self) -> str:
        """Say for how long."""
        still = (self.now_us - self.since_us) / 1e6
        usual = (
            f"{format_duration(self.after_s)} are allowed"
            if self.after_s
            else f"the longest usual standstill is {format_duration(self.longest_s)}"
        )
        return (
            f"{format_number(self.held)} {self.unit}".rstrip()
            + f" for {format_duration(still)}; {usual}"
        )

    def forgive(self) -> bool:
        """Take such a standstill as usual."""
        still = (self.now_us - self.since_us) / 1e6
        if self.after_s:
            self.after_s = max(self.after_s, 1.1 * still)
        self.longest_s = max(self.longest_s, still)
        return True


class Missing(AnomalyDetector, kw_only=True):
    """Data that do not come: a pause far longer than the usual interval.

    Attributes:
        after_s: with a number above 0, so long a pause scores one half (s); otherwise three
            times the longest usual one does.

    """

    after_s: float = 0.0
    # When the last sample came (µs); -1: none yet.
    last_us: int = -1
    # The last pauses (s).
    pauses: Sorted = msgspec.field(default_factory=lambda: Sorted(most=200))
    # The pause that goes on, or the last one (s).
    pause_s: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score the pause before this sample."""
        if self.last_us < 0:
            self.last_us = time_us
            return 0.0
        score = self.idle(time_us)
        self.pauses.add_value(max(time_us - self.last_us, 0) / 1e6)
        self.last_us = max(time_us, self.last_us)
        return score

    def idle(self, time_us: int) -> float:
        """Score the pause up to now."""
        if self.last_us < 0:
            return 0.0
        self.pause_s = max(time_us - self.last_us, 0) / 1e6
        usual = self._usual_pause()
        return self.pause_s / (self.pause_s + usual) if usual > 0.0 else 0.0

    def _usual_pause(self) -> float:
        if self.after_s:
            return self.after_s
        return _TIMES * self.pauses.quantile(0.98) if len(self.pauses.came) >= _LEAST else 0.0

    def why(self) -> str:
        """Say for how long."""
        usual = (
            f"{format_duration(self.after_s)} are allowed"
            if self.after_s or len(self.pauses.came) < _LEAST
            else f"usually one comes every {format_duration(self.pauses.quantile(0.5))}"
        )
        return f"no sample for {format_duration(self.pause_s)}; {usual}"

    def forgive(self) -> bool:
        """Take such a pause as usual."""
        if self.after_s:
            self.after_s = max(self.after_s, 1.1 * self.pause_s)
        # Enough of them to move the quantile of 0.98 that is taken as usual.
        for _ in range(len(self.pauses.came) // 20 + 1):
            self.pauses.add_value(self.pause_s)
        return True


class RateOfChange(AnomalyDetector, kw_only=True):
    """A value that moves faster than it should.

    Attributes:
        most: with a number above 0, so fast a change scores one half (unit/s); otherwise three
            times the fastest usual one does.

    """

    most: float = 0.0
    # The newest sample's time (µs) and value; -1: none yet.
    last_us: int = -1
    last: float = 0.0
    # The last speeds (unit/s).
    rates: Sorted = msgspec.field(default_factory=lambda: Sorted(most=1000))
    # The newest, for `why`.
    rate: float = 0.0
    # The greatest of late: what a person may call usual.
    peak: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score the change since the sample before."""
        score = 0.0
        if 0 <= self.last_us < time_us:
            self.rate = abs(clamp_value(value) - self.last) / ((time_us - self.last_us) / 1e6)
            usual = self._usual_change()
            score = self.rate / (self.rate + usual) if usual > 0.0 else 0.0
            self.rates.add_value(self.rate)
            self.peak = max(self.rate, self.peak * 0.98)
        if time_us > self.last_us:
            self.last_us, self.last = time_us, clamp_value(value)
        return score

    def _usual_change(self) -> float:
        if self.most:
            return self.most
        return _TIMES * self.rates.quantile(0.98) if len(self.rates.came) >= _LEAST else 0.0

    def why(self) -> str:
        """Say how fast."""
        usual = f"up to {format_number(self._usual_change())} {self.unit}/s are allowed"
        return f"it changes by {format_number(self.rate)} {self.unit}/s; {usual}"

    def forgive(self) -> bool:
        """Take such a change as usual."""
        if self.most:
            self.most = max(self.most, 1.1 * self.peak)
        for _ in range(len(self.rates.came) // 20 + 1):
            self.rates.add_value(self.peak)
        self.peak = 0.0
        return True


class LimitsDetector(AnomalyDetector, kw_only=True):
    """A value out of the limits a person set. It learns nothing: limits are changed by hand.

    Attributes:
        minimum, maximum: in the unit of the values.

    """

    minimum: float | None = None
    maximum: float | None = None
    value: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score 1 outside, 0 inside."""
        self.value = value
        return 1.0 if self._exceeded_limit() else 0.0

    def _exceeded_limit(self) -> str:
        if self.minimum is not None and self.value < self.minimum:
            return f"below the least of {format_number(self.minimum)}"
        if self.maximum is not None and self.value > self.maximum:
            return f"above the most of {format_number(self.maximum)}"
        return ""

    def why(self) -> str:
        """Name the limit."""
        beyond = self._exceeded_limit() or "within its limits"
        unit = f" {self.unit}" if self.unit else ""
        return f"{format_number(self.value)}{unit} is {beyond}" + (
            unit if self._exceeded_limit() else ""
        )
