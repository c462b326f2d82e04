"""How long a gateway has been silent, and what its watchdog does about it. Pure.

Standard library only: the watchdog's process stays small.
"""

from __future__ import annotations

from enum import Enum, auto

__all__ = ["SilenceTimer", "WatchdogTask"]

# Longer between two looks, the watchdog itself stood still, and with it most likely the machine:
# what it could not hear in that time counts for nothing.
LONGEST_LOOK_S = 1.0


class WatchdogTask(Enum):
    """What the watchdog has to do now."""

    WAIT = auto()
    CLOSE = auto()
    LEAVE = auto()


class SilenceTimer:
    """Judges a gateway by its beats.

    Attributes:
        after_s: silence for longer than this closes (s); 0: never.

    """

    def __init__(self, now_s: float) -> None:
        """Begin at a moment (monotonic, s), as if a beat had just come."""
        self.after_s = 0.0
        self._looked_s = now_s
        self._silent_s = 0.0
        self._gone = False
        self._dismissed = False
        self._closed = False

    @property
    def silent_s(self) -> float:
        """Silence so far, as it is counted (s)."""
        return self._silent_s

    def hear_beat(self) -> None:
        """Take a sign of life: whatever was being closed is the gateway's matter again."""
        self._silent_s = 0.0
        self._closed = False

    def hear_goodbye(self) -> None:
        """Take that the gateway ends as it was asked to, or another one takes over."""
        self._dismissed = True

    def hear_end(self) -> None:
        """Take that the line to the gateway has ended without a goodbye: it is dead."""
        self._gone = True

    def report_closed(self) -> None:
        """Take that all is closed, as the sensors say."""
        self._closed = True

    def judge_silence(self, now_s: float) -> WatchdogTask:
        """Say what to do at a moment (monotonic, s)."""
        self._silent_s += min(LONGEST_LOOK_S, max(0.0, now_s - self._looked_s))
        self._looked_s = now_s
        if self._dismissed or (self._gone and (self._closed or not self.after_s)):
            return WatchdogTask.LEAVE
        if self._closed or not self.after_s or self._silent_s < self.after_s:
            return WatchdogTask.WAIT
        return WatchdogTask.CLOSE
