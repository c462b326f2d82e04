"""Whose word about the real asker is believed: that of the listed reverse proxies only. Pure."""

from __future__ import annotations

import ipaddress
from typing import TYPE_CHECKING

from starlette.datastructures import Headers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from starlette.types import Scope

    from talaia.hub.settings import Network

__all__ = ["Proxies"]

# A proxy that ends TLS speaks to us in the clear; never the other way round.
_SECURE = {"http": "https", "ws": "wss", "https": "https", "wss": "wss"}


class Proxies:
    """Looks through the proxies that the settings list."""

    def __init__(self, networks: Sequence[Network]) -> None:
        """Believe peers of these networks; without any, nobody."""
        # Of the settings; fixed while the hub runs.
        self._networks = tuple(networks)

    def look_through(self, scope: Scope) -> Scope:
        """Give the request as the proxy got it: the asker's address, and whether it was TLS."""
        peer = scope["client"][0] if scope.get("client") else ""
        if not self._networks or not self._is_listed(peer):
            return scope
        headers = Headers(scope=scope)
        # A copy: the server still uses its own.
        seen = dict(scope)
        # Each proxy appends whom it saw. From the right, the first that is none of ours is as far
        # as anybody's word can be believed.
        hops = [hop.strip() for hop in ",".join(headers.getlist("x-forwarded-for")).split(",")]
        for hop in reversed(hops):
            address = _address_of_hop(hop)
            if not address:
                break
            # The port is not told, and nobody asks for it.
            seen["client"] = (address, 0)
            if not self._is_listed(address):
                break
        if headers.get("x-forwarded-proto", "").strip().lower() in {"https", "wss"}:
            seen["scheme"] = _SECURE[scope["scheme"]]
        return seen

    def _is_listed(self, text: str) -> bool:
        try:
            address = ipaddress.ip_address(text)
        except ValueError:
            return False
        # So a socket that listens on :: shows a peer of IPv4.
        if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        return any(address in network for network in self._networks)


def _address_of_hop(hop: str) -> str:
    """Read an entry, which may have a port; empty when it is no address."""
    text = hop[1:].split("]", 1)[0] if hop.startswith("[") else hop
    # One colon parts a port from an IPv4 address; an IPv6 address has two at least.
    if text.count(":") == 1:
        text = text.split(":", 1)[0]
    try:
        return str(ipaddress.ip_address(text))
    except ValueError:
        return ""
