"""Which client protocols are open, to which origins, who drives by them, and who is connected."""

from __future__ import annotations

import asyncio
import logging
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Protocol

from talaia.hub.clients.catalog import CLIENT_PROTOCOLS
from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.store.clients.protocols import ClientProtocols, ProtocolState

__all__ = ["OpenProtocols"]


class EndsConnection(Protocol):
    """A client that is connected."""

    def end(self, reason: str) -> None:
        """Close, with the reason."""
        ...


_LOG = logging.getLogger(__name__)
_SHUT = "an admin has shut this protocol"
_ORIGIN = "an admin has taken this origin from those that are let in"
# A reading that takes longer than this counts as failed (s).
_READ_S = 5.0
# So many times longer between two looks while nobody is connected.
_SELDOM = 20


class OpenProtocols:
    """The table of protocols as it is now; what it no longer allows is closed at once."""

    def __init__(self, store: ClientProtocols, *, led_elsewhere: bool = False) -> None:
        """Read from ``store``; all is shut until that has been done.

        ``led_elsewhere``: admins open and shut at another hub, so it is read again often whoever
        is connected here.
        """
        self._led_elsewhere = led_elsewhere
        # What is read here may have been written by another process.
        self._store = store
        # By short name.
        self._states: dict[str, ProtocolState] = {}
        # The account's number, site and device.
        self._drivers: frozenset[tuple[int, str, str]] = frozenset()
        # Connections that are open now, with the origin each came from; empty: no page's.
        self._connected: dict[str, dict[EndsConnection, str]] = {
            protocol: {} for protocol in CLIENT_PROTOCOLS
        }
        # Set when somebody connects whom a change that is not known yet may end.
        self._somebody = asyncio.Event()

    def is_open(self, protocol: str) -> bool:
        """Tell whether an admin has opened a protocol."""
        state = self._states.get(protocol)
        return state is not None and state.open

    def lets_in(self, protocol: str, origin: str | None) -> bool:
        """Tell whether a page of this origin may connect; a tool that is no page names none."""
        if origin is None:
            return True
        state = self._states.get(protocol)
        return state is not None and origin in state.origins

    def may_drive(self, user: int, site: str, device: str) -> bool:
        """Tell whether an admin lets an account drive a device by such clients."""
        return (user, site, device) in self._drivers

    def count_connected(self, protocol: str) -> int:
        """Count the clients that are connected now."""
        return len(self._connected.get(protocol, ()))

    @contextmanager
    def count_client(
        self, protocol: str, client: EndsConnection, origin: str | None
    ) -> Iterator[None]:
        """Count a client while it is connected; it is ended when its protocol is shut."""
        # Also of a protocol that the catalog of this version does not know.
        clients = self._connected.setdefault(protocol, {})
        clients[client] = origin or ""
        self._somebody.set()
        try:
            yield
        finally:
            del clients[client]

    async def reload_table(self) -> None:
        """Read the table again, and end what it allows no longer.

        Raises:
            StoreDown: it cannot be read; all stays as it is.

        """
        states, self._drivers = await self._store.read_permitted()
        self._states = {state.protocol: state for state in states}
        for protocol, clients in self._connected.items():
            shut = not self.is_open(protocol)
            # A copy: a client that ends leaves the list.
            for client, origin in list(clients.items()):
                if shut:
                    client.end(_SHUT)
                elif not self.lets_in(protocol, origin or None):
                    client.end(_ORIGIN)

    async def watch(self, every_s: float) -> None:
        """Follow what other processes write into the table, until cancelled.

        This hub's own changes are read at once. While nobody is connected whom a change would end,
        it looks more seldom; the first who connects has it look soon.
        """
        failing = False
        while True:
            if not self._led_elsewhere and not any(self._connected.values()):
                self._somebody.clear()
                with suppress(TimeoutError):
                    async with asyncio.timeout(every_s * (_SELDOM - 1)):
                        await self._somebody.wait()
            await asyncio.sleep(every_s)
            try:
                async with asyncio.timeout(_READ_S):
                    await self.reload_table()
            except (StoreDown, TimeoutError) as error:
                if not failing:
                    _LOG.error("client protocols cannot be read and stay as they are: %s", error)
                failing = True
            else:
                if failing:
                    _LOG.warning("client protocols are read again")
                failing = False
