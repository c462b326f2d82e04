"""A site goes from one lead's server to another's: one copies, the other holds its last moment."""

# ruff: noqa: D107
import asyncio
import contextlib
from contextlib import asynccontextmanager

import pytest
from patience import PATIENCE_S, until_answered

from talaia.clock import SystemClock
from talaia.hub.history.errors import HistoryAway, HistoryElsewhere
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.history.servers.server_file import HistoryServersFile
from talaia.hub.history.servers.shard_passage import ShardPassage
from talaia.hub.history.store import HistoryStore
from talaia.hub.sharding.own_shard import OwnShard
from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.hub.store.history_servers.shard_handover import HoldWord, ShardHandover, word_of

from ..samples import ALL, rows_of, wanted
from .conftest import TINY
from .samples_sent import ADDRESSES, assert_whole, rows_between, send


class Lead:
    """The history of one shard's lead, which runs."""

    def __init__(self, history) -> None:
        self.history = history
        # Set when it is to close and to open again.
        self.anew = asyncio.Event()


class Leads:
    """Leads of two shards on one database; each may close, and another one opens after it."""

    def __init__(self, accounts, east) -> None:
        self.url = f"sqlite:///{accounts}"
        self.named = HistoryServersFile(servers={"east": east}, shards=("east",))
        self.database = Database(self.url)
        self.homes = HistoryHomes(self.database)
        self.handover = ShardHandover(self.database)

    @asynccontextmanager
    async def opened(self, shard, *, gate_s=PATIENCE_S, answer_s=PATIENCE_S, runs=True):
        """Be a lead from its beginning to its end."""
        await OwnShard(shard, self.named.plan, self.homes, self.handover).open()
        lead = Lead(None)
        own = HistoryStore(self.url, SystemClock(), TINY) if shard == MAIN else None
        passage = ShardPassage(self.handover, self.url, lead.anew.set, gate_s, answer_s)
        lead.history = HistoryServers(
            own,
            self.named,
            self.homes,
            clock=SystemClock(),
            limits=TINY,
            shard=shard,
            passage=passage,
        )
        await lead.history.open()
        running = asyncio.create_task(lead.history.run()) if runs else None
        try:
            yield lead
        finally:
            if running is not None:
                running.cancel()
                await asyncio.gather(running, return_exceptions=True)
            await lead.history.close()

    async def until(self, fits):
        """Wait until the row stands as wanted; give it."""
        found = []

        async def stands() -> bool:
            found[:] = [await self.homes.find_home("agv")]
            return bool(fits(found[0]))

        await until_answered(stands)
        return found[0]

    async def until_said(self, word):
        return await self.until(lambda home: word_of(home.hold) == word)

    async def until_held(self):
        """Play the lead that it goes to, up to the hold."""
        await self.handover.begin_hold(await self.homes.ask_move("agv", OWN, own=OWN))
        sealed = await self.until_said(HoldWord.SEALED)
        await self.handover.write_word(sealed, HoldWord.HOLD)
        return await self.until_said(HoldWord.HELD)


@pytest.fixture
async def leads(tmp_path, database_url):
    """Give both; east's histories are in a database of each kind."""
    found = Leads(tmp_path / "accounts.db", database_url)
    await found.database.migrate()
    await found.homes.add_home("agv", "east")
    yield found
    await found.database.close()


async def assert_all_there(history, past):
    """See that each value up to ``past`` is there once; of texts a chart shows the newest."""
    values, texts = await history.read_series("agv", ADDRESSES, *ALL, width=100_000)
    rows = rows_between(0, past)
    assert rows_of(values) == wanted(rows, 0)
    shown = rows_of(texts)
    assert shown
    assert shown == wanted(rows, 1)[-len(shown) :]
    assert await history.stored_below("agv", "b") == past


async def keep_sending(history, first):
    """Send until the lead has the site no more; give up to where it was acknowledged."""
    with contextlib.suppress(HistoryElsewhere):
        while True:
            await send(history, "agv", first, first + 7)
            first += 7
    return first


