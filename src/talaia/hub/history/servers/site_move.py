"""A site's history goes from one server to another while it is written; one lead has both.

Blocks are copied while all goes on, until little is left. Then nothing of the site is written for
a moment: what is in memory is made blocks, the last are copied, and one commit in the accounts'
database says where the site is from now on. What was left behind is erased after it. Killed at any
point, it is taken up by what is written: up to that commit the old place has all, after it the new
one, and how far the copy has come stands in the same transaction as what was copied.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.history.servers.site_copy import GATE_S, SiteCopy

if TYPE_CHECKING:
    from talaia.hub.history.servers.late_descriptions import LateDescriptions
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes

__all__ = ["SiteMove"]


class SiteMove:
    """One move, from wherever the one before it ended."""

    def __init__(
        self,
        places: SitePlaces,
        descriptions: LateDescriptions,
        homes: HistoryHomes,
        home: HistoryHome,
    ) -> None:
        """Do what ``home`` says."""
        self._places = places
        self._copy = SiteCopy(places, descriptions, homes, home)

    async def run(self) -> None:
        """Move the site, and erase what is left behind.

        Raises:
            HistoryError: a server is away; it goes on later.
            StoreDown: the accounts' database is.

        """
        home = self._copy.home
        if home.erase_at and home.erase_at != home.moving_to:
            await self._copy.erase_left()
        if home.moving_to:
            await self._copy_and_switch()
            if self._copy.home.erase_at:
                await self._copy.erase_left()

    async def _copy_and_switch(self) -> None:
        copy, site = self._copy, self._copy.home.site
        source = self._places.store_named(copy.home.server)
        target = self._places.store_named(copy.home.moving_to)
        await copy.begin_copy(target)
        async with copy.explain_failures(target):
            await copy.copy_hot(source.transfer, target.transfer)
            # Of what is in memory the most becomes blocks before anybody waits.
            await source.transfer.seal_site(site)
            await copy.copy_more(source.transfer, target.transfer)
            async with self._places.hold_writes(site):
                async with asyncio.timeout(GATE_S):
                    await source.transfer.seal_all(site)
                    await copy.copy_rest(source.transfer, target)
                await copy.switch_home()
            await target.transfer.clear_copied(site)
