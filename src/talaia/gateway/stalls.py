"""Notice that this whole process stood still: frozen, swapped out, or starved.

What the robot said meanwhile lies in the queues of its protocol, which are short. What did not
fit there is lost without a word, so the time is recorded as a gap.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock

__all__ = ["STOOD", "Stalls", "watch_stalls"]

log = logging.getLogger(__name__)
STOOD = "the gateway stood still"
# A loaded machine may keep a process waiting for a second; queues hold that.
_LEAST_NS = 3 * SECOND
_EVERY_S = 0.5


class Stalls:
    """Pure: told the time again and again, it says which time it was not told."""

    def __init__(self, monotonic_ns: int) -> None:
        """Begin at a moment."""
        self._monotonic_ns = monotonic_ns

    def at(self, wall_ns: int, monotonic_ns: int) -> tuple[int, int] | None:
        """Give the time of a stall that has just ended (µs UTC, from and to), or none."""
        stood_ns = monotonic_ns - self._monotonic_ns
        began_ns = wall_ns - stood_ns
        self._monotonic_ns = monotonic_ns
        return (began_ns // 1000, wall_ns // 1000) if stood_ns >= _LEAST_NS else None


async def watch_stalls(clock: Clock, missed: Callable[[int, int, str], None]) -> None:
    """Look twice a second until cancelled; ``missed`` takes each stall and its reason."""
    stalls = Stalls(clock.monotonic_ns())
    while True:
        await asyncio.sleep(_EVERY_S)
        span = stalls.at(clock.wall_ns(), clock.monotonic_ns())
        if span is not None:
            log.warning("this gateway stood still for %.1f s", (span[1] - span[0]) / 1e6)
            missed(*span, STOOD)
