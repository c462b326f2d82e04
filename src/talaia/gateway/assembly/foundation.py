"""What every part of the gateway uses: the locked data folder, disk threads, lanes to the hub."""

from __future__ import annotations

import asyncio
import os
import secrets
import time
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.assembly.signal import ThreadSafeSignal
from talaia.gateway.fits.frame_arrivals import FrameArrivals
from talaia.gateway.persistence import lock_folder
from talaia.gateway.uplink.event_reporter import EventReporter
from talaia.gateway.uplink.send_lanes import SendLanes

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.settings import GatewaySettings
    from talaia.wire.frames import FromGateway

__all__ = ["FoundationPart"]


class FoundationPart(GatewayPart):
    """Attributes are what other parts are built of.

    Attributes:
        settings: see `GatewaySettings`.
        clock: every part's.
        loop: the gateway's only one.
        boot: names this run of the gateway.
        lanes: what is to be sent to the hub.
        frame_waiting: set when there is something in them.
        file_waiting: set when a recording or a picture waits for the hub.
        events: takes what is worth writing down, from any thread.
        streams_changed: emitted when other camera streams are wanted than before.
        arrivals: hands the next FITS file of a camera to whoever waits for it.
        file_thread: for pictures and recordings, whose disk work is large.

    """

    def __init__(self, *, settings: GatewaySettings, clock: Clock) -> None:
        """Lock the data folder.

        Raises:
            SpoolError: the data folder cannot be used.

        """
        self.settings = settings
        self.clock = clock
        self.loop = asyncio.get_running_loop()
        self.boot = _new_boot()
        # The lock is held until `close`; nothing in the folder is touched before.
        self._lock = lock_folder(settings.data)
        # One thread for the small files: their writes keep their order.
        self._disk_thread = ThreadPoolExecutor(1, "talaia-disk")
        # Of its own, so that a picture of many megabytes never delays a STOP's write.
        self.file_thread = ThreadPoolExecutor(1, "talaia-files")
        self.frame_waiting = asyncio.Event()
        # The lanes wake the link; both live on the loop.
        self.lanes = SendLanes(self.frame_waiting.set)
        self.arrivals = FrameArrivals()
        self.file_waiting = asyncio.Event()
        self.events = EventReporter(loop=self.loop, clock=clock, lanes=self.lanes)
        # Made here, for parts that come early emit it and one that comes late receives.
        self.streams_changed = ThreadSafeSignal(self.loop)

    def wall_us(self) -> int:
        """Give the wall time (µs, UTC)."""
        return self.clock.wall_ns() // 1000

    def announce_file(self) -> None:
        """Tell the uplink that a file waits; from any thread."""
        self.loop.call_soon_threadsafe(self.file_waiting.set)

    def send_threadsafe(self, message: FromGateway) -> None:
        """Queue a message for the hub; from any thread."""
        self.loop.call_soon_threadsafe(self.lanes.send, message)

    async def run_on_disk(self, work: Callable[[], None]) -> None:
        """Run a blocking write on the small files' thread, in order; raises what it raises."""
        await self.loop.run_in_executor(self._disk_thread, work)

    async def close(self) -> None:
        """Wait for the disk, and let another gateway have the data folder."""
        # Before the lock goes: another gateway must not meet our last writes.
        self._disk_thread.shutdown(wait=True)
        self.file_thread.shutdown(wait=True)
        os.close(self._lock)


def _new_boot() -> str:
    """Name this run of the gateway; later runs sort behind while the clock is right."""
    # Milliseconds in hexadecimal, of one width; the rest tells apart what begins in the same one.
    return f"{time.time_ns() // 1_000_000:012x}-{secrets.token_hex(4)}"
