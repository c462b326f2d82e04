"""Finds Alpaca servers by ASCOM's discovery, a broadcast over UDP. Blocks."""

from __future__ import annotations

import socket
import time
from typing import NamedTuple

from talaia.gateway.adapters.alpaca.protocol import parse_discovery

__all__ = ["DISCOVERY_PORT", "FoundServer", "search_servers"]

DISCOVERY_PORT = 32_227
_QUESTION = b"alpacadiscovery1"
# The network of the machine's first way out, and programs on the machine itself.
_BROADCASTS = ("255.255.255.255", "127.255.255.255")
_MOST = 100


class FoundServer(NamedTuple):
    """Where a server answers."""

    host: str
    port: int


def search_servers(seconds: float, *, at: int = DISCOVERY_PORT) -> list[FoundServer]:
    """Ask who is there.

    Args:
        seconds: how long to wait for answers (s).
        at: the port of the question.

    Raises:
        OSError: nothing can be sent.

    """
    found: dict[FoundServer, None] = {}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        line.bind(("", 0))
        sent = 0
        for address in _BROADCASTS:
            try:
                line.sendto(_QUESTION, (address, at))
            except OSError:
                # A machine without a network has the other one yet.
                continue
            sent += 1
        if not sent:
            raise OSError("no network takes a broadcast")
        until = time.monotonic() + seconds
        while len(found) < _MOST and (left := until - time.monotonic()) > 0:
            line.settimeout(left)
            try:
                data, (host, _) = line.recvfrom(1024)
            except TimeoutError:
                break
            port = parse_discovery(data)
            if port is not None:
                found[FoundServer(host, port)] = None
    return list(found)
