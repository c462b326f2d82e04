"""At which addresses a network camera may be. Pure.

A gateway stands inside a network that others cannot reach; whoever writes a camera's address must
not get to what only the gateway can reach. Cameras are on private networks, so those are fine.
What is no place for a camera is refused: this computer itself (unless the connection says so),
link-local addresses with a cloud's metadata among them, multicast, and what is nobody's address.
"""

from __future__ import annotations

import ipaddress

__all__ = ["NO_ADDRESS", "remedy_for", "why_no_camera"]

Address = ipaddress.IPv4Address | ipaddress.IPv6Address

NO_ADDRESS = "which is no IP address"
_HERE = "which is this computer itself"
# Those of clouds that are not link-local: AWS over IPv6, Alibaba, Azure, Oracle.
_METADATA = frozenset(
    ipaddress.ip_address(address)
    for address in ("fd00:ec2::254", "100.100.100.200", "168.63.129.16", "192.0.0.192")
)
# RFC 6052: IPv4 addresses behind a translator.
_NAT64 = ipaddress.ip_network("64:ff9b::/96")
# RFC 4291, 2.5.5.1: IPv4-compatible addresses, which nobody should use any more.
_COMPATIBLE = ipaddress.ip_network("::/96")
# RFC 1122, 3.2.1.3: this host on this network; systems take all of it for themselves.
_NOBODY = ipaddress.ip_network("0.0.0.0/8")


def why_no_camera(text: str, *, here: bool = False) -> str:
    """Tell why a camera may not be at an IP address; empty if it may.

    Args:
        text: the address as numbers, with or without a zone (``fe80::1%eth0``).
        here: cameras may be on this computer.

    """
    try:
        address = _unmap_ipv4(ipaddress.ip_address(text.partition("%")[0]))
    except ValueError:
        return NO_ADDRESS
    why = ""
    if address.is_loopback:
        why = "" if here else _HERE
    elif address.is_unspecified or (address.version == 4 and address in _NOBODY):
        why = "which is nobody's address"
    # 169.254.169.254 is link-local as well, but so it is told why.
    elif address in _METADATA or str(address) == "169.254.169.254":
        why = "where clouds keep their metadata"
    elif address.is_link_local:
        why = "which is a link-local address"
    elif address.is_multicast:
        why = "which is a multicast address"
    elif address.is_reserved:
        why = "which is a reserved address"
    return why


def remedy_for(why: str) -> str:
    """Tell what to write instead."""
    if why == _HERE:
        return "write here: true at the connection if the camera's server runs on this computer"
    return "write the camera's own address"


def _unmap_ipv4(address: Address) -> Address:
    """Give the IPv4 address that is written as an IPv6 one."""
    # ``::1`` and ``::`` lie in the compatible block, and mean no IPv4 address.
    if isinstance(address, ipaddress.IPv4Address) or address.is_loopback or address.is_unspecified:
        return address
    # Of Teredo it is the client, the second of the two, that is reached.
    inner = address.ipv4_mapped or address.sixtofour or (address.teredo or (None, None))[1]
    if inner is None and (address in _NAT64 or address in _COMPATIBLE):
        inner = ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
    return inner or address
