"""Connections of each address that have not asked for anything yet, and which of them must go.

A socket costs nothing to open. Whoever opens hundreds and says nothing takes the place of those
who come to say something: beyond a bound, those that have been silent longest are closed.
"""

from __future__ import annotations

import ipaddress
import socket
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Sequence

    from talaia.hub.settings import Network

__all__ = [
    "MOST_SILENT",
    "SILENT_S",
    "Arrival",
    "SilentConnections",
    "Speaks",
    "defer_silent",
    "network_of",
]

# Of one address; after a restart all pages and gateways behind one address dial at once.
MOST_SILENT = 64
# Who has been silent for so long is closed where there are more (s); a loaded line takes its time.
SILENT_S = 2.0
# And so many are never held, however quickly they come.
MOST_AT_ALL = 1_024
# So long the system keeps a connection to itself that has sent nothing (s).
_DEFERRED_S = 5
# An IPv6 network that one household or one attacker has to itself.
_PREFIX = 64


@runtime_checkable
class Speaks(Protocol):
    """A protocol that says whether the other side has asked for anything."""

    @property
    def spoken(self) -> bool:
        """Whether a whole request head has come."""
        ...


class Arrival:
    """A connection from when it was accepted until it has said something."""

    def __init__(self, began_s: float) -> None:
        """Begin; ``began_s`` is the loop's time."""
        self.began_s = began_s
        # Shakes hands; it ends before anything can be asked.
        self.task: asyncio.Task[None] | None = None
        self.transport: asyncio.Transport | None = None
        self.protocol: Speaks | None = None

    def is_silent(self) -> bool:
        """Tell whether it is open, and has asked for nothing."""
        if self.transport is None or self.protocol is None:
            return self.task is None or not self.task.done()
        return not self.protocol.spoken and not self.transport.is_closing()

    def close(self) -> None:
        """Close it without a word."""
        if self.transport is not None:
            self.transport.abort()
        elif self.task is not None:
            self.task.cancel()


class SilentConnections:
    """The arrivals of each address, the oldest first."""

    def __init__(self, proxies: Sequence[Network] = ()) -> None:
        """Count all but ``proxies``, behind each of which there are many."""
        self._proxies = tuple(proxies)
        self._arrivals: dict[str, list[Arrival]] = {}

    def add_arrival(self, address: str, now_s: float) -> Arrival | None:
        """Count a connection that comes; None: its address has too many, close it."""
        arrival = Arrival(now_s)
        if self._is_proxy(address):
            return arrival
        # Proxies went before: all that are behind one share its address.
        key = network_of(address)
        silent = [earlier for earlier in self._arrivals.get(key, ()) if earlier.is_silent()]
        while len(silent) >= MOST_SILENT and now_s - silent[0].began_s > SILENT_S:
            silent.pop(0).close()
        if len(silent) >= MOST_AT_ALL:
            self._arrivals[key] = silent
            return None
        self._arrivals[key] = [*silent, arrival]
        # Of addresses, too: whoever has many must not fill memory with them.
        if len(self._arrivals) > MOST_AT_ALL:
            self._forget_spoken()
        return arrival

    def _forget_spoken(self) -> None:
        for key, arrivals in list(self._arrivals.items()):
            if not any(arrival.is_silent() for arrival in arrivals):
                del self._arrivals[key]

    def _is_proxy(self, text: str) -> bool:
        try:
            address = ipaddress.ip_address(text)
        except ValueError:
            return False
        if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        return any(address in network for network in self._proxies)


def defer_silent(listener: socket.socket) -> None:
    """Let the system keep connections to itself until the other side has sent something.

    Over TLS and HTTP whoever connects speaks first, so nobody waits longer for it; where the system
    cannot (it is Linux's), those who say nothing are only bounded.
    """
    if (option := getattr(socket, "TCP_DEFER_ACCEPT", None)) is not None:
        listener.setsockopt(socket.IPPROTO_TCP, option, _DEFERRED_S)


def network_of(address: str) -> str:
    """Give what an address is counted by: of IPv6 the network, since anyone has many addresses."""
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv6Address) and parsed.ipv4_mapped is None:
        # Not strict: the bits behind the prefix are simply left out.
        return str(ipaddress.ip_network((parsed, _PREFIX), strict=False))
    return address
