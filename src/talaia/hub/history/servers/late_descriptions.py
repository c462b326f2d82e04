"""Descriptions of sites, and those that their server was not there to be told of."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING

from talaia.hub.history.errors import HistoryError
from talaia.hub.store.history_servers.home_tables import OWN

if TYPE_CHECKING:
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.history.store import HistoryStore
    from talaia.model.site import Site

__all__ = ["LateDescriptions"]

# A server that stands still is waited for so long (s).
_PATIENCE_S = 3.0


class LateDescriptions:
    """Describes each site where its history is; what cannot be told now is told later."""

    def __init__(self, places: SitePlaces) -> None:
        """Know none."""
        self._places = places
        # The last one of each site, and of which the server was away when it came.
        self._described: dict[str, Site] = {}
        self._late: set[str] = set()

    async def describe_site(self, site: Site) -> None:
        """Describe a site to its server, now or later."""
        self._described[site.site] = site
        if self._places.is_held(site.site):
            # A gateway that comes within a move is not kept waiting for it.
            self._late.add(site.site)
            return
        async with self._places.describing_turn(site.site):
            home = await self._places.find_home(site.site)
            if home == OWN:
                await self._places.store_named(OWN).describe_site(site)
                return
            try:
                async with asyncio.timeout(_PATIENCE_S):
                    await self._places.store_named(home).describe_site(site)
            except (HistoryError, TimeoutError):
                self._late.add(site.site)

    async def describe_late(self, server: str) -> None:
        """Describe to a server what came while it was away."""
        for site in sorted(self._late):
            if self._places.is_held(site):
                continue
            store = self._places.opened_store(site)
            if self._places.home_of.get(site, OWN) != server or store is None or store.trouble:
                continue
            with contextlib.suppress(HistoryError, TimeoutError):
                async with self._places.describing_turn(site), asyncio.timeout(_PATIENCE_S):
                    await self._places.store_of(site).describe_site(self._described[site])
                self._late.discard(site)

    async def describe_moved(self, site: str, store: HistoryStore) -> None:
        """Describe a site to where it moves, as it was described last."""
        described = self._described.get(site)
        if described is not None:
            await store.describe_site(described)
