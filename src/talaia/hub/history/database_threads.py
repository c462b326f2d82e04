"""Threads in which the history's database is asked, so that the event loop never waits for it."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.history.errors import HistoryAway

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import ParamSpec, TypeVar

    P = ParamSpec("P")
    R = TypeVar("R")

__all__ = ["DatabaseThreads"]


class DatabaseThreads:
    """A few threads; each uses one connection at a time.

    Together all pools must have fewer threads than the engine has connections: a thread that
    waits for a connection would fail after SQLAlchemy's 30 s instead of standing in the queue.
    """

    def __init__(self, address: str, count: int, name: str) -> None:
        """Make ``count`` threads for the database at ``address`` (as it is shown in messages)."""
        # Where the database is, without a password: every error says it.
        self._address = address
        # Work that finds no free thread waits here, first come, first served.
        self._pool = ThreadPoolExecutor(count, name)

    async def run_query(self, work: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Run ``work`` in one of the threads.

        Raises:
            HistoryAway: the database cannot be read.

        """
        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(self._pool, lambda: work(*args, **kwargs))
        except (SQLAlchemyError, OSError) as error:
            # SQLAlchemy's own text has the statement and its parameters; people need the reason.
            reason = getattr(error, "orig", None) or error
            raise HistoryAway(
                f"{self._address} cannot be read: {reason}", "check that it can be reached"
            ) from error

    def close(self) -> None:
        """Wait for what is under way, and end the threads; blocks."""
        self._pool.shutdown()
