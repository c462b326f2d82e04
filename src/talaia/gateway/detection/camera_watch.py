"""Cameras that are looked at again and again, each by a task of its own. Event loop only."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.clock import Clock
    from talaia.gateway.ports import CameraFrame, CameraFrames, ChannelReading
    from talaia.model.site import Site
    from talaia.wire.columns import Columns

__all__ = ["WAIT_S", "CameraWatch"]

# For a picture is waited so long at a time.
WAIT_S = 0.5
Wanted = TypeVar("Wanted")


class CameraWatch(ABC, Generic[Wanted]):
    """All cameras of a site that are looked at in one way."""

    def __init__(
        self,
        *,
        site: Site,
        numbers: Mapping[str, int],
        pictures: CameraFrames,
        publish: Callable[[Columns, Mapping[str, ChannelReading]], None],
        clock: Clock,
    ) -> None:
        """Look at nothing yet.

        Args:
            site: the description.
            numbers: of channels, by address.
            pictures: of the cameras.
            publish: takes what is measured, as samples and as newest readings.
            clock: pictures are as old as it says.

        """
        self._site, self._numbers = site, numbers
        self._pictures, self._publish, self._clock = pictures, publish, clock
        # By what is told (or the camera), with how it is looked at.
        self._tasks: dict[str, tuple[Wanted, asyncio.Task[None]]] = {}
        self._running = False
        # What was last wrong with each: said once.
        self._problems: dict[str, str] = {}

    @abstractmethod
    def _list_wanted(self, site: Site) -> Mapping[str, Wanted]:
        """List what is looked at, by a name that stays."""

    @abstractmethod
    async def _watch_camera(self, name: str, wanted: Wanted) -> None:
        """Look until cancelled."""

    async def run(self) -> None:
        """Look until cancelled."""
        self._running = True
        self._begin_cameras()
        try:
            await asyncio.Event().wait()
        finally:
            self._running = False
            tasks = [task for _, task in self._tasks.values()]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    def redescribe(self, site: Site, numbers: Mapping[str, int]) -> None:
        """Look at what another description says; a camera that is the same goes on."""
        self._site, self._numbers = site, numbers
        if self._running:
            self._begin_cameras()

    def _begin_cameras(self) -> None:
        wanted = self._list_wanted(self._site)
        for name, (before, task) in list(self._tasks.items()):
            if wanted.get(name) != before:
                task.cancel()
                del self._tasks[name]
        for name, how in wanted.items():
            if name not in self._tasks:
                task = asyncio.ensure_future(self._watch_camera(name, how))
                self._tasks[name] = how, task

    async def _next_picture(self, stream: str, since_us: int) -> tuple[int, CameraFrame | None]:
        """Wait for a picture; give when it came, 0 for none yet, and the picture."""
        came_us = await asyncio.to_thread(self._pictures.arrived, stream, since_us, WAIT_S)
        if not came_us:
            return 0, None
        return came_us, await asyncio.to_thread(self._pictures.newest, stream)
