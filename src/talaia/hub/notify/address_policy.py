"""Which addresses a message may go to. Pure.

A hub stands inside a network that others cannot reach; whoever names a server for it to speak to
must not get to what only the hub can reach. So an address must be a public one, unless whoever
runs the hub has named its network (``--notify-network``).
"""

from __future__ import annotations

import ipaddress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["AddressRefused", "may_reach"]

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network

# RFC 6052: the last 32 bits are an IPv4 address, which a NAT64 would reach for us.
_NAT64 = ipaddress.ip_network("64:ff9b::/96")


class AddressRefused(OSError):
    """A name leads to an address that messages may not go to."""

    def __init__(self, host: str, address: str) -> None:
        """Say which, and what to do."""
        said = f"{host} is" if host == address else f"{host} is {address},"
        super().__init__(
            f"{said} no public address; "
            "start the hub with --notify-network for its network if that is meant"
        )


def may_reach(text: str, networks: Iterable[Network]) -> bool:
    """Tell whether an IP address may be spoken to; one that cannot be read may not."""
    try:
        # Without its scope (``fe80::1%eth0``).
        address = _unmap_ipv4(ipaddress.ip_address(text.partition("%")[0]))
    except ValueError:
        return False
    if any(address.version == network.version and address in network for network in networks):
        return True
    # Some groups of multicast count as global, and a machine of this network could answer.
    return address.is_global and not address.is_multicast


def _unmap_ipv4(address: Address) -> Address:
    """Give the IPv4 address that is written as an IPv6 one."""
    if isinstance(address, ipaddress.IPv4Address):
        return address
    # Teredo gives server and client; the client is who would be reached.
    inner = address.ipv4_mapped or address.sixtofour or (address.teredo or (None, None))[1]
    if inner is None and address in _NAT64:
        inner = ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
    return inner or address
