"""A detector of slow drifts: the cumulative sum of deviations from the mean (CUSUM, Page 1954).

A value that is a little too high a hundred times in a row is news although no single one is.
"""

from __future__ import annotations

import math

from talaia.extend.detector import AnomalyDetector, DetectorExtension, ExtensionKeys


class CusumKeys(ExtensionKeys, frozen=True, kw_only=True):
    """What a description may say.

    Attributes:
        slack: a deviation up to this is none, in standard deviations.
        limit: a sum of deviations of this many standard deviations scores one half.
        warm_up: the mean and the deviation are learned of so many samples.

    """

    slack: float = 0.5
    limit: float = 8.0
    warm_up: int = 100

    def __post_init__(self) -> None:
        """Refuse what makes no sense."""
        if self.slack < 0 or self.limit <= 0 or self.warm_up < 2:
            raise ValueError("expected slack from 0, limit above 0 and warm_up from 2")


class Cusum(AnomalyDetector, kw_only=True):
    """Sums what is above the mean, and what is below it, each for itself.

    The fields are all that is kept when the hub is started anew.
    """

    slack: float = 0.5
    limit: float = 8.0
    warm_up: int = 100
    seen: int = 0
    mean: float = 0.0
    squares: float = 0.0
    above: float = 0.0
    below: float = 0.0

    def see(self, time_us: int, value: float) -> float:
        """Score the larger of both sums; one half is reached at ``limit``."""
        if self.seen < self.warm_up:
            self.seen += 1
            step = value - self.mean
            self.mean += step / self.seen
            self.squares += step * (value - self.mean)
            return 0.0
        deviation = (value - self.mean) / (math.sqrt(self.squares / self.seen) or 1e-9)
        # Beyond twice the limit nothing is added, so that it is over soon after its cause is.
        most = 2.0 * self.limit
        self.above = min(most, max(0.0, self.above + deviation - self.slack))
        self.below = min(most, max(0.0, self.below - deviation - self.slack))
        total = max(self.above, self.below)
        return total / (total + self.limit)

    def why(self) -> str:
        """Say which way it has drifted."""
        way = "above" if self.above >= self.below else "below"
        unit = f" {self.unit}" if self.unit else ""
        return f"it has stayed {way} its mean of {self.mean:.4g}{unit} for long"

    def forgive(self) -> bool:
        """Learn the mean anew."""
        self.seen, self.mean, self.squares, self.above, self.below = 0, 0.0, 0.0, 0.0, 0.0
        return True


extension = DetectorExtension(
    api=1, summary="slow drift (CUSUM)", make=Cusum, keys=CusumKeys, bar=0.5
)
