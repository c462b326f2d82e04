"""Who may open a WebSocket, and how many at once."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from talaia.hub.api.access import deny_socket
from talaia.hub.api.rate_limits import MOST_SOCKETS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from starlette.websockets import WebSocket

    from talaia.hub.api.access import Access
    from talaia.hub.api.rate_limits import RateLimits
    from talaia.hub.api.sockets.gateway_admission import GatewayAdmission
    from talaia.hub.auth.permissions import Who

__all__ = ["SocketAdmission", "speaks_json"]


class SocketAdmission:
    """Lets sockets in, or sends them away before the upgrade.

    Attributes:
        gateways: lets those of gateways in.

    """

    def __init__(self, *, access: Access, gateways: GatewayAdmission, limits: RateLimits) -> None:
        """Know who asks by ``access``; ``limits`` counts the sockets of each person.

        ``gateways`` knows those of gateways.
        """
        self._access = access
        self.gateways = gateways
        self._limits = limits

    @asynccontextmanager
    async def admit_person(self, socket: WebSocket) -> AsyncIterator[Who | None]:
        """Give who opens a socket, and count it while it is open; None: they were sent away."""
        who = await self._access.admit_socket(socket)
        if who is None:
            yield None
            return
        # Counted for as long as the caller serves it.
        with self._limits.count_socket(who) as allowed:
            if not allowed:
                message = f"at most {MOST_SOCKETS} connections at once; close some pages"
                await deny_socket(socket, status=429, code="busy", message=message)
            yield who if allowed else None


def speaks_json(socket: WebSocket) -> bool:
    """Tell whether a page asked for JSON instead of MessagePack."""
    return socket.query_params.get("form") == "json"
