"""How many gateways are taken in at once.

After a hub was away, all its gateways dial within seconds, and each costs look-ups in the
database. Sessions are looked up there too, and while it cannot be told who may drive, driving is
refused. So only a few gateways at a time write to the database, and the rest wait their turn; keys
are looked up for all together, and who says what the hub knows already needs no turn.
"""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from talaia.hub.errors import HubBusy

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

__all__ = ["JoinQueue"]


class JoinQueue:
    """Turns, first come, first served."""

    # This is less than half of the database's connections: the others are for people.
    AT_ONCE = 3
    # Each is a socket in memory, and waits less long than the gateway's patience (5 s).
    MOST_WAITING = 1000
    # What a turn takes, of those that are had at once (s).
    TURN_S = 0.02

    def __init__(self, at_once: int = AT_ONCE) -> None:
        """Begin with nobody; ``at_once`` may have a turn at the same time."""
        self._turns = asyncio.Semaphore(at_once)
        # Gateways that have no turn yet; those that hold one do not count.
        self._waiting = 0

    @property
    def after_s(self) -> float:
        """When one that finds no turn is to come back (s): once those that wait have had theirs."""
        return max(2.0, self._waiting * self.TURN_S)

    @asynccontextmanager
    async def wait_turn(self) -> AsyncIterator[None]:
        """Wait for a turn, and hold it.

        Raises:
            HubBusy: so many wait that it would take too long.

        """
        if self._waiting >= self.MOST_WAITING:
            raise HubBusy("too many gateways come at once", "they try again by themselves")
        self._waiting += 1
        try:
            await self._turns.acquire()
        finally:
            # Also when its link ended while it waited.
            self._waiting -= 1
        try:
            yield
        finally:
            self._turns.release()
