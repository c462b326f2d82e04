"""Which sites this hub's shard has, by the rows that say where histories are."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Any

from sqlalchemy import case, select

from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.history_servers.home_tables import NOBODY, history_homes

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement

    from talaia.hub.sharding.plan import ShardPlan
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes
    from talaia.hub.store.history_servers.shard_handover import ShardHandover

__all__ = ["OwnShard"]

_LOG = logging.getLogger(__name__)
# A site that comes from another shard is waited for so long, as this one begins: its lead closes
# meanwhile. One that takes longer is taken later (s).
_AWAITED_S = 5.0
_LOOK_S = 0.05
# The server by whose shard a site is led.
_leading = case(
    (history_homes.c.led_by == "", history_homes.c.server), else_=history_homes.c.led_by
)


class OwnShard:
    """One shard of several; see `talaia.hub.ports.Shard`.

    A site that has no row yet belongs to the main shard. It gets its row before its gateway is led
    anywhere. A shard takes a site over, or lets go of one, only as its lead begins: so whatever
    that lead has in memory is of sites that it has to its end.
    """

    is_whole = False

    def __init__(
        self, name: str, plan: ShardPlan, homes: HistoryHomes, handover: ShardHandover
    ) -> None:
        """Be the shard ``name`` of ``plan``; ``homes`` says which server has which site.

        By ``handover`` sites go to other shards, or come.
        """
        self.name = name
        self.is_main = name == MAIN
        self.suffix = "" if self.is_main else f"-{name}"
        self._plan = plan
        self._homes = homes
        self._handover = handover
        # By site: the shard, of those that have a row; empty: none has it just now.
        self._known: dict[str, str] = {}

    async def open(self) -> None:
        """Let go of sites that have moved away, take those that have come, and read whose all are.

        Raises:
            StoreDown: the database does not answer.

        """
        clock = asyncio.get_running_loop()
        until_s = clock.time() + _AWAITED_S
        while awaited := await self._handover.pass_on(self._has_server):
            if clock.time() > until_s:
                _LOG.warning("%s are taken later: their lead has not let go", ", ".join(awaited))
                break
            await asyncio.sleep(_LOOK_S)
        await self.refresh()

    async def refresh(self) -> None:
        """Read it again: other hubs write where new sites are.

        Raises:
            StoreDown: the database does not answer.

        """
        for home in await self._homes.list_homes():
            self._known[home.site] = self._shard_of(home)

    def has_site(self, site: str) -> bool:
        """Tell whether the site is of this shard, by what is known."""
        return self._known.get(site, MAIN) == self.name

    async def look_up(self, site: str) -> bool:
        """Tell whether the site is of this shard; asks the database about one that is new.

        Raises:
            StoreDown: the database does not answer.

        """
        if site not in self._known:
            home = await self._homes.find_home(site)
            if home is not None:
                self._known[site] = self._shard_of(home)
        return self.has_site(site)

    def own_rows(self, site: ColumnElement[Any], /) -> tuple[ColumnElement[bool], ...]:
        """Say in SQL which rows are of own sites; see `talaia.hub.ports.Shard`."""
        homes = select(history_homes.c.site)
        if self.is_main:
            return (site.not_in(homes.where(_leading.in_((NOBODY, *self._plan.names)))),)
        return (site.in_(homes.where(_leading == self.name)),)

    def _has_server(self, server: str) -> bool:
        return self._plan.shard_of_server(server) == self.name

    def _shard_of(self, home: HistoryHome) -> str:
        if home.led_by == NOBODY:
            return ""
        return self._plan.shard_of_server(home.led_by or home.server)
