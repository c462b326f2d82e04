"""How much room the history takes, and how long it will last."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.storage import StoragePages
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.ports import History

__all__ = ["StorageFeature"]


class StorageFeature(Feature):
    """Sizes and forecasts for those who manage the hub."""

    name = "storage"

    def __init__(self, core: Core, *, history: History) -> None:
        """Answer from ``history``."""
        pages = StoragePages(history=history, sites=core.sites, clock=core.clock)
        self.routers = [pages.make_router()]
