"""The hub as a Foxglove WebSocket server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.catalog import FOXGLOVE
from talaia.hub.clients.client_cameras import ClientCameras
from talaia.hub.clients.foxglove.session import FoxgloveSession
from talaia.hub.features.feature import Feature
from talaia.wire.foxglove.codec import SUBPROTOCOLS

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.live.pictures.picture_fanout import PictureFanout

__all__ = ["FoxgloveFeature"]


class FoxgloveFeature(Feature):
    """One socket for each site, under ``/clients/foxglove/``."""

    name = "foxglove"

    def __init__(
        self, core: Core, *, clients: ClientProtocolsFeature, streams: PictureFanout
    ) -> None:
        """Let clients in by what ``clients`` knows; pictures come from ``streams``."""
        self._core = core
        self._streams = streams
        # Both names of the protocol carry the same messages.
        sockets = clients.serve_sockets(FOXGLOVE, begin=self._begin, subprotocols=SUBPROTOCOLS)
        self.sockets = [sockets.router()]

    def _begin(self, socket: WebSocket, connection: ClientConnection) -> FoxgloveSession:
        site = connection.live.name
        # Each client looks for itself, at the pace of its own line.
        cameras = ClientCameras(self._streams, self._core.clock, connection.who, site)
        return FoxgloveSession(socket, connection, taps=self._core.taps, cameras=cameras)
