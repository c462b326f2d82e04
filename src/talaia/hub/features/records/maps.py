"""Maps: files of the administrator's folder, and tile servers that an admin allowed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.maps.google_sessions import GoogleSessions
from talaia.hub.api.maps.map_pages import MapPages
from talaia.hub.features.feature import Feature
from talaia.hub.store.sites.map_sources import MapSources

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["MapsFeature"]


class MapsFeature(Feature):
    """The ground under the robots.

    Attributes:
        sources: tile servers; the Content-Security-Policy of all pages goes by them.

    """

    name = "maps"

    def __init__(self, core: Core, *, audit: Audit) -> None:
        """Keep what admins allowed in the hub's database."""
        self.sources = MapSources(core.database, core.clock, core.secret_box)
        pages = MapPages(
            folder=core.settings.maps,
            sources=self.sources,
            sessions=GoogleSessions(core.clock),
            audit=audit,
        )
        self.routers = [pages.make_router()]

    async def open(self) -> None:
        """Read what is allowed, before the first page is given out."""
        await self.sources.list_sources()
