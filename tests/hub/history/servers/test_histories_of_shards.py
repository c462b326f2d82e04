"""Each shard's lead has its own servers alone, and a site's history is in one place."""

import asyncio
import shutil
from contextlib import AsyncExitStack, asynccontextmanager

import pytest

from talaia.clock import SystemClock
from talaia.hub.errors import CannotStart
from talaia.hub.history.errors import HistoryAway
from talaia.hub.history.servers.build_history import build_history
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.history.store import HistoryStore
from talaia.hub.settings import Settings
from talaia.hub.sharding.plan import ShardPlan
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.model.yaml_text.load import load_site

from ...conftest import DESCRIPTION
from ...databases import origin_of
from .conftest import TINY
from .samples_sent import assert_whole, send

PLAN = ShardPlan(("east", "west"))


class Shards:
    """Databases of hubs whose sites are divided: each server is one, and `north` is no shard's."""

    def __init__(self, folder) -> None:
        """Put them into ``folder``."""
        self._folder = folder
        shutil.copy(origin_of("sqlite"), folder / "talaia.db")
        self.file = folder / "servers.yaml"
        self.file.touch(mode=0o600)
        self.write_file("shards: [east, west]\ndefault: [east, west]")

    def write_file(self, text) -> None:
        urls = [f"{name}: 'sqlite:///{self._folder}/{name}.db'" for name in ("east", "west")]
        north = f"north: 'sqlite:///{self._folder}/north.db'"
        self.file.write_text(f"servers: {{{', '.join([*urls, north])}}}\n{text}\n")

    @asynccontextmanager
    async def opened(self, shard=None, plan=PLAN, limits=TINY):
        """Open a lead's history, or a command's; give it, and the homes."""
        settings = Settings(data=self._folder, history_servers=self.file)
        database = Database(settings.url)
        try:
            made = build_history(settings, database, SystemClock(), limits, shard=shard, plan=plan)
            try:
                await made.open()
                yield made, HistoryHomes(database)
            finally:
                await made.close()
        finally:
            await database.close()

    @asynccontextmanager
    async def all_opened(self):
        """Open the histories of all leads; give them by shard, and the homes."""
        async with AsyncExitStack() as stack:
            opened = {}
            for shard in PLAN.all_names:
                opened[shard], homes = await stack.enter_async_context(self.opened(shard))
            yield opened, homes


@pytest.fixture
def shards(tmp_path):
    return Shards(tmp_path)


async def test_each_lead_has_the_sites_of_its_own_servers_and_refuses_others(shards) -> None:
    async with shards.all_opened() as (leads, homes):
        places = {"agv": "east", "arm": "west", "drone": OWN, "lab": "north"}
        for site, server in places.items():
            await homes.add_home(site, server)
        for shard, history in leads.items():
            for site, server in places.items():
                if PLAN.shard_of_server(server) == shard:
                    await send(history, site, 0, 40)
                    await assert_whole(history, site, 40)
                    continue
                of = PLAN.shard_of_server(server)
                for refused in (
                    send(history, site, 0, 40),
                    history.stored_below(site, "b"),
                    history.record_gap(site, "b", 0, 1, from_us=0, to_us=1, reason=""),
                    history.read_series(site, ["base/x"], 0, 1, width=10),
                ):
                    with pytest.raises(HistoryAway, match=f"of the shard '{of}'"):
                        await refused
                assert history.kind_of(site, "base/x") is None
            assert history.trouble == ""
    # Each is where its row says, and nowhere else; a command has all of them.
    async with shards.opened() as (history, _):
        for site, server in places.items():
            await assert_whole(history, site, 40)
            there = [
                name
                for name in (OWN, "east", "west", "north")
                if history.places.store_named(name).transfer.has_site(site)
            ]
            assert there == [server]


async def test_a_site_without_a_row_is_the_main_shards_from_its_first_sample_on(shards) -> None:
    async with shards.all_opened() as (leads, homes):
        for shard in PLAN.names:
            with pytest.raises(HistoryAway, match="agv is of the shard 'main'"):
                await send(leads[shard], "agv", 0, 10)
        await send(leads["main"], "agv", 0, 10)
        # Written down before anything was stored, so no hub can give it to another shard any more.
        assert (await homes.add_home("agv", "east")).server == OWN
        with pytest.raises(HistoryAway, match="of the shard 'main'"):
            await send(leads["east"], "agv", 10, 20)
        # One that got its row meanwhile is not stored in a second place.
        await homes.add_home("arm", "west")
        with pytest.raises(HistoryAway, match="of the shard 'west'"):
            await send(leads["main"], "arm", 0, 10)
        await send(leads["west"], "arm", 0, 10)


async def test_two_hubs_that_ask_at_once_store_a_new_site_in_one_place(shards) -> None:
    async with shards.opened("main") as (main, homes), shards.opened("east") as (east, _):
        # As a hub in front gives a new site its place, while the main lead is told of it.
        given, *stored = await asyncio.gather(
            homes.add_home("agv", "east"),
            send(main, "agv", 0, 10),
            send(east, "agv", 0, 10),
            return_exceptions=True,
        )
        owner = {"east": east, OWN: main}[given.server]
        assert sum(isinstance(one, HistoryAway) for one in stored) >= 1
        await send(owner, "agv", 0, 10)
        await assert_whole(owner, "agv", 10)


