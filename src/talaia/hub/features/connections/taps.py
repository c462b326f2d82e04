"""Raw topics of robots: which there are. `Core.taps` hands them to those who take them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sites.topics import TopicPages
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core

__all__ = ["TapsFeature"]


class TapsFeature(Feature):
    """Lists topics to people."""

    name = "taps"

    def __init__(self, core: Core) -> None:
        """List what gateways have told."""
        self.routers = [TopicPages(core.taps).router()]
