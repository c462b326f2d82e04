"""Scripts that drive, each by a socket of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.catalog import SCRIPTS
from talaia.hub.clients.scripts.session import ScriptSession
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature

__all__ = ["ScriptsFeature"]


class ScriptsFeature(Feature):
    """One socket for each site, under ``/clients/scripts/``."""

    name = "scripts"

    def __init__(self, *, clients: ClientProtocolsFeature) -> None:
        """Let scripts in by what ``clients`` knows."""
        self.sockets = [clients.serve_sockets(SCRIPTS, begin=ScriptSession).router()]
