"""Notice that this whole process stood still: frozen, swapped out, or starved.

What the robot said meanwhile lies in the queues of its protocol, which are short. What did not
fit there is lost without a word, so the time is recorded as a gap.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock

__all__ = ["STOOD", "FreezeCredit", "FreezeDetector", "watch_stalls"]

log = logging.getLogger(__name__)
STOOD = "the gateway stood still"
# A loaded machine may keep a process waiting for a second; queues hold that.
_LEAST_NS = 3 * SECOND
# Six looks within the shortest stall that counts, so that it is measured to half a second.
_EVERY_S = 0.5


class FreezeDetector:
    """Pure: told the time again and again, it says which time it was not told."""

    def __init__(self, monotonic_ns: int) -> None:
        """Begin at a moment."""
        self._monotonic_ns = monotonic_ns  # When it was last told the time (monotonic ns).

    def detect_stall(self, wall_ns: int, monotonic_ns: int) -> tuple[int, int] | None:
        """Give the time of a stall that has just ended (µs UTC, from and to), or none."""
        # By the monotonic clock: one that is set makes no stall.
        stood_ns = monotonic_ns - self._monotonic_ns
        # The wall clock of now, counted back: it is what samples are stamped with.
        began_ns = wall_ns - stood_ns
        self._monotonic_ns = monotonic_ns
        return (began_ns // 1000, wall_ns // 1000) if stood_ns >= _LEAST_NS else None


class FreezeCredit:
    """How old something is, for one who may have stood still himself. Pure.

    While this process stood still it heard nothing, which says nothing about who is heard. What
    it slept through is taken off an age, for `SETTLE_NS` of running time after waking: what has
    not arrived by then is as old as the clock says. So is what stays silent while standstills
    follow each other, once the time between them comes to that.
    """

    # A look that comes later than this after the last one (they come ten times a second) was late.
    LEAST_NS = SECOND // 2
    SETTLE_NS = 2 * SECOND
    # So many are taken off an age. Where every look is late, because the machine is overloaded,
    # time would pass as one standstill after the other, and nobody's silence would count: after so
    # many looks what was said while it slept has had its turns to arrive.
    KEPT = 8

    def __init__(self, now_ns: int) -> None:
        """Begin at a moment (monotonic)."""
        self._at_ns = now_ns  # When it was last known to run (monotonic ns); never goes back.
        # When this process stood still (from, to), oldest first.
        self._stalls: deque[tuple[int, int]] = deque(maxlen=self.KEPT)

    def mark_running(self, now_ns: int) -> None:
        """Take in that it runs now."""
        if now_ns - self._at_ns >= self.LEAST_NS:
            self._stalls.append((self._at_ns, now_ns))
        # `max`: two callers may hand in their times in the other order.
        self._at_ns = max(self._at_ns, now_ns)

    def is_settling(self, now_ns: int) -> bool:
        """Tell whether it has just stood still, so that ages may be judged with credit."""
        self.mark_running(now_ns)
        # Standstills that follow each other stretch the time to settle.
        return any(now_ns - to_ns <= self.SETTLE_NS for _, to_ns in self._stalls)

    def age_ns(self, since_ns: int, now_ns: int) -> int:
        """Give the age of something that was at ``since_ns``."""
        self.mark_running(now_ns)
        age_ns, slept_ns, first_ns = now_ns - since_ns, 0, now_ns
        for from_ns, to_ns in reversed(self._stalls):
            if to_ns <= since_ns:
                break
            first_ns = max(from_ns, since_ns)
            slept_ns += to_ns - first_ns
        ran_ns = now_ns - first_ns - slept_ns
        # What ran since the first standstill, without the standstills, has had its time to arrive.
        return age_ns - slept_ns if ran_ns <= self.SETTLE_NS else age_ns


async def watch_stalls(clock: Clock, missed: Callable[[int, int, str], None]) -> None:
    """Look twice a second until cancelled; ``missed`` takes each stall and its reason."""
    stalls = FreezeDetector(clock.monotonic_ns())
    while True:
        await asyncio.sleep(_EVERY_S)
        span = stalls.detect_stall(clock.wall_ns(), clock.monotonic_ns())
        if span is not None:
            log.warning("this gateway stood still for %.1f s", (span[1] - span[0]) / 1e6)
            missed(*span, STOOD)
