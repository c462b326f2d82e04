"""All moves that were asked for: those that this hub can do, one after the other."""

from __future__ import annotations

import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.hub.errors import HubError
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.servers.site_copy import SiteCopy
from talaia.hub.history.servers.site_move import SiteMove

if TYPE_CHECKING:
    from talaia.hub.history.servers.late_descriptions import LateDescriptions
    from talaia.hub.history.servers.shard_move import ShardArrivals
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes

__all__ = ["SiteMoves"]

_LOG = logging.getLogger(__name__)


class SiteMoves:
    """Moves sites between the servers that this hub has."""

    def __init__(
        self,
        places: SitePlaces,
        descriptions: LateDescriptions,
        homes: HistoryHomes,
        arrivals: ShardArrivals | None = None,
    ) -> None:
        """Move what ``homes`` say, between ``places``; by ``arrivals`` from other shards."""
        self._places, self._descriptions, self._homes = places, descriptions, homes
        self._arrivals = arrivals

    async def move_sites(self) -> None:
        """Go on with each move that was asked for, once; what fails is tried again later."""
        for home in await self._homes.list_homes():
            self.hold_retention(home)
            try:
                await self._go_on(home)
            except HubError as error:
                _LOG.warning("the history of %s waits to be moved: %s", home.site, error)
                with contextlib.suppress(HubError):
                    await self._homes.report_progress(home._replace(problem=str(error)))

    def hold_retention(self, home: HistoryHome) -> None:
        """Drop nothing of a site that is asked to move."""
        for store in self._places.open_stores():
            store.transfer.hold_retention(home.site, held=bool(home.moving_to))

    async def _go_on(self, home: HistoryHome) -> None:
        """Do what this lead can do of a move: where it has the places that it needs."""
        if home.led_by and self._arrivals is not None:
            # Two leads are about to close and to open again.
            return
        has = self._places.has_server
        comes, goes = has(home.moving_to), has(home.server)
        if home.moving_to and comes and goes:
            if home.erase_at and not has(home.erase_at):
                raise HistoryError(f"what was left at {home.erase_at!r} is to be erased before")
            await SiteMove(self._places, self._descriptions, self._homes, home).run()
        elif home.moving_to and comes and self._arrivals is not None:
            await self._arrivals.bring_site(home)
        elif home.erase_at and has(home.erase_at):
            await SiteCopy(self._places, self._descriptions, self._homes, home).erase_left()
