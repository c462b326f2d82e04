"""Where histories are, and moves that are asked for, beside the accounts of each kind."""

import asyncio

from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN


async def test_a_new_site_has_one_home_whoever_asks(database) -> None:
    homes = HistoryHomes(database)
    found = await asyncio.gather(*(homes.add_home("agv", name) for name in ("east", "west")))
    assert found[0].server == found[1].server
    assert [home.site for home in await homes.list_homes()] == ["agv"]


async def test_a_move_is_one_commit_and_only_the_one_that_was_asked_for(database) -> None:
    homes = HistoryHomes(database)
    asked = await homes.ask_move("agv", "east", own=OWN)
    assert (asked.server, asked.moving_to) == (OWN, "east")
    # Asked twice it is the same one.
    assert await homes.ask_move("agv", "east", own=OWN) == asked
    await homes.report_progress(asked._replace(done_blocks=3, all_blocks=9, problem="away"))
    assert (await homes.find_home("agv")).problem == "away"
    other = await homes.ask_move("agv", "west", own=OWN)
    assert not await homes.switch_home(asked)
    # What is said of a former move changes nothing.
    await homes.report_progress(asked._replace(done_blocks=8))
    assert (await homes.find_home("agv")).done_blocks == 0
    assert await homes.switch_home(other)
    moved = await homes.find_home("agv")
    assert (moved.server, moved.moving_to, moved.erase_at) == ("west", "", OWN)
    assert not await homes.switch_home(other)
    await homes.finish_erasing("agv", "east")
    assert (await homes.find_home("agv")).erase_at == OWN
    await homes.finish_erasing("agv", OWN)
    assert (await homes.find_home("agv")).erase_at == ""


async def test_to_ask_for_where_it_is_ends_a_move_and_erases_what_came(database) -> None:
    homes = HistoryHomes(database)
    await homes.ask_move("agv", "east", own=OWN)
    ended = await homes.ask_move("agv", OWN, own=OWN)
    assert (ended.server, ended.moving_to, ended.erase_at) == (OWN, "", "east")


async def test_terms_rise_above_all_that_were_seen(database) -> None:
    homes = HistoryHomes(database)
    name = await homes.own_name()
    assert await homes.own_name() == name
    assert [await homes.raise_term(seen) for seen in (0, 0, 41, 3)] == [1, 2, 42, 43]
    assert sorted(await asyncio.gather(*(homes.raise_term(0) for _ in range(3)))) == [44, 45, 46]
