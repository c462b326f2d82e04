"""The WebSocket of a page: values, commands, driving."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, WebSocket

from talaia.hub.api.sockets.socket_admission import speaks_json
from talaia.hub.live.pages.page_transport import SocketTransport

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.live.pages.page_service import PageService

__all__ = ["PageSockets"]


class PageSockets:
    """Serves the sockets of pages."""

    def __init__(self, *, admission: SocketAdmission, service: PageService) -> None:
        """Let pages in by ``admission``; ``service`` serves each."""
        self._admission = admission
        self._service = service

    def router(self) -> APIRouter:
        """Give the socket's route."""
        router = APIRouter()
        router.websocket("/ws")(self.serve)
        return router

    async def serve(self, socket: WebSocket) -> None:
        """Serve a page: values, commands, driving."""
        async with self._admission.admit_person(socket) as who:
            if who is not None:
                await socket.accept()
                transport = SocketTransport(
                    socket, text=speaks_json(socket), script=who.script, display=who.display
                )
                await self._service.serve(self._service.connect(transport, who))
