"""The gateway's own time marks, by which the age of a driver's frame is told. Pure."""

from __future__ import annotations

from talaia.clock import MS, SECOND

__all__ = ["TICK_NS", "TickClock"]

# A driver sends at 20 to 25 Hz; with a mark each 50 ms its newest echo adds at most that to the
# age.
TICK_NS = 50 * MS


class TickClock:
    """No wall clock decides how old a frame is: it echoes the newest mark that its driver has seen.

    Attributes:
        last: the number of the newest mark.
        last_ns: when that was sent (monotonic).

    """

    # 3.2 s of marks, far beyond the longest life of a frame.
    KEPT = 64

    def __init__(self) -> None:
        """Start before the first."""
        # When each mark was sent (monotonic), the newest `KEPT` of them.
        self._sent: dict[int, int] = {}
        self.last = -1  # -1: none yet, so that no echo of one is believed.
        self.last_ns = -TICK_NS  # So that the first mark is due at once.

    def next_tick(self, now_ns: int) -> int:
        """Make the next mark."""
        self.last += 1
        self.last_ns = now_ns
        self._sent[self.last] = now_ns
        self._sent.pop(self.last - self.KEPT, None)
        return self.last

    def age_ns(self, tick: int, now_ns: int) -> int:
        """Tell how long ago a mark was sent; negative if it never was."""
        # A number from before a restart, or an invented one.
        if not 0 <= tick <= self.last:
            return -1
        sent = self._sent.get(tick)
        # Older than all that is kept: far beyond every time to live.
        return 3600 * SECOND if sent is None else now_ns - sent
