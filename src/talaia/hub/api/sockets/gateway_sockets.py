"""A WebSocket of a gateway, which shows its key before it is let in."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from fastapi import APIRouter, WebSocket

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.store.sites.site_registry import GatewayKey

__all__ = ["GatewaySocket"]


class ServesGateways(Protocol):
    """A part that speaks with gateways over sockets of one kind."""

    async def serve_socket(self, socket: WebSocket, key: GatewayKey) -> None:
        """Speak with the gateway of ``key`` until either side ends it."""
        ...


class GatewaySocket:
    """The route of one kind of socket: the link, pictures, or files."""

    def __init__(self, path: str, *, admission: SocketAdmission, server: ServesGateways) -> None:
        """Hand those whose key is good to ``server``."""
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
        key = await self._admission.admit_gateway(socket)
        if key is not None:
            await socket.accept()
            await self._server.serve_socket(socket, key)
