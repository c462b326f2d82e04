"""Who comes while no hub leads waits for the next one, for a moment."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["LeadWait"]

# A take-over lasts no longer in most cases, and gateways and pages have more patience (s).
HELD_S = 3.0
# Each is a socket in memory.
_MOST_HELD = 5_000


class LeadWait:
    """Holds requests until a hub leads.

    To send them away would cost each the pause after which it dials again, and whatever stands
    before the hubs as many connections more.
    """

    def __init__(self, find: Callable[[], bool], *, held_s: float = HELD_S) -> None:
        """Ask ``find`` whether a hub leads; hold nobody for longer than ``held_s``."""
        self._find = find
        self._held_s = held_s
        self._held = 0
        self._news = asyncio.Event()

    def notify(self) -> None:
        """Let those who wait look again."""
        news, self._news = self._news, asyncio.Event()
        news.set()

    async def wait_for_lead(self) -> None:
        """Return once a hub leads, or when it takes too long."""
        if self._find() or self._held >= _MOST_HELD:
            return
        self._held += 1
        try:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self._held_s):
                    while not self._find():
                        await self._news.wait()
        finally:
            self._held -= 1
