"""The hub as a Socket.IO server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.clients.engine_sessions import EngineSessions
from talaia.hub.api.clients.socketio_routes import SocketioRoutes
from talaia.hub.clients.client_cameras import ClientCameras
from talaia.hub.clients.socketio.session import SocketioSession
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.engineio.engine_connection import EngineConnection
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.socketio.founding_words import ClientWishes
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.live.pictures.picture_fanout import PictureFanout

__all__ = ["SocketioFeature"]


class SocketioFeature(Feature):
    """Polled requests and a socket, both under ``/socket.io/``."""

    name = "socketio"

    def __init__(
        self, core: Core, *, clients: ClientProtocolsFeature, streams: PictureFanout
    ) -> None:
        """Let clients in by what ``clients`` knows; pictures come from ``streams``."""

        def begin_session(
            line: EngineConnection, connection: ClientConnection, wishes: ClientWishes
        ) -> SocketioSession:
            site = connection.live.name
            cameras = ClientCameras(streams, core.clock, connection.who, site)
            return SocketioSession(line, connection, cameras=cameras, wishes=wishes)

        self._sessions = EngineSessions(
            begin=begin_session,
            admission=clients.admission,
            connections=clients.connections,
            protocols=clients.protocols,
            audit=clients.audit,
            clock=core.clock,
        )
        routes = SocketioRoutes(admission=clients.admission, sessions=self._sessions)
        self.routers = [routes.router()]
        self.sockets = [routes.socket_router()]

    async def close(self) -> None:
        """End the sessions that are open: no request has to come for that."""
        await self._sessions.end_sessions()
