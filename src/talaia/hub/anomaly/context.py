"""A contextual detector of our own: what follows what.

In the manner of the contextual anomaly detectors (CAD OSE), from their description: the value is
cut into few levels; a *context* is what came in the newest samples, at several depths; the
detector remembers which level followed each context, and is surprised by one that never did. The
surprise is judged by how rare it is for this signal. Nothing of another's program is in it.
"""

from __future__ import annotations

import math

import msgspec

from talaia.hub.anomaly.base import AnomalyDetector, clamp_value, format_number
from talaia.hub.anomaly.baseline import Sorted
from talaia.hub.anomaly.rarity import Rarity

__all__ = ["Context"]

_LEVELS = 8
_DEPTHS = 6
_LEAST = 60
_MOST_CONTEXTS = 4000
# Surprise is carried over a few samples: an odd one that comes alone counts for less.
_CARRY = 0.8
_AGAIN = 200


class Context(AnomalyDetector, kw_only=True):
    """Scores how surprising the newest level is after those before it."""

    rarity: Rarity = msgspec.field(default_factory=Rarity)
    recent: Sorted = msgspec.field(default_factory=lambda: Sorted(most=1000))
    edges: list[float] = msgspec.field(default_factory=list)
    before: list[int] = msgspec.field(default_factory=list)
    # Context (its levels as a text) to how often each level followed it.
    followed: dict[str, list[int]] = msgspec.field(default_factory=dict)
    counted: int = 0
    carried: float = 0.0
    peak: float = 0.0
    value: float = 0.0
    known: int = 0
    times: int = 0

    def see(self, time_us: int, value: float) -> float:
        """Score one sample, then remember what it followed."""
        self.value = value = clamp_value(value)
        self._recut_levels(value)
        if not self.edges:
            return 0.0
        level = sum(value > edge for edge in self.edges)
        surprise = self._rate_surprise(level)
        self._count_level(level)
        self.carried = max(surprise, self.carried * _CARRY + surprise * (1.0 - _CARRY))
        self.peak = max(self.carried, self.peak * 0.98)
        return self.rarity.rate_magnitude(self.carried)

    def _recut_levels(self, value: float) -> None:
        self.recent.add_value(value)
        self.counted += 1
        if self.counted < _LEAST or (self.counted % _AGAIN and self.edges):
            return
        low, high = self.recent.quantile(0.01), self.recent.quantile(0.99)
        reach = max(high - low, 1e-9)
        inner, outside = _LEVELS - 4, (-1.0, -0.1, 1.1, 2.0)
        parts = [step / inner for step in range(1, inner)]
        cuts = sorted([*outside, *parts])
        edges = [low + reach * cut for cut in cuts]
        # Contexts of other levels mean other things; small changes leave the cut as it is.
        moved = max((abs(a - b) for a, b in zip(edges, self.edges, strict=False)), default=reach)
        if moved > 0.5 * reach:
            self.edges = edges
            self.followed = {}

    def _recent_contexts(self) -> list[str]:
        newest = self.before[-_DEPTHS:]
        return ["".join(map(str, newest[-depth:])) for depth in range(1, len(newest) + 1)]

    def _rate_surprise(self, level: int) -> float:
        total, weight, self.known, self.times = 0.0, 0.0, 0, 0
        for depth, context in enumerate(self._recent_contexts(), 1):
            after = self.followed.get(context)
            if after is None:
                # A context never met is a surprise too, the more the shorter it is.
                total += 1.0 / depth
                weight += 1.0 / depth
                continue
            seen = sum(after)
            self.known, self.times = max(self.known, seen), max(self.times, after[level])
            bits = math.log2((seen + _LEVELS) / (after[level] + 1.0))
            total += bits
            weight += 1.0
        return total / weight if weight else 0.0

    def _count_level(self, level: int, times: int = 1) -> None:
        for context in self._recent_contexts():
            after = self.followed.setdefault(context, [0] * (_LEVELS + 1))
            after[level] += times
        self.before = [*self.before[-_DEPTHS:], level]
        if len(self.followed) > _MOST_CONTEXTS:
            # The rarest go; what is usual comes again soon.
            kept = sorted(self.followed.items(), key=lambda followed: -sum(followed[1]))
            self.followed = dict(kept[: _MOST_CONTEXTS // 2])

    def why(self) -> str:
        """Tell how often such a value has followed before."""
        if not self.edges:
            return "too few samples yet"
        value = f"{format_number(self.value)} {self.unit}".rstrip()
        if self.known == 0:
            return f"{value} follows a sequence of values that has not been met before"
        return f"such a value as {value} followed {self.times} of {self.known} times before"

    def forgive(self) -> bool:
        """Take such a surprise as usual."""
        self.rarity.learn_magnitude(self.peak)
        return True
