"""The connections of gateways that are open now, and their end when a key is revoked."""

from __future__ import annotations

import asyncio
import logging
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

from talaia.hub.errors import StoreDown
from talaia.wire.frames import ReconnectRequest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.sites.site_registry import SiteRegistry

__all__ = ["OpenConnection", "OpenLinks"]

_LOG = logging.getLogger(__name__)


class OpenConnection(Protocol):
    """A connection of a gateway: its link, or the one for pictures."""

    def dismiss_gateway(self, reason: str) -> None:
        """Say good-bye and close."""
        ...


class OpenLinks:
    """Who of the gateways is connected."""

    def __init__(self, sites: Sites, registry: SiteRegistry) -> None:
        """Ask ``registry`` whose key is still good."""
        self._sites = sites
        self._registry = registry
        # The gateway's number, by connection; it may have two: its link, and one for pictures.
        self._open: dict[OpenConnection, int] = {}
        # Those of them whose key was good when it was looked at, and how many keys were void then.
        self._good: set[int] = set()
        self._void = -1

    @contextmanager
    def count_open(self, gateway: int, connection: OpenConnection) -> Iterator[None]:
        """Count a connection as open."""
        self._open[connection] = gateway
        try:
            yield
        finally:
            del self._open[connection]

    def online_gateways(self) -> dict[int, LiveSite]:
        """Give the gateways that have a link now, each with the site it speaks for."""
        linked = {live.link: live for live in self._sites if live.link is not None}
        return {
            gateway: linked[connection]
            for connection, gateway in self._open.items()
            if connection in linked
        }

    def hang_up(self, gateway: int, reason: str) -> None:
        """Close every connection of a gateway, at once."""
        # A copy: what is dismissed goes out of it.
        for connection, of in list(self._open.items()):
            if of == gateway:
                connection.dismiss_gateway(reason)

    def reconnect_device(self, gateway: int, device: str, who: str) -> bool:
        """Let a gateway connect anew to a device; False when it is away or has none such."""
        live = self.online_gateways().get(gateway)
        if live is None or live.link is None or device not in live.description.devices:
            return False
        live.link.send(ReconnectRequest(device=device, who=who))
        return True

    async def watch_keys(self, every_s: float) -> None:
        """Hold the open connections against the keys until cancelled.

        This finds what other processes did (the command line, another hub).
        """
        failing = False
        while True:
            await asyncio.sleep(every_s)
            try:
                await self.check_keys()
            # Links stay: that nobody can look revokes no key.
            except StoreDown:
                if not failing:
                    _LOG.exception("gateways' keys cannot be checked: the database does not answer")
                failing = True
            else:
                failing = False

    async def check_keys(self) -> None:
        """Close the connections of gateways whose key is void.

        Of thousands it is asked only when a key has become void, and of each that is new here: it
        may have become so while it was let in.
        """
        known = set(self._open.values())
        if not known:
            return
        # Before the keys themselves: one that becomes void in between counts the next time.
        void = await self._registry.count_void_keys()
        asked = known if void != self._void else known - self._good
        good = await self._registry.good_keys(asked) if asked else set()
        for gateway in asked - good:
            self.hang_up(gateway, "its key was revoked")
        self._good, self._void = (known - asked) | good, void
