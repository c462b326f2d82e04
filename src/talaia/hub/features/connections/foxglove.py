"""The hub as a Foxglove WebSocket server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.catalog import FOXGLOVE
from talaia.hub.clients.client_cameras import ClientCameras
from talaia.hub.clients.foxglove.playback_position import read_window
from talaia.hub.clients.foxglove.playback_session import PlaybackSession
from talaia.hub.clients.foxglove.session import FoxgloveSession
from talaia.hub.features.feature import Feature
from talaia.wire.foxglove.codec import SDK_SUBPROTOCOL, SUBPROTOCOLS

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.hub.clients.client_connection import ClientConnection, ClientSession
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.ports import History

__all__ = ["FoxgloveFeature"]


class FoxgloveFeature(Feature):
    """One socket for each site, under ``/clients/foxglove/``."""

    name = "foxglove"

    def __init__(
        self,
        core: Core,
        *,
        clients: ClientProtocolsFeature,
        streams: PictureFanout,
        history: History,
        assets: RobotAssets,
    ) -> None:
        """Serve clients of one protocol.

        Args:
            core: of the hub.
            clients: lets them in.
            streams: where pictures come from.
            history: where the past comes from.
            assets: where files of robots come from.

        """
        self._core = core
        self._history = history
        self._assets = assets
        self._streams = streams
        # Both names of the protocol carry the same messages.
        sockets = clients.serve_sockets(FOXGLOVE, begin=self._begin, subprotocols=SUBPROTOCOLS)
        self.sockets = [sockets.router()]

    def _begin(self, socket: WebSocket, connection: ClientConnection) -> ClientSession:
        site, clock = connection.live.name, self._core.clock
        window = read_window(socket.query_params, clock.wall_ns() // 1000)
        if window is not None:
            # As the socket was accepted: the first that the client offers counts. The older one
            # has no word for playing, and would wait for ever.
            offered = [name for name in socket.scope["subprotocols"] if name in SUBPROTOCOLS]
            if offered[0] != SDK_SUBPROTOCOL:
                window = f"the past is played by {SDK_SUBPROTOCOL} alone, not by {offered[0]}"
            return PlaybackSession(
                socket, connection, window=window, history=self._history, clock=clock
            )
        # Each client looks for itself, at the pace of its own line.
        cameras = ClientCameras(self._streams, self._core.clock, connection.who, site)
        return FoxgloveSession(
            socket,
            connection,
            taps=self._core.taps,
            cameras=cameras,
            assets=self._assets,
            clock=clock,
        )
