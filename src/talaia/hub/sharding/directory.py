"""Which shard a request is for: every hub asks the accounts' database itself, whoever leads."""

from __future__ import annotations

import asyncio
import logging
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import func, select

from talaia.hub.auth.tokens import hash_token
from talaia.hub.errors import StoreDown
from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.history_servers.home_tables import OWN, history_homes
from talaia.hub.store.sites.shared_lookup import SharedLookup
from talaia.hub.store.tables import gateways, sites

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from sqlalchemy import ColumnElement

    from talaia.hub.sharding.plan import ShardPlan
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.history_homes import HistoryHomes
    from talaia.hub.store.sites.site_registry import SiteRegistry

__all__ = ["ShardDirectory"]

_LOG = logging.getLogger(__name__)

# That a site has no place yet holds so long (s): it may get one at any hub.
_UNPLACED_S = 1.0
# Between two looks for sites that have changed their shard (s).
_LOOK_S = 0.5
_MOST_UNPLACED = 1_000
_MOST_KEYS = 10_000
# Names in one query; more would be more parameters than some engines take.
_AT_ONCE = 500


class _Placed(NamedTuple):
    """Where a site is; ``turn`` tells which of two is newer."""

    shard: str
    turn: int


class ShardDirectory:
    """Tells the shard of a site; what it has found holds until the site changes its shard.

    That it has is seen by `run`. It reads by connections of its own, which need no lead.
    """

    def __init__(
        self,
        database: Database,
        homes: HistoryHomes,
        plan: ShardPlan,
        first_home: Callable[[str, Mapping[str, int]], str],
        *,
        registry: SiteRegistry,
    ) -> None:
        """Ask ``database``; ``first_home`` chooses the server of a new site by what each has.

        ``registry`` knows the keys and numbers of gateways.
        """
        self._database = database
        self._registry = registry
        self._homes = homes
        self._plan = plan
        self._first_home = first_home
        self._shards: dict[str, _Placed] = {}
        # The last change of a shard that was read.
        self._turn = 0
        # By site: when it was without a place (monotonic, s).
        self._unplaced: dict[str, float] = {}
        # Gateways of thousands of sites may come at once.
        self._asking = SharedLookup(self._fetch_servers)
        self._stored = SharedLookup(self._fetch_stored)
        # By hash: whose key it is, of gateways that say their key.
        self._sites_of_keys: dict[str, str] = {}

    def known_shard(self, site: str) -> str | None:
        """Give the shard of a site that was asked about before; None: it has to be looked up."""
        placed = self._shards.get(site)
        if placed is not None:
            return placed.shard
        if time.monotonic() - self._unplaced.get(site, -1e9) < _UNPLACED_S:
            return MAIN
        return None

    async def find_shard(self, site: str) -> str:
        """Give the shard of a site; the main one, while it has no place of its own.

        Raises:
            StoreDown: the database does not answer, and the site was not asked about before.

        """
        shard = self.known_shard(site)
        if shard is not None:
            return shard
        found = await self._asking.look_up(site)
        if found is not None:
            return self._place(site, *found)
        if len(self._unplaced) >= _MOST_UNPLACED:
            self._unplaced.clear()
        self._unplaced[site] = time.monotonic()
        return MAIN

    async def place_site(self, site: str) -> str:
        """Give the shard of a site whose gateway comes; one that is new gets its place by this.

        Raises:
            StoreDown: the database does not answer, and the site was not asked about before.

        """
        placed = self._shards.get(site)
        if placed is not None:
            return placed.shard
        # Not by what is remembered of a site without a place: it may have one by now.
        self._unplaced.pop(site, None)
        shard = await self.find_shard(site)
        if site in self._shards:
            return shard
        if await self._stored.look_up(site):
            # Of before sites were divided: its history is in the main database, and stays there.
            return self._place(site, OWN, 0)
        if not await self._registry.keys_of_site(site):
            return MAIN
        server = self._first_home(site, await self._count_sites())
        # One of the main shard, too, or another hub might place it elsewhere meanwhile. Another hub
        # may have been quicker: what stands then counts.
        home = await self._homes.add_home(site, server)
        return self._place(site, home.server, home.turn)

    async def find_site_of_key(self, key: str) -> str | None:
        """Give the site of a gateway that says its key; None: there is no such key.

        Raises:
            StoreDown: the database does not answer.

        """
        hashed = hash_token(key)
        known = self._sites_of_keys.get(hashed)
        if known is not None:
            return known
        # Void ones, too: they are sent away where the site is.
        query = select(gateways.c.site).where(gateways.c.key_hash == hashed)
        found = await self._database.fetch_scalars(query)
        if not found:
            return None
        if len(self._sites_of_keys) >= _MOST_KEYS:
            self._sites_of_keys.clear()
        site = self._sites_of_keys[hashed] = str(found[0])
        return site

    async def find_site_of_gateway(self, number: int) -> str | None:
        """Give the site of a gateway by its number; None: there is none.

        Raises:
            StoreDown: the database does not answer.

        """
        found = await self._registry.find_gateway(number)
        return None if found is None else found.site

    async def run(self) -> None:
        """Follow sites that change their shard, until cancelled."""
        while True:
            await asyncio.sleep(_LOOK_S)
            try:
                await self.refresh()
            except StoreDown as error:
                # Whoever looks something up is told.
                _LOG.debug("sites are led where they were: %s", error)

    async def refresh(self) -> None:
        """Read which sites have changed their shard.

        Raises:
            StoreDown: the database does not answer.

        """
        columns = (history_homes.c.site, history_homes.c.server, history_homes.c.turn)
        query = select(*columns).where(history_homes.c.turn > self._turn)
        async with self._database.read() as connection:
            rows = (await connection.execute(query)).all()
        for row in rows:
            self._place(row.site, row.server, row.turn)
            self._turn = max(self._turn, row.turn)

    def _place(self, site: str, server: str, turn: int) -> str:
        """Remember where a site is, unless something newer is known; give its shard."""
        known = self._shards.get(site)
        # A look-up may be older than what was told of a change meanwhile.
        if known is None or known.turn <= turn:
            known = self._shards[site] = _Placed(self._plan.shard_of_server(server), turn)
        self._unplaced.pop(site, None)
        return known.shard

    async def _count_sites(self) -> dict[str, int]:
        query = select(history_homes.c.server, func.count()).group_by(history_homes.c.server)
        async with self._database.read() as connection:
            rows = (await connection.execute(query)).all()
        return {row[0]: row[1] for row in rows}

    async def _fetch_servers(self, names: Collection[str]) -> dict[str, tuple[str, int]]:
        columns = (history_homes.c.site, history_homes.c.server, history_homes.c.turn)
        rows = await self._fetch_rows(columns, names)
        return {row.site: (row.server, int(row.turn)) for row in rows}

    async def _fetch_stored(self, names: Collection[str]) -> dict[str, bool]:
        return {row.site: True for row in await self._fetch_rows((sites.c.site,), names)}

    async def _fetch_rows(
        self, columns: Sequence[ColumnElement[Any]], names: Collection[str]
    ) -> list[Any]:
        """Give rows of some sites; the first column is the site's name."""
        asked, found = list(names), list[Any]()
        async with self._database.read() as connection:
            for first in range(0, len(asked), _AT_ONCE):
                some = select(*columns).where(columns[0].in_(asked[first : first + _AT_ONCE]))
                found += (await connection.execute(some)).all()
        return found
