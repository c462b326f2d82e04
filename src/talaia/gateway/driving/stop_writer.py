"""Has STOP on disk, so that it survives a restart; no stopping ever waits for it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.gateway.driving.persistent_state import PersistentStops
    from talaia.gateway.driving.stop_latch import LatchedStop
    from talaia.gateway.ports import ControlOutput

__all__ = ["StopWriter"]

log = logging.getLogger(__name__)


class StopWriter:
    """Writes latched STOPs on the disk's thread. Event loop only."""

    def __init__(
        self,
        *,
        stops: PersistentStops,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
        output: ControlOutput,
    ) -> None:
        """Write nothing yet.

        Args:
            stops: latches kept on disk.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.
            output: told when the disk does not take a STOP, and when it does again.

        """
        self._stops = stops  # Both what is on disk and what waits for it.
        # One worker thread, in order: a release never overtakes the STOP before it.
        self._on_disk = on_disk
        self._output = output

    def latched_stop(self, device: str) -> LatchedStop | None:
        """Give the STOP of a device that an earlier run left, if any."""
        return self._stops.find_stop(device)

    async def write_stop(self, device: str, latched: LatchedStop) -> None:
        """Write a STOP to disk, so that it survives a restart."""
        try:
            await self._on_disk(lambda: self._stops.write_stop(device, latched))
        except OSError as error:
            # Latched it is; `write_waiting` tries again.
            problem = f"STOP is on, but cannot be kept over a restart: {error}"
            self._output.record_event("disk_failed", device, problem, latched.who, good=False)

    async def write_waiting(self) -> None:
        """Try again to write each STOP that the disk did not take."""
        if not self._stops.behind:
            return
        try:
            await self._on_disk(self._stops.write_waiting)
        except OSError as error:
            # Recorded once by `write_stop`; each vain attempt since would fill the record.
            log.debug("STOP is not on disk yet: %s", error)
            return
        said = "STOP is on disk now, and will be kept over a restart"
        self._output.record_event("disk_recovered", "", said, "", good=True)

    async def write_release(self, device: str) -> str:
        """Write that STOP is released; say why that cannot be written, if so."""
        try:
            await self._on_disk(lambda: self._stops.write_stop(device, None))
        # The caller leaves it stopped: a release that a restart would undo is none.
        except OSError as error:
            return f"the gateway cannot write its disk: {error}"
        return ""
