"""When a message came, by the middleware's word as long as that can be true. Pure.

The middleware notes the time of arrival, which is finer than our turns. If the wall clock was set
meanwhile, that note is of another time and is not believed. A note that is old because *we* were
late is true, however old it is: the messages that waited for us keep their own times, and so
their order.
"""

from __future__ import annotations

__all__ = ["Arrivals"]

# So late a message may be taken although this thread was never away (µs).
_LATE_US = 1_000_000


class Arrivals:
    """Judges the arrival times that one thread is told."""

    def __init__(self, mono_ns: int) -> None:
        """Begin with a thread that is awake now."""
        self._awake_ns = mono_ns  # When this thread last had taken all that waited (monotonic ns).

    def mark_awake(self, mono_ns: int) -> None:
        """Note that all that waited until now has been taken."""
        self._awake_ns = mono_ns

    def arrival_time(self, came_us: int, now_us: int, mono_ns: int) -> int:
        """Give when a message came (µs, UTC).

        Args:
            came_us: as the middleware has it.
            now_us: the wall clock, read now.
            mono_ns: the monotonic clock, read now.

        """
        late_us = now_us - came_us
        # By far the most common.
        if 0 <= late_us < _LATE_US:
            return came_us
        # By how long this thread was away, a true note may be old.
        away_us = max(0, mono_ns - self._awake_ns) // 1000
        return came_us if 0 <= late_us < _LATE_US + away_us else now_us
