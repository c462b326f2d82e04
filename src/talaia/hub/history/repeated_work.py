"""What the history does again and again while it is open."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING

from talaia.hub.history.errors import HistoryError

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

__all__ = ["RepeatedWork"]


class RepeatedWork:
    """Some tasks, until they are ended."""

    def __init__(self) -> None:
        """Do nothing yet."""
        # The event loop itself holds tasks only weakly.
        self._tasks: list[asyncio.Task[None]] = []

    def start_work(self, every_s: float, work: Callable[[], Awaitable[object]]) -> None:
        """Do ``work`` so often (s); 0 is never."""
        if every_s:
            self._tasks.append(asyncio.create_task(_repeat_forever(every_s, work)))

    async def end_work(self) -> None:
        """End all of it."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)


async def _repeat_forever(period_s: float, work: Callable[[], Awaitable[object]]) -> None:
    while True:
        await asyncio.sleep(period_s)
        # The writing thread logs what goes wrong, once; the next time comes anyway.
        with suppress(HistoryError):
            await work()