async def test_the_main_lead_stores_new_sites_on_a_server_that_is_no_shard(shards) -> None:
    shards.write_file("shards: [east, west]\ndefault: [east, west, north]\nsites: {arm: west}")
    async with shards.opened("main") as (history, homes):
        for site in ("agv", "arm"):
            await send(history, site, 0, 10)
            assert (await homes.find_home(site)).server == "north"


async def test_a_lead_opens_while_its_server_is_away_and_others_do_not_notice(
    shards, tmp_path
) -> None:
    disk = tmp_path / "disk"
    shards.file.write_text(
        f"servers: {{east: 'sqlite:///{disk}/e.db', west: 'sqlite:///{tmp_path}/w.db'}}\n"
        "shards: [east, west]\n"
    )
    async with shards.all_opened() as (leads, homes):
        await homes.add_home("agv", "east")
        east = leads["east"]
        await east.describe_site(load_site(DESCRIPTION))
        with pytest.raises(HistoryAway, match="'east' is away"):
            await send(east, "agv", 0, 10)
        with pytest.raises(HistoryAway, match="'east', which is away"):
            await east.measure_storage()
        assert "agv is on 'east', which is away" in east.trouble
        assert leads["main"].trouble == leads["west"].trouble == ""
        disk.mkdir()
        await east.mend_servers()
        await send(east, "agv", 0, 10)
        await assert_whole(east, "agv", 10)
        assert east.trouble == ""
        assert east.kind_of("agv", "base/speed").name == "Speed"


async def test_a_limit_counts_for_each_server_that_a_lead_has(shards) -> None:
    for shard, many in (("main", 2), ("east", 1), (None, 4)):
        limits = TINY._replace(bytes=1_000)
        async with shards.opened(shard, limits=limits) as (history, homes):
            assert history.most_bytes == many * 1_000
            if shard == "east":
                await homes.add_home("agv", "east")
                await send(history, "agv", 0, 40)
                await history.places.store_named("east").transfer.seal_all("agv")
                stored = await history.measure_storage()
                assert {channel.site for channel in stored.channels} == {"agv"}


async def test_a_server_may_become_a_shard_and_be_none_again(shards) -> None:
    shards.write_file("default: east")
    async with shards.opened("main", ShardPlan()) as (history, _):
        await send(history, "agv", 0, 40)
    shards.write_file("shards: [east, west]")
    async with shards.opened("main") as (main, _), shards.opened("east") as (east, _):
        await send(east, "agv", 40, 80)
        with pytest.raises(HistoryAway):
            await send(main, "agv", 40, 80)
    shards.write_file("shards: []")
    async with shards.opened("main", ShardPlan()) as (history, _):
        await assert_whole(history, "agv", 80)


async def test_a_move_to_another_shard_waits_until_a_command_does_it(shards) -> None:
    async with shards.all_opened() as (leads, homes):
        await send(leads["main"], "agv", 0, 200)
        await homes.ask_move("agv", "east", own=OWN)
        for history in leads.values():
            await history.move_sites()
        assert (await homes.find_home("agv")).server == OWN
        await send(leads["main"], "agv", 200, 300)
        # One within the shard is done.
        await send(leads["main"], "lab", 0, 40)
        await homes.ask_move("lab", "north", own=OWN)
        await leads["main"].move_sites()
        assert (await homes.find_home("lab")).server == "north"
    async with shards.opened() as (history, homes):
        await history.move_sites()
        assert (await homes.find_home("agv")).server == "east"
    async with shards.all_opened() as (leads, _):
        await assert_whole(leads["east"], "agv", 300)
        await send(leads["east"], "agv", 300, 310)


async def test_what_a_move_left_behind_is_erased_by_the_lead_that_has_that_place(
    shards, monkeypatch
) -> None:
    async with shards.opened("main") as (main, _):
        await send(main, "agv", 0, 100)

    async def killed(_site) -> None:
        raise HistoryAway("killed")

    with monkeypatch.context() as patched:
        async with shards.opened() as (history, homes):
            own = history.places.store_named(OWN).transfer
            patched.setattr(own, "erase_site", killed)
            await homes.ask_move("agv", "east", own=OWN)
            await history.move_sites()
            assert (await homes.find_home("agv")).erase_at == OWN
    async with shards.all_opened() as (leads, homes):
        await send(leads["east"], "agv", 100, 120)
        await leads["east"].move_sites()
        assert (await homes.find_home("agv")).erase_at == OWN
        await leads["main"].move_sites()
        assert (await homes.find_home("agv")).erase_at == ""
        assert not leads["main"].places.store_named(OWN).transfer.has_site("agv")
        await assert_whole(leads["east"], "agv", 120)


async def test_shards_need_several_hubs_with_the_same_plan(shards) -> None:
    for plan, said in (
        (None, r"start it with --cluster"),
        (ShardPlan(), r"start it with --cluster"),
        (ShardPlan(("west",)), "have changed within the start"),
    ):
        with pytest.raises(CannotStart, match="shards:") as told:
            async with shards.opened("main", plan):
                pass
        assert said in str(told.value)


async def test_a_hub_without_the_file_makes_one_history(tmp_path) -> None:
    settings = Settings(data=tmp_path)
    database = Database(settings.url)
    for shard in (None, "main"):
        made = build_history(settings, database, SystemClock(), TINY, shard=shard)
        assert isinstance(made, HistoryStore)
        assert not isinstance(made, HistoryServers)
        await made.close()
    with pytest.raises(CannotStart, match="'east' needs --history-servers"):
        build_history(settings, database, SystemClock(), TINY, shard="east", plan=PLAN)
    await database.close()
