"""Two hubs of one process on one database and one data folder, each with some of the sites."""

# ruff: noqa: D107
from __future__ import annotations

from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.hub.cluster.peers import HubNotice
from talaia.hub.sharding.plan import MAIN, ShardPlan
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.sites.site_registry import SiteRegistry

from ..conftest import DESCRIPTION, Gateway, MemoryHistory, RunningHub

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from talaia.hub.settings import Settings

PLAN = ShardPlan(("east",))
EAST = "east"
# A site of each.
LAB, AGV = "lab", "agv"


class FakeSeat:
    """The place of a hub that leads a shard; nobody disputes it."""

    connected = True

    def __init__(self, shard: str) -> None:
        self.shard, self.plan = shard, PLAN

    def check_connection(self, _connection, _record) -> None: ...

    async def claim_lead(self, _database, _seal_hash) -> None: ...

    def begin_anew(self) -> None: ...

    def own_notice(self):
        return HubNotice(hub=self.shard, name="a", version="1", leads=True)

    def heard_hubs(self) -> tuple:
        return ()


class ShardHub(RunningHub):
    """A hub that leads one shard."""

    def __init__(self, settings: Settings, shard: str) -> None:
        super().__init__(settings, MemoryHistory(), seat=FakeSeat(shard))
        self.shard = shard


class TwoShards:
    """The site ``agv`` is of the shard ``east``; ``lab``, and who is asked, of the main one."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.database = Database(settings.url)
        self.keys = {}
        self._stack = AsyncExitStack()
        self._open = {}

    @property
    def main(self) -> ShardHub:
        return self._open[MAIN][0]

    @property
    def east(self) -> ShardHub:
        return self._open[EAST][0]

    async def begin(self) -> None:
        await self.database.migrate()
        await HistoryHomes(self.database).add_home(AGV, EAST)
        registry = SiteRegistry(self.database, SystemClock())
        self.keys = {name: await registry.new_key(name) for name in (AGV, LAB)}
        await self.start(MAIN)
        await self.main.populate()
        # It made a gateway's key as well, which is not ours.
        self.keys[AGV] = await registry.new_key(AGV)
        await self.start(EAST)

    async def start(self, shard: str) -> ShardHub:
        """Start the hub of a shard, for the first time or again."""
        stack = AsyncExitStack()
        hub = await stack.enter_async_context(ShardHub(self.settings, shard))
        self._open[shard] = hub, stack
        return hub

    async def end(self, shard: str) -> None:
        """End the hub of a shard."""
        _, stack = self._open.pop(shard)
        await stack.aclose()

    async def close(self) -> None:
        for shard in list(self._open):
            await self.end(shard)
        await self.database.close()

    async def gateway(self, site: str, more: str = "") -> Gateway:
        """Link the gateway of a site at the hub that has it."""
        gateway = await (self.east if site == AGV else self.main).gateway(key=self.keys[site])
        await gateway.hello(description_of(site) + more, site=site)
        return gateway


def description_of(site: str) -> str:
    return DESCRIPTION.replace("site: agv", f"site: {site}", 1)


@asynccontextmanager
async def begun_shards(settings: Settings) -> AsyncIterator[TwoShards]:
    shards = TwoShards(settings)
    try:
        await shards.begin()
        yield shards
    finally:
        await shards.close()
