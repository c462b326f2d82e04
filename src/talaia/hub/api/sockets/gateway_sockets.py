"""A WebSocket of a gateway, which shows its key before it is let in."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

from fastapi import APIRouter, WebSocket

from talaia.hub.api.access import deny_socket

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.live.gateways.flood_guard import FloodGuard
    from talaia.hub.store.sites.site_registry import GatewayKey

__all__ = ["GatewaySocket"]


class ServesGateways(Protocol):
    """A part that speaks with gateways over sockets of one kind."""

    async def serve_socket(self, socket: WebSocket, key: GatewayKey) -> None:
        """Speak with the gateway of ``key`` until either side ends it."""
        ...


class GatewaySocket:
    """The route of one kind of socket: the link, pictures, or files."""

    def __init__(
        self,
        path: str,
        *,
        admission: SocketAdmission,
        flood_guard: FloodGuard,
        server: ServesGateways,
    ) -> None:
        """Hand those whose key is good to ``server``, if they do not come too often."""
        self._flood_guard = flood_guard
        self._path = path
        self._admission = admission
        self._server = server

    def router(self) -> APIRouter:
        """Give the socket's route."""
        router = APIRouter()
        router.websocket(self._path)(self.serve)
        return router

    async def serve(self, socket: WebSocket) -> None:
        """Serve a gateway, or send it away."""
        key = await self._admission.gateways.admit_gateway(socket)
        # It was told why, and what to answer next.
        if key is None:
            return
        # Before the upgrade: whoever dials without end is to cost no socket.
        if after_s := self._flood_guard.admit_dial(key):
            said = "this gateway connects too often; come back later"
            await deny_socket(
                socket, status=503, code="busy", message=said, retry_s=math.ceil(after_s)
            )
        else:
            await self._admission.gateways.accept_socket(socket, key)
            await self._server.serve_socket(socket, key)
