"""Calls that a client wants answered within a time of its own."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

__all__ = ["CallTimeouts"]

# Longer than this nobody waits (s).
_LONGEST_S = 86_400.0


class CallTimeouts:
    """The times of one client's calls; call `end_all` at the end."""

    def __init__(self, expire: Callable[[str, float], Awaitable[None]]) -> None:
        """Call ``expire`` with a call's number and its time, when that is over."""
        self._expire = expire
        # By the call's number.
        self._timers: dict[str, asyncio.Task[None]] = {}

    def start_call(self, number: str, timeout_s: float | None) -> None:
        """Give a call so long; no number, or none above 0, gives it all the time."""
        # What compares to nothing is not above 0 either.
        if timeout_s is not None and timeout_s > 0:
            wait_s = min(timeout_s, _LONGEST_S)
            self._timers[number] = asyncio.create_task(self._wait_call(number, wait_s))

    def end_call(self, number: str) -> None:
        """Forget a call that is answered."""
        # One without a time is no matter.
        timer = self._timers.pop(number, None)
        if timer is not None:
            timer.cancel()

    def end_all(self) -> None:
        """Forget all: the client has gone."""
        for number in list(self._timers):
            self.end_call(number)

    async def _wait_call(self, number: str, wait_s: float) -> None:
        await asyncio.sleep(wait_s)
        # Before it is told: whoever is told ends the call, which would end this.
        self._timers.pop(number, None)
        await self._expire(number, wait_s)
