"""The hubs that are one: what an admin sees of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.hubs.hub_pages import HubPages
from talaia.hub.features.feature import Feature
from talaia.hub.store.history_servers.history_homes import HistoryHomes

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.files.ports import FileStore

__all__ = ["HubsFeature"]


class HubsFeature(Feature):
    """Which hubs there are; of one that is alone, that it is."""

    name = "hubs"

    def __init__(self, core: Core, *, files: FileStore) -> None:
        """Answer by the seat of this hub among the others, if there are any.

        What is wrong with ``files`` is said there, too.
        """
        homes = HistoryHomes(core.database)
        pages = HubPages(core.seat, core.clock, files=files, sites=core.sites, homes=homes)
        self.routers = [pages.make_router()]
