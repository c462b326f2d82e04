"""From scores to anomalies: when one begins and ends. One anomaly is told once."""

from __future__ import annotations

from enum import StrEnum

import msgspec

__all__ = ["Episodes", "Turn"]


class Turn(StrEnum):
    """What a score changed."""

    BEGAN = "began"
    ENDED = "ended"


class Episodes(msgspec.Struct, kw_only=True):
    """Tells when an anomaly begins and ends.

    Attributes:
        bar: a score from here on is an anomaly.
        rest: after one began, no other begins for so many samples.
        calm: it is over once so many samples in a row scored below the bar.
        began_us: when the anomaly that is on began; -1 while there is none.
        top: the greatest score of the one that is on.

    """

    bar: float
    rest: int = 100
    calm: int = 10
    began_us: int = -1
    top: float = 0.0
    last_us: int = -1
    since: int = 1_000_000
    below: int = 0

    def take(self, time_us: int, score: float) -> Turn | None:
        """Take the next score; say whether an anomaly begins or ends with it."""
        self.since += 1
        high = score >= self.bar
        if self.began_us >= 0:
            if high:
                self.last_us, self.top, self.below = time_us, max(self.top, score), 0
                return None
            self.below += 1
            if self.below >= self.calm:
                return Turn.ENDED
            return None
        if high and self.since >= self.rest:
            self.began_us = self.last_us = time_us
            self.top, self.below, self.since = score, 0, 0
            return Turn.BEGAN
        return None

    def close(self) -> tuple[int, int, float]:
        """End the anomaly that is on: when it began, its last high sample, its greatest score."""
        told = (self.began_us, self.last_us, self.top)
        self.began_us, self.top, self.below = -1, 0.0, 0
        return told
