"""Where time comes from.

Pure code takes times as numbers. Code at the edge is handed a `Clock`, so that a test can move
time by hand. Two times are kept apart: *wall* time says when something happened (UTC, may jump),
*monotonic* time says how long ago it was (never jumps, means nothing on another machine).
"""

from __future__ import annotations

import time
from typing import Protocol

__all__ = ["MS", "SECOND", "Clock", "HandClock", "SystemClock"]

# In nanoseconds, as all times of a `Clock` are.
MS = 1_000_000
SECOND = 1_000_000_000


class Clock(Protocol):
    """Both times, in nanoseconds."""

    def wall_ns(self) -> int:
        """Nanoseconds since 1970-01-01T00:00:00 UTC. May jump either way."""
        ...

    def monotonic_ns(self) -> int:
        """Nanoseconds since some moment of this process's machine. Never goes back."""
        ...


class SystemClock:
    """The machine's own clocks."""

    def wall_ns(self) -> int:
        """Read the machine's UTC clock."""
        return time.time_ns()

    def monotonic_ns(self) -> int:
        """Read the machine's monotonic clock."""
        return time.monotonic_ns()


class HandClock:
    """A clock that stands still until it is moved; for tests and simulations."""

    def __init__(self, wall_ns: int = 1_700_000_000 * SECOND, monotonic_ns: int = 0) -> None:
        """Start at the given times."""
        # When it is (UTC, ns); `advance` and `jump_wall` move it.
        self._wall_ns = wall_ns
        # How long it has run (ns); `advance` alone moves it, and never back.
        self._monotonic_ns = monotonic_ns

    def wall_ns(self) -> int:
        """Give the hand-set UTC time."""
        return self._wall_ns

    def monotonic_ns(self) -> int:
        """Give the hand-set monotonic time."""
        return self._monotonic_ns

    def advance(self, ns: int) -> None:
        """Let ``ns`` nanoseconds pass on both clocks."""
        if ns < 0:
            raise ValueError("time does not go back; use jump_wall to set the wall clock")
        self._wall_ns += ns
        self._monotonic_ns += ns

    def jump_wall(self, ns: int) -> None:
        """Set the wall clock on or back, as NTP or a person does; monotonic time is untouched."""
        self._wall_ns += ns
