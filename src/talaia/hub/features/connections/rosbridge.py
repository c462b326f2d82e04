"""The hub as a rosbridge server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.catalog import ROSBRIDGE
from talaia.hub.clients.rosbridge.session import RosbridgeSession
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core

__all__ = ["RosbridgeFeature"]


class RosbridgeFeature(Feature):
    """One socket for each site, under ``/clients/rosbridge/``."""

    name = "rosbridge"

    def __init__(self, core: Core, *, clients: ClientProtocolsFeature) -> None:
        """Let clients in by what ``clients`` knows."""

        def begin_session(socket: WebSocket, connection: ClientConnection) -> RosbridgeSession:
            return RosbridgeSession(socket, connection, taps=core.taps, clock=core.clock)

        self.sockets = [clients.serve_sockets(ROSBRIDGE, begin=begin_session).router()]
