"""Time in which nobody heard the robot because there was no gateway, or not yet.

From the last that a former run heard to the start of this one, no gateway was running. From then
on, a channel that speaks again and again is heard from its first sample; what it said before that
is gone: its protocol had yet to find us. Both are gaps.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import numpy as np

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.gateway.spool.progress_mark import ProgressMark

__all__ = ["NOT_HEARD", "NOT_RUNNING", "FirstHeard", "absence_span", "watch_first_heard"]

NOT_RUNNING = "the gateway was not running"
NOT_HEARD = "the robot was not heard yet"
# Which channels speak again and again is told after this time; who speaks first later is slow.
SETTLED_S = 10.0
# A clock may be off by this and count as the same (µs).
_SAME_US = 1_000_000
_CHANNELS = 65_536
_NONE = np.empty(0, np.int64)


def absence_span(
    former: ProgressMark, wall_us: int, mono_s: float, machine: str
) -> tuple[int, int]:
    """Give from when to when no gateway ran (µs, UTC).

    How long it was is the monotonic clock's to say, while the machine is still the same: where
    the wall clock was set meanwhile, the time ends now and is so long.

    Args:
        former: how far the run before came.
        wall_us: now.
        mono_s: now.
        machine: see `ProgressMark.machine`.

    """
    from_us = min(former.heard_us, wall_us)
    if machine and machine == former.machine and mono_s >= former.mono_s:
        lasted_us = round((mono_s - former.mono_s) * 1e6)
        if abs(wall_us - lasted_us - former.heard_us) > _SAME_US:
            from_us = wall_us - lasted_us
    return from_us, wall_us


class FirstHeard:
    """When each channel was first heard, until it is settled. Pure."""

    def __init__(self, mono_ns: int) -> None:
        """Begin when the gateway begins."""
        self.began_ns = mono_ns
        self._first_ns: NDArray[np.int64] | None = np.full(_CHANNELS, -1, np.int64)
        self._second_ns = np.full(_CHANNELS, -1, np.int64)

    def add_batch(self, numbers: NDArray[np.uint16], now_ns: int) -> None:
        """Take the channels of a batch, by any numbers that stay."""
        first, second = self._first_ns, self._second_ns
        if first is None:
            return
        channels, times = np.unique(numbers, return_counts=True)
        known = first[channels] >= 0
        again = channels[(known | (times > 1)) & (second[channels] < 0)]
        second[again] = now_ns
        first[channels[~known]] = now_ns

    def end_watching(self) -> None:
        """Watch no more, for nobody asks: what it costs is not for nothing."""
        self._first_ns = None
        self._second_ns = _NONE

    def settle_watching(self) -> float:
        """Give how long (s) channels that speak again and again were not heard; ends watching."""
        first, second = self._first_ns, self._second_ns
        self.end_watching()
        if first is None:
            return 0.0
        waited = first - self.began_ns
        # Who speaks more rarely than we waited has missed no turn.
        lively = (second >= 0) & (second - first < waited)
        return float(waited[lively].max(initial=0)) / SECOND


async def watch_first_heard(
    heard: FirstHeard,
    clock: Clock,
    missed: Callable[[int, int, str], None],
    settled: Callable[[], None],
) -> None:
    """Tell once, when it is settled, for how long the robot was not heard; until cancelled."""
    await asyncio.sleep(SETTLED_S)
    unheard_s = heard.settle_watching()
    if unheard_s > 0:
        # By the wall clock of now: if it was set meanwhile, samples are stamped by it, too.
        since_s = (clock.monotonic_ns() - heard.began_ns) / SECOND
        from_us = clock.wall_ns() // 1000 - round(since_s * 1e6)
        missed(from_us, from_us + round(unheard_s * 1e6), NOT_HEARD)
    settled()
    await asyncio.Event().wait()
