"""Parts that other packages bring to the hub, for the page of those who manage it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.server.extensions import ExtensionPages
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core

__all__ = ["ExtensionsFeature"]


class ExtensionsFeature(Feature):
    """Lists what is installed beside the hub, and what of it is broken."""

    name = "extensions"

    def __init__(self, core: Core) -> None:
        """Answer from what is installed."""
        self.routers = [ExtensionPages().router()]
