"""What two leads say to each other of a site that changes its shard, on databases of each kind."""

import pytest
import sqlalchemy as sa

from talaia.hub.sharding.own_shard import OwnShard
from talaia.hub.sharding.plan import MAIN, ShardPlan
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import NOBODY, OWN
from talaia.hub.store.history_servers.shard_handover import HoldWord, ShardHandover, word_of
from talaia.hub.store.tables import sites

PLAN = ShardPlan(("east", "west"))


@pytest.fixture
async def homes(database):
    """Give the rows, with one of a site that is asked to go from east to west."""
    found = HistoryHomes(database)
    await found.add_home("agv", "east")
    await found.ask_move("agv", "west", own=OWN)
    return found


@pytest.fixture
def handover(database):
    return ShardHandover(database)


@pytest.fixture
async def held(homes, handover):
    """Give the row as it stands while nothing of the site is written."""
    home = await handover.begin_hold(await homes.find_home("agv"))
    for word in (HoldWord.SEALED, HoldWord.HOLD, HoldWord.HELD):
        home = await handover.write_word(home, word)
    return home


def leads(database) -> dict[str, OwnShard]:
    """Give a lead for each shard, none of which has begun."""
    return {
        shard: OwnShard(shard, PLAN, HistoryHomes(database), ShardHandover(database))
        for shard in PLAN.all_names
    }


async def own_in_sql(shard: OwnShard, database) -> list[str]:
    async with database.read() as connection:
        query = sa.select(sites.c.site).where(*shard.own_rows(sites.c.site))
        return sorted(await connection.scalars(query))


async def test_a_site_that_was_let_go_of_its_hold_does_not_move(homes, handover, held) -> None:
    assert (await handover.end_hold(held)).hold == ""
    assert not await homes.switch_home(held, led_by="east")
    # Nor by the words of a later attempt.
    again = await handover.begin_hold(held)
    await handover.write_word(again, HoldWord.SEALED)
    assert not await homes.switch_home(held, led_by="east")
    assert (await homes.find_home("agv")).server == "east"


async def test_a_hold_that_is_over_by_the_move_is_not_taken_back(homes, handover, held) -> None:
    assert await homes.switch_home(held, led_by="east")
    found = await handover.end_hold(held)
    assert (found.server, found.led_by, found.erase_at, found.hold) == ("west", "east", "east", "")


async def test_no_word_is_said_where_the_one_before_it_does_not_stand(homes, handover) -> None:
    home = await handover.begin_hold(await homes.find_home("agv"))
    assert word_of(home.hold) == HoldWord.SEAL
    sealed = await handover.write_word(home, HoldWord.SEALED)
    assert await handover.write_word(home, HoldWord.HELD) is None
    # It is asked for otherwise: what was said of the move before is over.
    await homes.ask_move("agv", "own", own=OWN)
    assert await handover.write_word(sealed, HoldWord.HOLD) is None
    assert (await homes.find_home("agv")).hold == ""


async def test_of_a_hold_whose_last_word_is_not_known_every_word_is_taken_back(
    homes, handover, held
) -> None:
    await handover.end_hold(held._replace(hold=held.hold.replace("held", "hold")))
    assert not await homes.switch_home(held, led_by="east")


async def test_a_lead_that_begins_takes_back_what_the_one_before_it_has_said(
    homes, handover, held
) -> None:
    await handover.end_holds(["west", OWN])
    assert (await homes.find_home("agv")).hold == held.hold
    await handover.end_holds(["east"])
    assert not await homes.switch_home(held, led_by="east")


async def test_a_site_is_one_leads_or_nobodys_until_both_have_begun_anew(
    homes, held, database
) -> None:
    async with database.write() as connection:
        said = {"description": "", "catalogue": "", "version": ""}
        row = {"site": "agv", "first_seen_us": 1, "last_seen_us": 1, **said}
        await connection.execute(sa.insert(sites), row)
    before = leads(database)
    for shard in before.values():
        await shard.open()
    assert await homes.switch_home(held, led_by="east")
    # The one that has it in memory has it to its end.
    for shard in before.values():
        await shard.refresh()
        assert shard.has_site("agv") == (shard.name == "east")
        assert await own_in_sql(shard, database) == (["agv"] if shard.name == "east" else [])
    after = leads(database)
    await after["east"].open()
    assert (await homes.find_home("agv")).led_by == NOBODY
    for shard in (*before.values(), *after.values()):
        await shard.refresh()
        assert not shard.has_site("agv")
        assert await own_in_sql(shard, database) == []
    await after["west"].open()
    assert (await homes.find_home("agv")).led_by == ""
    for name, shard in after.items():
        await shard.refresh()
        assert await shard.look_up("agv") == (name == "west")
        assert await own_in_sql(shard, database) == (["agv"] if name == "west" else [])


async def test_a_site_comes_from_the_main_shard_and_goes_back(homes, handover, database) -> None:
    await homes.add_home("moon", OWN)
    for server, shard in (("east", "east"), (OWN, MAIN)):
        home = await homes.ask_move("moon", server, own=OWN)
        home = await handover.begin_hold(home)
        assert await homes.switch_home(home, led_by=home.server)
        began = leads(database)
        for name in (began.keys() - {shard}) | set():
            await began[name].open()
        await began[shard].open()
        assert began[shard].has_site("moon")


async def test_each_change_of_a_server_has_a_turn_of_its_own(homes, held, database) -> None:
    await homes.switch_home(held, led_by="east")
    await homes.add_home("moon", OWN)
    asked = await homes.ask_move("moon", "archive", own=OWN)
    await homes.switch_home(asked)
    turns = {home.site: home.turn for home in await homes.list_homes()}
    assert turns == {"agv": 1, "moon": 2}
