"""The hub as a Foxglove WebSocket server."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.hub.clients.catalog import FOXGLOVE
from talaia.hub.clients.foxglove.session import FoxgloveSession
from talaia.hub.features.feature import Feature
from talaia.wire.foxglove.codec import SUBPROTOCOLS

if TYPE_CHECKING:
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core

__all__ = ["FoxgloveFeature"]


class FoxgloveFeature(Feature):
    """One socket for each site, under ``/clients/foxglove/``."""

    name = "foxglove"

    def __init__(self, core: Core, *, clients: ClientProtocolsFeature) -> None:
        """Let clients in by what ``clients`` knows."""
        begin = partial(FoxgloveSession, taps=core.taps)
        # Both names of the protocol carry the same messages.
        sockets = clients.serve_sockets(FOXGLOVE, begin=begin, subprotocols=SUBPROTOCOLS)
        self.sockets = [sockets.router()]
