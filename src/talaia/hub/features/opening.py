"""Opens features in their order, runs their tasks, and closes them in the reverse order."""

from __future__ import annotations

from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING

from talaia.hub.features.background import RunningTask

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from talaia.hub.features.feature import Core, Feature

__all__ = ["opened"]


@asynccontextmanager
async def opened(core: Core, features: Sequence[Feature]) -> AsyncIterator[None]:
    """Open what is given and run its tasks; close it again, the last one first.

    No task runs before all features are open. Each feature's tasks end before it closes, and it
    closes before those that it was built from. What cannot open closes those before it.

    Raises:
        StoreError: the database cannot be opened.
        CannotStart: what a feature needs cannot be read.

    """
    async with AsyncExitStack() as stack:
        running: dict[str, list[RunningTask]] = {feature.name: [] for feature in features}
        stack.push_async_callback(core.close)
        await core.open()
        for feature in features:
            await feature.open()
            stack.push_async_callback(_close, feature, running[feature.name])
        for feature in features:
            running[feature.name] += [RunningTask(feature.name, task) for task in feature.tasks]
        yield


async def _close(feature: Feature, running: list[RunningTask]) -> None:
    for task in reversed(running):
        await task.end()
    await feature.close()
