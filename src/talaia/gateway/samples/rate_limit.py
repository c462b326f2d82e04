"""Decide which samples are worth keeping: rate limit and deadband."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.model.site import Signal

__all__ = ["Sampler", "SamplingRule", "rule_of"]

Values = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SamplingRule:
    """How often a signal may speak, and how far it must move to be heard.

    Attributes:
        min_interval_us: shortest time between two kept samples; 0 sets no limit.
        deadband: a change up to this is not news, in the signal's own unit.
        max_silence_us: after this long even an unchanged value is kept, so that
            "no news" and "no robot" can be told apart.

    """

    min_interval_us: int = 0
    deadband: float = 0.0
    max_silence_us: int = 2_500_000


def rule_of(signal: Signal) -> SamplingRule | None:
    """Give the rule of a signal, or none when every sample is kept."""
    if signal.max_rate <= 0 and signal.deadband <= 0:
        return None
    interval = round(1e6 / signal.max_rate) if signal.max_rate > 0 else 0
    # Half of what counts as stale: an unchanged value is repeated before it looks old.
    return SamplingRule(interval, signal.deadband, round(signal.stale_after * 0.5e6))


class Sampler:
    """Apply one rule to one signal. Knows no clock: samples carry their own time.

    The last value of a burst is not lost to the rate limit: it is held, and `due_values` gives it
    out when its turn has come.
    """

    __slots__ = ("_at_us", "_held", "_values", "rule")

    def __init__(self, rule: SamplingRule) -> None:
        """Start with nothing kept, so that the first sample always passes."""
        self.rule = rule
        self._values: Values | None = None  # The last that was kept; None before the first.
        self._at_us = 0  # Its time (µs, the samples' own).
        # Came too early; given out by `due_values`, or forgotten when the value comes back.
        self._held: Values | None = None

    @property
    def holding(self) -> bool:
        """Tell whether a value waits for its turn."""
        return self._held is not None

    @property
    def turn_us(self) -> int:
        """When the turn of a waiting value comes."""
        return self._at_us + self.rule.min_interval_us

    def accept_sample(self, time_us: int, values: Values) -> bool:
        """Tell whether to keep the sample; if so, remember it as kept."""
        silence = time_us - self._at_us
        # A wall clock that was set back must not silence a signal until it has caught up.
        if self._values is None or silence < 0 or silence >= self.rule.max_silence_us:
            return self._keep_values(time_us, values)
        if self._is_still(values):
            # It moved and came back within the interval: what was held is no news any more.
            self._held = None
            return False
        if silence < self.rule.min_interval_us:
            self._held = values
            return False
        return self._keep_values(time_us, values)

    def due_values(self, time_us: int) -> Values | None:
        """Give the held values, as kept, once the interval since the last kept one is over."""
        held = self._held
        # `0 <=`: after a clock that was set back the held value is due at once.
        if held is None or 0 <= time_us - self._at_us < self.rule.min_interval_us:
            return None
        self._keep_values(time_us, held)
        return held

    def forget_values(self) -> None:
        """Begin anew: what was kept or held counts no longer."""
        self._values = self._held = None

    def _keep_values(self, time_us: int, values: Values) -> bool:
        self._values, self._at_us, self._held = values, time_us, None
        return True

    def _is_still(self, values: Values) -> bool:
        last = self._values
        deadband = self.rule.deadband
        if last is None or deadband <= 0:
            return False
        for new, old in zip(values, last, strict=True):
            both_nan = new != new and old != old
            # A value that becomes NaN is news, and NaN compares false with everything.
            if not both_nan and not abs(new - old) <= deadband:
                return False
        return True
