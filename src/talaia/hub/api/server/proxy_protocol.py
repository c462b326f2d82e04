"""Who comes through a load balancer that lets TLS pass: the PROXY protocol, version 2.

Such a balancer can put no header into a request that it cannot read; it says before the TLS
handshake from which address the connection comes. Only the word of listed ones is believed.
"""

from __future__ import annotations

import ipaddress
import struct
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    import asyncio
    import socket
    from collections.abc import Sequence

    from talaia.hub.settings import Network

__all__ = ["Asker", "Balancers", "KnowsAsker", "NoProxyHeader", "read_asker", "receive_asker"]

Asker = tuple[str, int]
# "The PROXY protocol", 2.2: a signature, version and command, family, and how much follows.
_SIGNATURE = b"\r\n\r\n\0\r\nQUIT\n"
_HEAD = struct.Struct("!12sBBH")
_LOCAL, _PROXY = 0x20, 0x21
_TCP4, _TCP6 = 0x11, 0x21
_ADDRESSES4, _ADDRESSES6 = struct.Struct("!4s4sHH"), struct.Struct("!16s16sHH")
# Addresses and what a balancer may say besides, like the name that TLS asks for.
_MOST_BYTES = 2_048


class NoProxyHeader(ConnectionError):
    """A balancer does not say who comes; the connection is worth nothing."""


@runtime_checkable
class KnowsAsker(Protocol):
    """A connection's protocol that takes another address than its socket's for the asker's."""

    asker: Asker | None


class Balancers:
    """The load balancers whose word is believed."""

    def __init__(self, networks: Sequence[Network] = ()) -> None:
        """Believe those of ``networks``; without any, nobody."""
        self._networks = tuple(networks)

    def is_listed(self, text: str) -> bool:
        """Tell whether a connection from this address begins with who really comes."""
        if not self._networks:
            return False
        try:
            address = ipaddress.ip_address(text)
        except ValueError:
            return False
        # So a socket that listens on :: shows a peer of IPv4.
        if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        return any(address in network for network in self._networks)


async def receive_asker(loop: asyncio.AbstractEventLoop, connection: socket.socket) -> Asker | None:
    """Read what a balancer says first, and nothing of what comes after.

    Returns:
        The asker's address; none where the balancer itself asks, or does not know.

    Raises:
        NoProxyHeader: it says something else.
        OSError: the connection is lost.

    """
    head = await _receive_bytes(loop, connection, _HEAD.size)
    signature, _, _, size = _HEAD.unpack(head)
    if signature != _SIGNATURE or size > _MOST_BYTES:
        raise NoProxyHeader("a load balancer does not speak the PROXY protocol, version 2")
    return read_asker(head, await _receive_bytes(loop, connection, size))


def read_asker(head: bytes, body: bytes) -> Asker | None:
    """Give the address in a header whose signature is good.

    Raises:
        NoProxyHeader: it is of another version, or too short.

    """
    _, command, family, _ = _HEAD.unpack(head)
    if command not in {_LOCAL, _PROXY}:
        raise NoProxyHeader(f"a PROXY header has version and command {command:#x}")
    layout = {_TCP4: _ADDRESSES4, _TCP6: _ADDRESSES6}.get(family)
    # Its own health check, or a way to connect that has no address.
    if command == _LOCAL or layout is None:
        return None
    if len(body) < layout.size:
        raise NoProxyHeader("a PROXY header is too short for its addresses")
    source, _, port, _ = layout.unpack_from(body)
    return str(ipaddress.ip_address(source)), port


async def _receive_bytes(
    loop: asyncio.AbstractEventLoop, connection: socket.socket, size: int
) -> bytes:
    received = b""
    while len(received) < size:
        # Never more: what follows is TLS's.
        piece = await loop.sock_recv(connection, size - len(received))
        if not piece:
            raise NoProxyHeader("a load balancer hung up before it said who comes")
        received += piece
    return received
