"""The same world with its sites divided: ``moon`` is of a shard, and all come by the router."""

from __future__ import annotations

import itertools
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.hub.sharding.directory import ShardDirectory
from talaia.hub.sharding.plan import MAIN
from talaia.hub.sharding.router import ShardRouter
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.sites.site_registry import SiteRegistry

from ..another_hub import AnotherHub
from ..conftest import RunningHub
from ..sharding.two_shards import EAST, PLAN, FakeSeat
from .world import World

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from talaia.hub.settings import Settings

OF_EAST = "moon"


class DividedWorld(World):
    """Two hubs of one database and one folder, and a third before them that leads whoever comes."""

    async def open_doors(self) -> None:
        settings = self.hub.settings
        self._east = await self._stack.enter_async_context(
            RunningHub(settings, None, seat=FakeSeat(EAST))
        )
        database = Database(settings.url)
        self._stack.push_async_callback(database.close)
        homes = HistoryHomes(database)
        directory = ShardDirectory(
            database,
            homes,
            PLAN,
            lambda _site, _counts: "own",
            registry=SiteRegistry(database, SystemClock()),
        )
        self.asgi = ShardRouter({MAIN: self.hub.hub.asgi, EAST: self._east.hub.asgi}, directory)
        self.settings = settings
        self.another = await self._stack.enter_async_context(AnotherHub(self))
        self._doors = itertools.cycle([self.another])

    @property
    def home(self):
        return self.another

    def hub_of(self, site: str):
        return self._east.hub if site == OF_EAST else self.hub.hub

    async def link(self, site: str):
        return await self.hub.gateway(key=self.hub.keys[site], at=self.another)


@asynccontextmanager
async def begin_divided(settings: Settings) -> AsyncIterator[DividedWorld]:
    """Give the world, with both its sites online."""
    folder = settings.data
    servers = folder / "servers.yaml"
    servers.write_text(f"servers: {{{EAST}: 'sqlite:///{folder}/east.db'}}\nshards: [{EAST}]\n")
    servers.chmod(0o600)
    (folder / "maps").mkdir()
    (folder / "maps" / "a.pmtiles").write_bytes(b"PMTiles")
    settings = replace(
        settings, history_servers=servers, assets=folder / "assets", maps=folder / "maps"
    )
    database = Database(settings.url)
    await database.migrate()
    await HistoryHomes(database).add_home(OF_EAST, EAST)
    await database.close()
    async with RunningHub(settings, None, seat=FakeSeat(MAIN)) as hub:
        world = DividedWorld(hub)
        try:
            await world.begin()
            yield world
        finally:
            await world.close()
