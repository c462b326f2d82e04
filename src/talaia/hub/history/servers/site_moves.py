"""All moves that were asked for: those that this hub can do, one after the other."""

from __future__ import annotations

import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.hub.errors import HubError
from talaia.hub.history.servers.site_move import SiteMove

if TYPE_CHECKING:
    from talaia.hub.history.servers.late_descriptions import LateDescriptions
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes

__all__ = ["SiteMoves"]

_LOG = logging.getLogger(__name__)


class SiteMoves:
    """Moves sites between the servers that this hub has."""

    def __init__(
        self, places: SitePlaces, descriptions: LateDescriptions, homes: HistoryHomes
    ) -> None:
        """Move what ``homes`` say, between ``places``."""
        self._places, self._descriptions, self._homes = places, descriptions, homes

    async def move_sites(self) -> None:
        """Go on with each move that was asked for, once; what fails is tried again later."""
        for home in await self._homes.list_homes():
            if not self._can_move(home):
                continue
            self.hold_retention(home)
            try:
                await SiteMove(self._places, self._descriptions, self._homes, home).run()
            except HubError as error:
                _LOG.warning("the history of %s waits to be moved: %s", home.site, error)
                with contextlib.suppress(HubError):
                    await self._homes.report_progress(home._replace(problem=str(error)))

    def hold_retention(self, home: HistoryHome) -> None:
        """Drop nothing of a site that is asked to move."""
        if home.moving_to:
            for store in self._places.open_stores():
                store.transfer.hold_retention(home.site, held=True)

    def _can_move(self, home: HistoryHome) -> bool:
        """Tell whether something is to be done, where all that it needs is this hub's."""
        # A site changes its shard only where no hub runs; what it leaves behind is erased by
        # whoever has that place.
        needed = [home.erase_at]
        if home.moving_to:
            needed += [home.server, home.moving_to]
        names = [name for name in needed if name]
        return bool(names) and all(map(self._places.has_server, names))
