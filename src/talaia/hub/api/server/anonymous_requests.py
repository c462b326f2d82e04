"""Requests of each address that nobody has signed, while they are being sent and answered.

Whoever sends a request slowly holds a place in memory; behind a proxy many share one connection,
so this is by the address that the proxy tells.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from talaia.hub.api.server.silent_connections import network_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

__all__ = ["MOST_ANONYMOUS", "AnonymousRequests"]

# Of one address at once: pages of a whole school that load before anybody signs in.
MOST_ANONYMOUS = 128


class AnonymousRequests:
    """How many of each address are open."""

    def __init__(self, most: int = MOST_ANONYMOUS) -> None:
        """Let ``most`` of one address be open at once."""
        self._most = most
        self._open: dict[str, int] = {}

    @contextmanager
    def count(self, address: str, headers: Mapping[str, str], *, unasked: bool) -> Iterator[bool]:
        """Count a request while it is open; gives False when it is one too many.

        ``unasked``: nobody is asked there who they are before what they send is read.
        """
        # Elsewhere a cookie or a token is looked up before any body is read, and a made-up one is
        # refused; where nobody looks, it says nothing.
        if not unasked and ("cookie" in headers or "authorization" in headers):
            yield True
            return
        key = network_of(address)
        many = self._open.get(key, 0)
        if many >= self._most:
            yield False
            return
        self._open[key] = many + 1
        try:
            yield True
        finally:
            # Forgotten at none, or addresses would gather for as long as the hub runs.
            left = self._open[key] - 1
            if left:
                self._open[key] = left
            else:
                del self._open[key]
