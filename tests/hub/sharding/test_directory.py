"""Which shard has which site: as the accounts' database says, and once for all."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from talaia.clock import HandClock
from talaia.hub.sharding.directory import ShardDirectory
from talaia.hub.sharding.plan import MAIN, ShardPlan
from talaia.hub.store.database import open_migrated
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.sites.site_registry import SiteRegistry

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from talaia.hub.store.database import Database

PLAN = ShardPlan(("east", "west"))


@pytest.fixture
async def database(tmp_path) -> AsyncIterator[Database]:
    async with open_migrated(f"sqlite:///{tmp_path}/hub.db") as opened:
        yield opened


def least(_site: str, counts: Mapping[str, int]) -> str:
    return min(PLAN.names, key=lambda name: counts.get(name, 0))


def directory_of(database: Database, choose=least) -> ShardDirectory:
    registry = SiteRegistry(database, HandClock())
    return ShardDirectory(database, HistoryHomes(database), PLAN, choose, registry=registry)


async def enrolled(database: Database, *sites: str) -> list[str]:
    registry = SiteRegistry(database, HandClock())
    return [await registry.new_key(site) for site in sites]


async def test_a_new_site_is_placed_where_the_fewest_are_and_stays_there(database) -> None:
    names = [f"site{number}" for number in range(4)]
    await enrolled(database, *names)
    one = directory_of(database)
    placed = [await one.place_site(name) for name in names]
    assert sorted(placed) == ["east", "east", "west", "west"]
    # Another hub, which was never told.
    other = directory_of(database)
    assert [await other.find_shard(name) for name in names] == placed


async def test_hubs_that_place_a_site_at_once_agree(database) -> None:
    await enrolled(database, "agv")
    hubs = [directory_of(database, lambda *_, to=to: to) for to in ("east", "west") * 3]
    placed = await asyncio.gather(*(hub.place_site("agv") for hub in hubs))
    assert len(set(placed)) == 1


async def test_a_site_with_a_history_in_the_main_database_is_never_placed_anew(database) -> None:
    await enrolled(database, "agv", "moon")
    await SiteRegistry(database, HandClock()).said_hello("agv", "…", "")
    await HistoryHomes(database).add_home("moon", "archive")
    directory = directory_of(database)
    assert [await directory.place_site(name) for name in ("agv", "moon")] == [MAIN, MAIN]
    assert {home.site for home in await HistoryHomes(database).list_homes()} == {"moon"}


async def test_a_new_site_of_the_main_shard_has_its_place_written_down_as_well(database) -> None:
    await enrolled(database, "agv")
    assert await directory_of(database, lambda *_: "own").place_site("agv") == MAIN
    # Another hub, which counts otherwise, does not place it elsewhere.
    assert await directory_of(database, lambda *_: "east").place_site("agv") == MAIN


async def test_nobody_without_a_key_gives_a_site_a_place(database) -> None:
    directory = directory_of(database)
    assert await directory.place_site("stranger") == MAIN
    assert await HistoryHomes(database).list_homes() == []


async def test_a_site_that_gets_its_place_at_another_hub_is_found_there(database) -> None:
    await enrolled(database, "agv")
    asked_before = directory_of(database)
    assert await asked_before.find_shard("agv") == MAIN
    placed = await directory_of(database).place_site("agv")
    # A gateway that comes here does not wait for what is remembered of the site to be forgotten.
    assert await asked_before.place_site("agv") == placed
    assert asked_before.known_shard("agv") == placed


async def test_a_key_and_a_number_lead_to_their_site(database) -> None:
    (key,) = await enrolled(database, "agv")
    directory = directory_of(database)
    assert await directory.find_site_of_key(key) == "agv"
    assert await directory.find_site_of_key("another") is None
    (gateway,) = await SiteRegistry(database, HandClock()).list_gateways()
    assert await directory.find_site_of_gateway(gateway.id) == "agv"
    assert await directory.find_site_of_gateway(gateway.id + 1) is None


async def test_a_site_that_changes_its_shard_is_led_there_from_then_on(database) -> None:
    await enrolled(database, "agv")
    homes = HistoryHomes(database)
    directory = directory_of(database, lambda *_: "east")
    assert await directory.place_site("agv") == "east"
    await homes.switch_home(await homes.ask_move("agv", "west", own="own"))
    assert directory.known_shard("agv") == "east"
    await directory.refresh()
    assert directory.known_shard("agv") == "west"
    await homes.switch_home(await homes.ask_move("agv", "own", own="own"))
    await directory.refresh()
    assert await directory.place_site("agv") == MAIN


async def test_what_was_looked_up_before_a_change_does_not_stand_for_what_is_after_it(
    database,
) -> None:
    homes = HistoryHomes(database)
    await homes.add_home("agv", "east")
    directory = directory_of(database)
    # The rows are read, and whoever reads them has not the turn yet.
    looking = asyncio.create_task(directory.find_shard("agv"))
    await homes.switch_home(await homes.ask_move("agv", "west", own="own"))
    await asyncio.gather(looking, directory.refresh())
    assert directory.known_shard("agv") == "west"
