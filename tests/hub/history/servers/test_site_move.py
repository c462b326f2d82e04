"""A site moves to another server while it is written: all of it is there, and once."""

import contextlib
import itertools
from contextlib import contextmanager

import pytest
import sqlalchemy as sa
from sqlalchemy.engine import Engine

from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.home_tables import OWN, history_homes

from ..samples import ALL, rows_of, wanted
from .samples_sent import ADDRESSES, assert_whole, move_while_sending, rows_between, send


async def test_a_site_moves_and_goes_on_there(place) -> None:
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 300)
        await send(history, "other", 0, 100)
        await history.record_gap("agv", "c", 0, 9, from_us=1, to_us=2, reason="away")
        await homes.ask_move("agv", "east", own=OWN)
        await history.move_sites()
        assert (await homes.find_home("agv")).server == "east"
        await assert_whole(history, "agv", 300)
        await send(history, "agv", 250, 400)
        await assert_whole(history, "agv", 400)
        assert await history.stored_below("agv", "c") == 10
        await assert_whole(history, "other", 100)
        # It is there and nowhere else.
        assert not history.places.store_named(OWN).transfer.has_site("agv")
        assert history.places.store_named(OWN).transfer.has_site("other")
    async with place.opened() as (history, _):
        await assert_whole(history, "agv", 400)
        await assert_whole(history, "other", 100)
        # Numbers of what was erased are not given again.
        await send(history, "third", 0, 90)
        await assert_whole(history, "third", 90)
        await assert_whole(history, "other", 100)


async def test_a_site_moves_back(place) -> None:
    place.default = "east"
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 200)
        assert (await homes.find_home("agv")).server == "east"
        assert not history.places.store_named(OWN).transfer.has_site("agv")
        for server in (OWN, "east", OWN):
            await homes.ask_move("agv", server, own=OWN)
            await history.move_sites()
            await assert_whole(history, "agv", 200)
            assert history.places.store_named(server).transfer.has_site("agv")
        assert not history.places.store_named("east").transfer.has_site("agv")


async def test_what_is_sent_within_a_move_is_there_once(place) -> None:
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 50)
        sent = await move_while_sending(history, homes, ("east", OWN, "east"), 50)
        await assert_whole(history, "agv", sent)


async def test_a_channel_that_is_renamed_within_a_move_keeps_its_history(place) -> None:
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 100)
        asked = await homes.ask_move("agv", "east", own=OWN)
        await move_until(history, 40)
        assert (await homes.find_home("agv")).moving_to == asked.moving_to
    async with place.opened() as (history, homes):
        await history.rename_channels("agv", {"base/x": "base/y"})
        # Once to see it, and once to copy it anew.
        await history.move_sites()
        await history.move_sites()
        assert (await homes.find_home("agv")).server == "east"
        (found,) = await history.read_series("agv", ["base/y"], *ALL, width=10_000)
        assert rows_of(found) == wanted(rows_between(0, 100), 0)
        assert not history.has_channel("agv", "base/x")


async def test_a_move_that_is_called_off_leaves_nothing_behind(place) -> None:
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 100)
        await homes.ask_move("agv", "east", own=OWN)
        await move_until(history, 40)
    async with place.opened() as (history, homes):
        await homes.ask_move("agv", OWN, own=OWN)
        await history.move_sites()
        home = await homes.find_home("agv")
        assert (home.server, home.moving_to, home.erase_at) == (OWN, "", "")
        await assert_whole(history, "agv", 100)
        assert not history.places.store_named("east").transfer.has_site("agv")


async def test_a_newer_history_there_is_not_written_over(place) -> None:
    """Accounts of a backup say that a site is where it was; what came since then is elsewhere."""
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 50)
        await homes.ask_move("agv", "east", own=OWN)
        await history.move_sites()
        await send(history, "agv", 50, 90)
    database = Database(place.accounts)
    async with database.write() as connection:
        await connection.execute(sa.update(history_homes).values(server=OWN))
    await database.close()
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, 20)
        await homes.ask_move("agv", "east", own=OWN)
        await history.move_sites()
        home = await homes.find_home("agv")
        assert "has a history of agv that is no copy" in home.problem
        await assert_whole(history, "agv", 20)
        (x, _) = await history.places.store_named("east").read_series(
            "agv", ADDRESSES, *ALL, width=1000
        )
        assert rows_of(x) == wanted(rows_between(0, 90), 0)


class Died(Exception):
    """The program's end, as far as the databases can tell."""


@contextmanager
def dying(statement):
    """Let everything end at a statement, counted from 1 over all databases; from there on it is."""
    seen = itertools.count(1)

    def before(*_arguments) -> None:
        if next(seen) >= statement:
            raise Died

    sa.event.listen(Engine, "before_cursor_execute", before)
    try:
        yield seen
    finally:
        sa.event.remove(Engine, "before_cursor_execute", before)


async def move_until(history, statement):
    """Move what is asked for until the program's end; give how many statements there were."""
    with dying(statement) as seen, contextlib.suppress(Died):
        await history.move_sites()
    return next(seen) - 1


# So near to each other that every step of a move ends once; many more by night.
@pytest.mark.parametrize("step", [23])
async def test_no_end_of_the_program_within_a_move_loses_or_doubles_a_sample(place, step) -> None:
    """It ends at one statement after the other, is begun anew, and what is sent goes on."""
    sent, statement = 60, 1
    async with place.opened() as (history, homes):
        await send(history, "agv", 0, sent)
        await send(history, "other", 0, 60)
    for server in itertools.cycle(["east", OWN]):
        async with place.opened() as (history, homes):
            if await homes.find_home("agv") is None or not (await homes.find_home("agv")).moving_to:
                await homes.ask_move("agv", server, own=OWN)
            count = await move_until(history, statement)
        async with place.opened() as (history, homes):
            await assert_whole(history, "agv", sent)
            await assert_whole(history, "other", 60)
            # What is sent again, and what is new.
            await send(history, "agv", sent - 10, sent + 13)
            sent += 13
            await history.move_sites()
            home = await homes.find_home("agv")
            assert (home.moving_to, home.erase_at) == ("", "")
            await assert_whole(history, "agv", sent)
            left = OWN if home.server == "east" else "east"
            assert not history.places.store_named(left).transfer.has_site("agv")
            assert history.places.store_named(home.server).transfer.has_site("agv")
        # It came to its end by itself: there is no later statement.
        if count < statement:
            break
        statement += step
    assert statement > 5 * step