async def test_a_site_goes_to_another_lead_and_back_while_it_is_written(leads) -> None:
    sent = 0
    for old, new, server in (("east", MAIN, OWN), (MAIN, "east", "east")):
        async with leads.opened(old) as source, leads.opened(new) as target:
            with pytest.raises(HistoryElsewhere):
                await send(target.history, "agv", sent, sent + 7)
            await source.history.record_gap("agv", old, 0, 9, from_us=1, to_us=2, reason="away")
            sending = asyncio.create_task(keep_sending(source.history, sent))
            await leads.homes.ask_move("agv", server, own=OWN)
            async with asyncio.timeout(PATIENCE_S):
                await asyncio.gather(source.anew.wait(), target.anew.wait())
                sent = await sending
            home = await leads.homes.find_home("agv")
            assert (home.server, home.erase_at) == (server, "east" if server == OWN else OWN)
        # What is left behind is erased once the one that it is at has begun anew.
        async with leads.opened(old) as source, leads.opened(new) as target:
            await assert_all_there(target.history, sent)
            assert await target.history.stored_below("agv", old) == 10
            await send(target.history, "agv", sent - 5, sent + 30)
            sent += 30
            await assert_all_there(target.history, sent)
            await leads.until(lambda home: not home.erase_at)
            left = source.history.places.open_stores()
            assert not any(store.transfer.has_site("agv") for store in left)


async def test_a_hold_that_nobody_ends_is_taken_back_in_time(leads) -> None:
    async with leads.opened("east", gate_s=1.0) as east, leads.opened(MAIN, runs=False):
        await send(east.history, "agv", 0, 50)
        held = await leads.until_held()
        # It waits, and is stored when the hold is over.
        await send(east.history, "agv", 50, 90)
        assert not await leads.homes.switch_home(held, led_by="east")
        await assert_whole(east.history, "agv", 90)
        assert not east.anew.is_set()


async def test_a_lead_that_closes_within_the_hold_stores_nothing_more(leads) -> None:
    async with leads.opened("east") as east:
        await send(east.history, "agv", 0, 50)
        held = await leads.until_held()
        late = asyncio.create_task(send(east.history, "agv", 50, 90))
    with pytest.raises(HistoryAway):
        await late
    assert await leads.homes.switch_home(held, led_by="east")


async def test_a_lead_that_begins_within_the_hold_of_the_one_before_it_takes_it_back(leads) -> None:
    async with leads.opened("east") as east:
        await send(east.history, "agv", 0, 50)
        held = await leads.until_held()
    async with leads.opened("east") as east:
        await send(east.history, "agv", 50, 90)
        assert not await leads.homes.switch_home(held, led_by="east")
        await assert_whole(east.history, "agv", 90)


async def test_to_ask_for_where_it_is_ends_the_hold_and_what_was_copied_goes(leads) -> None:
    async with leads.opened("east") as east, leads.opened(MAIN) as main:
        await send(east.history, "agv", 0, 50)
        asked = await leads.homes.ask_move("agv", OWN, own=OWN)
        await leads.until(lambda home: home.hold)
        await leads.homes.ask_move("agv", "east", own=OWN)
        home = await leads.until(lambda home: not home.erase_at)
        if home.server == "east":
            await send(east.history, "agv", 50, 90)
            await assert_whole(east.history, "agv", 90)
            assert not main.history.places.store_named(OWN).transfer.has_site("agv")
        assert asked.move != home.move


async def test_while_the_other_lead_is_away_the_move_says_so(leads) -> None:
    async with leads.opened("east", runs=False) as east, leads.opened(MAIN, answer_s=0.0):
        await send(east.history, "agv", 0, 50)
        await leads.homes.ask_move("agv", OWN, own=OWN)
        home = await leads.until(lambda home: home.problem)
        assert "the lead of the shard 'east' does not answer" in home.problem
