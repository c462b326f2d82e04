"""From scores to anomalies: when one begins and ends. One anomaly is told once."""

from __future__ import annotations

import math
from enum import StrEnum

import msgspec

__all__ = ["EpisodeTurn", "Episodes"]

# While it learns, the bar is so much higher.
_STRICTER = 0.08


class EpisodeTurn(StrEnum):
    """What a score changed."""

    BEGAN = "began"
    ENDED = "ended"


class Episodes(msgspec.Struct, kw_only=True):
    """Tells when an anomaly begins and ends.

    Attributes:
        bar: a score from here on is an anomaly.
        rest: after one began, no other begins for so many samples.
        calm: it is over once so many samples in a row scored below the bar.
        quiet: for so many more samples none begins: what is usual is not known yet.
        learning: for so many more samples one begins only above a higher bar.
        began_us: when the anomaly that is on began; -1 while there is none.
        top: the greatest score of the one that is on.

    """

    bar: float
    rest: int = 100
    calm: int = 10
    quiet: int = 0
    learning: int = 0
    began_us: int = -1
    top: float = 0.0
    # Its last sample at or above the bar (µs): where it ends, once it is over.
    last_us: int = -1
    # Samples since one last began; large at the start, so that `rest` holds none back.
    since: int = 1_000_000
    # How many in a row scored below the bar.
    below: int = 0

    def update_score(
        self, time_us: int, score: float, *, may_begin: bool = True
    ) -> EpisodeTurn | None:
        """Take the next score; say whether an anomaly begins or ends with it.

        Args:
            time_us: of its sample (µs).
            score: 0 to 1.
            may_begin: whether one may begin with it; one that is on goes on by its score.

        """
        turn = self._find_turn(time_us, score, may_begin=may_begin)
        self.quiet, self.learning = max(0, self.quiet - 1), max(0, self.learning - 1)
        return turn

    def pass_calm(self, many: int) -> None:
        """Take so many scores in at once, all below the bar while no anomaly is on."""
        self.since += many
        self.quiet, self.learning = max(0, self.quiet - many), max(0, self.learning - many)

    def _find_turn(self, time_us: int, score: float, *, may_begin: bool) -> EpisodeTurn | None:
        self.since += 1
        high = score >= self.bar
        if self.began_us >= 0:
            if high:
                self.last_us, self.top, self.below = time_us, max(self.top, score), 0
                return None
            self.below += 1
            if self.below >= self.calm:
                return EpisodeTurn.ENDED
            return None
        if high and may_begin and self.since >= self.rest and score >= self._start_score():
            self.began_us = self.last_us = time_us
            self.top, self.below, self.since = score, 0, 0
            return EpisodeTurn.BEGAN
        return None

    def _start_score(self) -> float:
        """Give the score from which one begins now."""
        if self.quiet > 0:
            return math.inf
        return self.bar + _STRICTER if self.learning > 0 else self.bar

    def would_begin(self, score: float) -> bool:
        """Tell whether an anomaly would begin with the next score."""
        free = self.began_us < 0 and self.since + 1 >= self.rest
        return free and score >= self.bar and score >= self._start_score()

    def end_episode(self) -> tuple[int, int, float]:
        """End the anomaly that is on: when it began, its last high sample, its greatest score."""
        # It ended when it was last high, not when that was noticed.
        told = (self.began_us, self.last_us, self.top)
        self.began_us, self.top, self.below = -1, 0.0, 0
        return told
