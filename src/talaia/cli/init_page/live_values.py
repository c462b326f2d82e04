"""The newest value of each signal that is proposed, and pictures, read as a gateway would read it.

It only listens: what is driven or commanded is left out, so nothing is published.
"""

from __future__ import annotations

import asyncio
import logging
import math
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import msgspec

from talaia.clock import SECOND, SystemClock
from talaia.gateway.adapters.catalog import adapter_of
from talaia.gateway.adapters.connection_scope import connection_names, scopes_of
from talaia.gateway.adapters.connectivity import DeviceReachability
from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
from talaia.gateway.ports import AdapterContext
from talaia.gateway.silent_sinks import SilentSinks
from talaia.wire.frames import PictureForm

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Collection
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.model.site import Site
    from talaia.wire.columns import Columns
    from talaia.wire.frames import PictureFrame

__all__ = ["LiveValues", "reading_values"]

log = logging.getLogger(__name__)
# A text may be a whole file.
_MOST_TEXT = 80
# A picture is made while the page asks for its camera, and no more often than this (s).
_ASKED_FOR_S, _PICTURE_EVERY_S = 10.0, 1.0


class LiveValues(SilentSinks):
    """Keeps the newest value by the address of its channel, and pictures; any thread."""

    def __init__(self, site: Site, clock: Clock) -> None:
        """Know nothing yet."""
        self._clock = clock
        # By camera: until when its pictures are asked for, and when one was made (monotonic ns).
        self._asked_until: dict[str, int] = {}
        self._made_at: dict[str, int] = {}
        self._pictures: dict[str, bytes] = {}
        # Told which cameras were ever asked for, when there is a new one among them.
        self.on_asked: Callable[[Collection[str]], None] = lambda _: None
        self._addresses = [channel.address for channel in site.channels()]
        self._streams = {
            f"{word}/{name}" for word, device in site.devices.items() for name in device.streams
        }
        # Replaced whole, so that readers on another thread need no lock.
        self.newest: dict[str, float | str] = {}

    def put_samples(self, columns: Columns) -> None:
        """Keep the newest of them."""
        newest = dict(self.newest)
        for row, (channel, value) in enumerate(
            zip(columns.channel.tolist(), columns.value.tolist(), strict=True)
        ):
            text = columns.texts.get(row)
            if text is not None:
                newest[self._addresses[channel]] = text[:_MOST_TEXT]
            elif math.isfinite(value):
                newest[self._addresses[channel]] = value
        self.newest = newest

    def picture_of(self, stream: str) -> bytes | None:
        """Give the newest picture of a camera (JPEG), and ask for the next; none so far.

        Of the event loop's thread alone.
        """
        is_new = stream not in self._asked_until
        if stream not in self._streams:
            return None
        self._asked_until[stream] = self._clock.monotonic_ns() + round(_ASKED_FOR_S * SECOND)
        if is_new:
            self.on_asked(frozenset(self._asked_until))
        return self._pictures.get(stream)

    def asked(self, stream: str) -> Collection[str]:
        """Want a small picture now and then, of cameras that the page shows."""
        now = self._clock.monotonic_ns()
        if now > self._asked_until.get(stream, 0):
            return ()
        made = self._made_at.get(stream)
        is_due = made is None or now - made > _PICTURE_EVERY_S * SECOND
        return (PictureForm.JPEG_SMALL,) if is_due else ()

    def room(self) -> float:
        """Have room for all of a picture."""
        return 1.0

    def offer(self, picture: PictureFrame) -> None:
        """Keep it as the newest."""
        self._made_at[picture.stream] = self._clock.monotonic_ns()
        self._pictures[picture.stream] = picture.data


class _Unheard:
    """An `EventSink` for the log."""

    def report_event(self, kind: str, message: str, **more: Any) -> None:  # noqa: ANN401
        log.info("%s %s %s", kind, message, more)


@asynccontextmanager
async def reading_values(site: Site, folder: Path, domain: int | None) -> AsyncIterator[LiveValues]:
    """Read the robot within this context.

    Args:
        site: as it is proposed; what would be told to the robot is left out here.
        folder: for what adapters keep while they run.
        domain: of ROS 2; none: the environment's.

    """
    devices = {
        word: msgspec.structs.replace(device, drive=None, commands={})
        for word, device in site.devices.items()
    }
    heard = msgspec.structs.replace(site, devices=devices, boards={})
    clock, loop = SystemClock(), asyncio.get_running_loop()
    values = LiveValues(heard, clock)
    of = connection_names(heard)
    reach = DeviceReachability(of, clock, lambda _state: None)
    events: Any = _Unheard()
    context = AdapterContext(clock, values, values, events, folder, domain, site=heard.name)
    adapters = {
        scope.name: (adapter_of(scope, context, status), status)
        for scope in scopes_of(heard)
        for status in (ConnectionStatus(scope.name, loop, reach),)
        if scope.devices
    }
    adapter = MultiAdapter(of=of, adapters=adapters, reach=reach, events=events)
    values.on_asked = adapter.watch
    running = asyncio.ensure_future(adapter.run())
    try:
        yield values
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
