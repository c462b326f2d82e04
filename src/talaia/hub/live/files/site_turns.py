"""One thing at a time for each site, so that what one site's gateway sends holds up no other's."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

__all__ = ["SiteTurns"]


class SiteTurns:
    """Locks by site; one goes when nobody holds it or waits for it."""

    def __init__(self) -> None:
        """Begin with none."""
        # With how many hold it or wait.
        self._locks: dict[str, tuple[asyncio.Lock, int]] = {}

    @asynccontextmanager
    async def wait_turn(self, site: str) -> AsyncIterator[None]:
        """Wait for a site's turn, and hold it."""
        lock, count = self._locks.get(site) or (asyncio.Lock(), 0)
        self._locks[site] = lock, count + 1
        try:
            async with lock:
                yield
        finally:
            count = self._locks[site][1] - 1
            if count:
                self._locks[site] = lock, count
            else:
                del self._locks[site]
