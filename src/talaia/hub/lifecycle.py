"""The life of the hub: features open in their order, their tasks run, and all close in reverse."""

from __future__ import annotations

import asyncio
import logging
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from talaia.hub.features.feature import BackgroundTask, Core, Feature

__all__ = ["RunningTask", "open_features"]

_LOG = logging.getLogger(__name__)
# Before a task that died begins again: doubled each time, up to the longest (s).
FIRST_PAUSE_S = 1.0
LONGEST_PAUSE_S = 60.0


class RunningTask:
    """A task that runs: one that dies is logged and begins again.

    A hub that ended with it would take STOP and driving away from everybody; one that went on
    without it would lose alarms or the log without a word.
    """

    def __init__(self, feature: str, task: BackgroundTask, first_pause_s: float) -> None:
        """Begin; an event loop runs."""
        # What runs, and how it is told to end.
        self._task = task
        # Before it begins again for the first time (s).
        self._first_pause_s = first_pause_s
        # For the log, and for whoever lists the tasks of the loop.
        self._name = f"{feature}: {task.name}"
        # Set once, by `end_task`, and never cleared.
        self._stopping = asyncio.Event()
        # Kept, so that it is waited for; the loop itself holds tasks only weakly.
        self._running = asyncio.create_task(self._supervise_task(), name=self._name)

    async def end_task(self) -> None:
        """Let the task end, and wait until it has."""
        # Before the task is told: what ends because of that must not count as a death.
        self._stopping.set()
        # It has nothing to write down; it may be ended anywhere.
        if self._task.stop is None:
            self._running.cancel()
        else:
            self._task.stop()
        # A cancellation comes back as a value here: it is what was asked for.
        await asyncio.gather(self._running, return_exceptions=True)

    async def _supervise_task(self) -> None:
        # The loop's clock is monotonic: a set wall clock makes no pause longer or shorter.
        loop, pause_s = asyncio.get_running_loop(), self._first_pause_s
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
            # It ran well for a while: this is a new trouble, and no part of the one before.
            if loop.time() - began_s > LONGEST_PAUSE_S:
                pause_s = self._first_pause_s
            _LOG.warning("the background task %r begins again in %g s", self._name, pause_s)
            # Who is told to stop in the pause runs once more, to write down what waits.
            try:
                async with asyncio.timeout(pause_s):
                    await self._stopping.wait()
            except TimeoutError:
                pause_s = min(2 * pause_s, LONGEST_PAUSE_S)


@asynccontextmanager
async def open_features(
    core: Core, features: Sequence[Feature], first_pause_s: float = FIRST_PAUSE_S
) -> AsyncIterator[None]:
    """Open what is given and run its tasks; close it again, the last one first.

    A task that dies begins again after ``first_pause_s``, and then after ever longer.

    No task runs before all features are open. Each feature's tasks end before it closes, and it
    closes before those that it was built from. What cannot open closes those before it.

    Raises:
        StoreError: the database cannot be opened.
        CannotStart: what a feature needs cannot be read.

    """
    async with AsyncExitStack() as stack:
        # Filled once all are open; what closes a feature that opened before has the list already.
        running: dict[str, list[RunningTask]] = {feature.name: [] for feature in features}
        # Pushed before it opens: a migration that fails has connections open, too.
        stack.push_async_callback(core.close)
        await core.open()
        for feature in features:
            await feature.open()
            stack.push_async_callback(_close_feature, feature, running[feature.name])
        for feature in features:
            running[feature.name] += [
                RunningTask(feature.name, task, first_pause_s) for task in feature.tasks
            ]
        yield


# Its tasks end while all that they use is still open.
async def _close_feature(feature: Feature, running: list[RunningTask]) -> None:
    for task in reversed(running):
        await task.end_task()
    await feature.close()
