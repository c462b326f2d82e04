"""Which shards there are. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.hub.store.dialects.lead_words import MAIN_SHARD
from talaia.hub.store.history_servers.own_rows import every_row

if TYPE_CHECKING:
    from collections.abc import Mapping

    from sqlalchemy import ColumnElement

__all__ = ["MAIN", "ShardPlan", "WholeShard"]

# The shard that has the accounts, and every site that no other shard has; as locks name it.
MAIN = MAIN_SHARD


class ShardPlan(NamedTuple):
    """Which shards there are besides the main one.

    A shard is a history server with a lead of its own: it has the sites whose history is there.

    Attributes:
        names: of history servers, in the order of the settings; empty: one lead has all sites.

    """

    names: tuple[str, ...] = ()

    @property
    def all_names(self) -> tuple[str, ...]:
        """Name every shard, the main one first."""
        return (MAIN, *self.names)

    def shard_of_server(self, server: str) -> str:
        """Name the shard that has the sites whose history is on ``server``."""
        return server if server in self.names else MAIN

    def shard_of(self, site: str, server_of: Mapping[str, str]) -> str:
        """Name the shard of a site, by the servers of all sites whose history is elsewhere."""
        return self.shard_of_server(server_of.get(site, ""))


class WholeShard:
    """The shard of a hub whose sites are not divided: it has all of them."""

    name = MAIN
    is_main = True
    is_whole = True
    suffix = ""

    async def open(self) -> None:
        """Do nothing: there is nothing to know."""

    def has_site(self, site: str) -> bool:
        """Tell that it has the site."""
        return True

    async def look_up(self, site: str) -> bool:
        """Tell that it has the site."""
        return True

    async def refresh(self) -> None:
        """Do nothing: there is nothing to know."""

    def own_rows(self, site: ColumnElement[Any], /) -> tuple[ColumnElement[bool], ...]:
        """Leave no row out."""
        return every_row(site)
