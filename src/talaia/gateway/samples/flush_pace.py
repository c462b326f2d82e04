"""When what adapters hand over becomes a batch: all of it now and then, what is watched soon. Pure.

A hand-over that comes when a batch is ripe makes it, and waits for no timer; what no hand-over
follows goes out when it is late. Two beats side by side, the adapter's and a timer's, would let
samples wait for both.
"""

from __future__ import annotations

__all__ = ["SOON_S", "FlushPace"]

# Between two batches of what somebody looks at (s): the turns of an adapter that is in a hurry.
SOON_S = 0.005
# Of the time in which somebody wants one sample, so much may be between two batches: it is seen
# no more then.
_SEEN_SHARE = 0.2
# What is watched waits no longer than this (s), whatever a batch costs.
_SOON_MOST_S = 0.020
# Batches that are made soon take at most this share of the event loop: where one costs much, as
# on a small machine or of very many samples, the next one comes later.
_MOST_SHARE = 0.05
# Of a batch's cost in the average: one that was slow by chance changes little.
_NEWEST_SHARE = 0.125
# Of the time between two: a hand-over this early still makes the batch, one this late is not
# awaited.
_EARLY, _LATE = 0.75, 1.25


class FlushPace:
    """The next batch of all that waits, and the next one of what is watched alone.

    All times are of one monotonic clock (s).

    Attributes:
        wanted_s: what is watched is wanted so often (s); 0: as soon as can be.
        ripe_s: from when on a hand-over makes a batch of all that waits.
        late_s: when it is made without one.
        soon_ripe_s: from when on a hand-over of what is watched makes a batch of that.
        soon_late_s: when that is made without one.

    """

    def __init__(self, usual_s: float) -> None:
        """Make a batch of all about every ``usual_s`` (s); the first one at once."""
        self._usual_s = usual_s
        # What a batch costs the event loop, on the average (s).
        self._cost_s = 0.0
        self.wanted_s = 0.0
        self.ripe_s = self.late_s = self.soon_ripe_s = self.soon_late_s = 0.0

    @property
    def soon_s(self) -> float:
        """About so much time is between two batches of what is watched (s)."""
        least_s = max(SOON_S, _SEEN_SHARE * self.wanted_s, self._cost_s / _MOST_SHARE)
        return min(self._usual_s, _SOON_MOST_S, least_s)

    def begin_batch(self, now_s: float, *, whole: bool) -> None:
        """Count from now on: a batch is made, of all that waits or of what is watched alone."""
        if whole:
            self.ripe_s = now_s + _EARLY * self._usual_s
            self.late_s = now_s + _LATE * self._usual_s
        soon_s = self.soon_s
        self.soon_ripe_s = now_s + _EARLY * soon_s
        self.soon_late_s = now_s + _LATE * soon_s

    def add_cost(self, cost_s: float) -> None:
        """Learn what a batch has cost the event loop (s of its processor time)."""
        self._cost_s += _NEWEST_SHARE * (cost_s - self._cost_s)
