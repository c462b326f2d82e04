"""The gateway's own time marks, by which the age of a driver's frame is told. Pure."""

from __future__ import annotations

from talaia.clock import MS, SECOND

__all__ = ["TICK_NS", "TickClock"]

TICK_NS = 50 * MS


class TickClock:
    """No wall clock decides how old a frame is: it echoes the newest mark that its driver has seen.

    Attributes:
        last: the number of the newest mark.
        last_ns: when that was sent (monotonic).

    """

    KEPT = 64

    def __init__(self) -> None:
        """Start before the first."""
        # When each mark was sent (monotonic), the newest `KEPT` of them.
        self._sent: dict[int, int] = {}
        self.last = -1
        self.last_ns = -TICK_NS

    def next(self, now_ns: int) -> int:
        """Make the next mark."""
        self.last += 1
        self.last_ns = now_ns
        self._sent[self.last] = now_ns
        self._sent.pop(self.last - self.KEPT, None)
        return self.last

    def age_ns(self, tick: int, now_ns: int) -> int:
        """Tell how long ago a mark was sent; negative if it never was."""
        if not 0 <= tick <= self.last:
            return -1
        sent = self._sent.get(tick)
        # Older than all that is kept: far beyond every time to live.
        return 3600 * SECOND if sent is None else now_ns - sent
