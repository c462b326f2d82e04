"""How a gateway ends in favour of another, with a description that cannot be exchanged in place."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.gateway.reload.discovered_devices import add_discovered, keep_found, kept_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from talaia.gateway.reload.current_description import CurrentDescription
    from talaia.model.site import Device, Site

__all__ = ["GatewayRestart"]

log = logging.getLogger(__name__)


class GatewayRestart:
    """Knows with which description to begin again. Event loop only.

    Attributes:
        site: that description; none while the gateway is to go on.

    """

    def __init__(self, data: Path, current: CurrentDescription) -> None:
        """Keep what is found in the data folder."""
        self.site: Site | None = None
        self._data = data  # Found devices are kept here over the restart.
        self._current = current  # What counts now.
        self._asked = asyncio.Event()  # Set once; a restart is not called off.

    def request_restart(self, site: Site) -> None:
        """Begin again with this description, once nothing moves."""
        self.site = site
        self._asked.set()

    def found(self, connection: str, devices: Mapping[str, Device]) -> None:
        """Keep what was found; if any of it is new, begin again with it."""
        now = self._current.now.site
        site = add_discovered(
            self.site or now, connection, devices, kept_of(self._data, connection)
        )
        new = [name for name, device in site.devices.items() if device != now.devices.get(name)]
        if not new:
            return
        log.info("%s: found %s; the description is made anew", connection, ", ".join(new))
        try:
            keep_found(self._data, connection, devices)
        except OSError as error:
            # It is found again after the restart.
            log.warning("%s: what was found cannot be kept: %s", connection, error)
        self.request_restart(site)

    async def wait_due(self, busy: Callable[[], bool]) -> None:
        """Wait until there is such a description, and nothing moves for it to disturb."""
        await self._asked.wait()
        while busy():  # noqa: ASYNC110 - rare, and told by nobody
            await asyncio.sleep(0.2)
