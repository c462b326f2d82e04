"""Requests of the hub that take a while, each as a task of its own."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

__all__ = ["RequestTasks"]

log = logging.getLogger(__name__)


class RequestTasks:
    """Runs them; one that fails is logged and ends nothing else. Event loop only."""

    def __init__(self, on_end: Callable[[], None]) -> None:
        """Call ``on_end`` after each."""
        self._on_end = on_end  # Called after each request; the timer of driving is set anew by it.
        # Held until they end: the event loop keeps only weak references to tasks.
        self._tasks: set[asyncio.Task[object]] = set()

    def spawn_task(self, work: Coroutine[object, None, object]) -> None:
        """Begin a request."""
        task = asyncio.create_task(work, name="request of the hub")
        self._tasks.add(task)
        task.add_done_callback(self._handle_end)

    def _handle_end(self, task: asyncio.Task[object]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and task.exception() is not None:
            log.error("a request failed", exc_info=task.exception())
        self._on_end()

    async def close(self) -> None:
        """Finish what was begun."""
        await asyncio.gather(*self._tasks, return_exceptions=True)
