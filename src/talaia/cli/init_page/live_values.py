"""The newest value of each signal that is proposed, read as a gateway would read it.

It only listens: what is driven, commanded or pictured is left out, so nothing is published.
"""

from __future__ import annotations

import asyncio
import logging
import math
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import msgspec

from talaia.clock import SystemClock
from talaia.gateway.adapters.catalog import adapter_of
from talaia.gateway.adapters.connection_scope import connection_names, scopes_of
from talaia.gateway.adapters.connectivity import DeviceReachability
from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
from talaia.gateway.ports import AdapterContext
from talaia.gateway.silent_sinks import SilentSinks

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from talaia.model.site import Site
    from talaia.wire.columns import Columns

__all__ = ["LiveValues", "reading_values"]

log = logging.getLogger(__name__)
# A text may be a whole file.
_MOST_TEXT = 80


class LiveValues(SilentSinks):
    """Keeps the newest value by the address of its channel; `put_samples` from any thread."""

    def __init__(self, site: Site) -> None:
        """Know nothing yet."""
        self._addresses = [channel.address for channel in site.channels()]
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
        word: msgspec.structs.replace(device, drive=None, commands={}, streams={})
        for word, device in site.devices.items()
    }
    heard = msgspec.structs.replace(site, devices=devices, boards={})
    clock, values, loop = SystemClock(), LiveValues(heard), asyncio.get_running_loop()
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
    running = asyncio.ensure_future(adapter.run())
    try:
        yield values
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
