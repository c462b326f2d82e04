"""How much room the history takes, and how long it will last."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.storage import StoragePages
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.files.ports import FileStore
    from talaia.hub.ports import History

__all__ = ["StorageFeature"]


class StorageFeature(Feature):
    """Sizes and forecasts for those who manage the hub."""

    name = "storage"

    def __init__(self, core: Core, *, history: History, files: FileStore) -> None:
        """Answer from ``history``, and say what is wrong with ``files``."""
        pages = StoragePages(history=history, files=files, sites=core.sites, clock=core.clock)
        self.routers = [pages.make_router()]
