"""Background tasks of the hub: named, begun again when they die, ended in order."""

from __future__ import annotations

import asyncio
import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

__all__ = ["BackgroundTask", "RunningTask"]

_LOG = logging.getLogger(__name__)
# Before a task that died begins again: doubled each time, up to the longest (s).
FIRST_PAUSE_S = 1.0
LONGEST_PAUSE_S = 60.0


@dataclass(frozen=True, kw_only=True)
class BackgroundTask:
    """What a feature does while the hub is open.

    Attributes:
        name: within its feature, for the log and for who looks at the event loop.
        run: does it until cancelled, or until ``stop`` was called.
        stop: lets ``run`` write down what waits and end; none: it is cancelled.

    """

    name: str
    run: Callable[[], Coroutine[Any, Any, None]]
    stop: Callable[[], None] | None = None


class RunningTask:
    """A task that runs: one that dies is logged and begins again.

    A hub that ended with it would take STOP and driving away from everybody; one that went on
    without it would lose alarms or the log without a word.
    """

    def __init__(self, feature: str, task: BackgroundTask) -> None:
        """Begin; an event loop runs."""
        self._task = task
        self._name = f"{feature}: {task.name}"
        self._stopping = asyncio.Event()
        self._running = asyncio.create_task(self._supervise(), name=self._name)

    async def end(self) -> None:
        """Let the task end, and wait until it has."""
        self._stopping.set()
        if self._task.stop is None:
            self._running.cancel()
        else:
            self._task.stop()
        await asyncio.gather(self._running, return_exceptions=True)

    async def _supervise(self) -> None:
        loop, pause_s = asyncio.get_running_loop(), FIRST_PAUSE_S
        while True:
            began_s = loop.time()
            try:
                await self._task.run()
            except Exception:  # noqa: BLE001 - logged, and begun again
                _LOG.exception("the background task %r died", self._name)
            else:
                if not self._stopping.is_set():
                    _LOG.error("the background task %r ended by itself", self._name)
            if self._stopping.is_set():
                return
            if loop.time() - began_s > LONGEST_PAUSE_S:
                pause_s = FIRST_PAUSE_S
            _LOG.warning("the background task %r begins again in %g s", self._name, pause_s)
            # Who is told to stop in the pause runs once more, to write down what waits.
            try:
                async with asyncio.timeout(pause_s):
                    await self._stopping.wait()
            except TimeoutError:
                pause_s = min(2 * pause_s, LONGEST_PAUSE_S)
