"""Which sites this hub's shard has, by the rows that say where histories are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import select

from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.history_servers.home_tables import history_homes

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement

    from talaia.hub.sharding.plan import ShardPlan
    from talaia.hub.store.history_servers.history_homes import HistoryHomes

__all__ = ["OwnShard"]


class OwnShard:
    """One shard of several; see `talaia.hub.ports.Shard`.

    A site that has no row yet belongs to the main shard. It gets its row before its gateway is led
    anywhere, and does not change its shard while any hub runs.
    """

    is_whole = False

    def __init__(self, name: str, plan: ShardPlan, homes: HistoryHomes) -> None:
        """Be the shard ``name`` of ``plan``; ``homes`` says which server has which site."""
        self.name = name
        self.is_main = name == MAIN
        self.suffix = "" if self.is_main else f"-{name}"
        self._plan = plan
        self._homes = homes
        # By site: the shard, of those that have a row.
        self._known: dict[str, str] = {}

    async def open(self) -> None:
        """Read where all sites are.

        Raises:
            StoreDown: the database does not answer.

        """
        await self.refresh()

    async def refresh(self) -> None:
        """Read it again: other hubs write where new sites are.

        Raises:
            StoreDown: the database does not answer.

        """
        for home in await self._homes.list_homes():
            self._known[home.site] = self._plan.shard_of_server(home.server)

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
                self._known[site] = self._plan.shard_of_server(home.server)
        return self.has_site(site)

    def own_rows(self, site: ColumnElement[Any], /) -> tuple[ColumnElement[bool], ...]:
        """Say in SQL which rows are of own sites; see `talaia.hub.ports.Shard`."""
        homes = select(history_homes.c.site)
        if self.is_main:
            return (site.not_in(homes.where(history_homes.c.server.in_(self._plan.names))),)
        return (site.in_(homes.where(history_homes.c.server == self.name)),)
