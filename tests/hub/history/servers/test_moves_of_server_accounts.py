"""Moves whose accounts are in a database of a server, as several hubs have them."""

import shutil

import pytest

from talaia.hub.history.errors import HistoryError
from talaia.hub.store.history_servers.home_tables import OWN

from ...databases import database_with_tables, empty_database
from .conftest import Place
from .samples_sent import assert_whole, move_while_sending, send
from .test_site_move import move_until

KINDS = [("postgresql", "mariadb"), ("mariadb", "postgresql")]


@pytest.fixture(params=KINDS, ids=lambda kinds: f"accounts-{kinds[0]}")
def place(request, tmp_path):
    """Give accounts on one kind of server, and an empty database on the other."""
    accounts, east = request.param
    with database_with_tables(accounts, tmp_path) as home, empty_database(east) as away:
        yield Place(home, away)
    shutil.rmtree(tmp_path, ignore_errors=True)


async def test_a_site_moves_there_and_back_while_it_is_written(place) -> None:
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 60)
        await send(history, "other", 0, 40)
        sent = await move_while_sending(history, homes, ("east", OWN, "east"), 60)
        await assert_whole(history, "agv", sent)
        await assert_whole(history, "other", 40)


async def test_it_ends_within_a_move_and_another_program_goes_on_with_it(place) -> None:
    sent = 40
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, sent)
    # Early, within the copy, and about the commit that is the move.
    for server, statement in (("east", 9), (OWN, 31), ("east", 53), (OWN, 75)):
        async with place.opened() as (history, homes):
            await homes.ask_move("agv", server, own=OWN)
            await move_until(history, statement)
        async with place.opened() as (history, homes):
            await assert_whole(history, "agv", sent)
            await send(history, "agv", sent - 10, sent + 13)
            sent += 13
            await history.move_sites()
            home = await homes.find_home("agv")
            assert (home.server, home.moving_to, home.erase_at) == (server, "", "")
            await assert_whole(history, "agv", sent)
            left = OWN if server == "east" else "east"
            assert not history.places.store_named(left).transfer.has_site("agv")


async def test_a_hub_that_was_replaced_copies_nothing_more(place) -> None:
    async with place.opened() as (stale, homes):
        await send(stale, "agv", 0, 50)
        await homes.ask_move("agv", "east", own=OWN)
        async with place.opened() as (newer, _):
            await stale.move_sites()
            assert "another hub writes" in (await homes.find_home("agv")).problem
            await newer.move_sites()
            assert (await homes.find_home("agv")).server == "east"
            await send(newer, "agv", 50, 60)
            # It is told where the site is now, and may not write there either.
            stale.places.home_of["agv"] = "east"
            with pytest.raises(HistoryError, match="another hub writes"):
                await send(stale, "agv", 60, 70)
            await assert_whole(newer, "agv", 60)
