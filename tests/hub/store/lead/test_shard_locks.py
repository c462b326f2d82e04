"""Each shard's lead has a lock of its own, and hubs that divide the sites otherwise have none."""

import asyncio
import contextlib
import threading

import pytest
import sqlalchemy as sa
from patience import PATIENCE_S, stays, until_answered

from talaia.hub.errors import CannotStart, StoreDown
from talaia.hub.history.engine import open_engine
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_tables import channel
from talaia.hub.store.lead.hub_plan import agree_on_plan, read_shards
from talaia.hub.store.lead.lead_claim import claim_lead
from talaia.hub.store.lead.lead_lock import LeadLock
from talaia.hub.store.lead.only_hub import hold_only_hub

from ...databases import empty_database, make_tables

KEY = "a" * 64
# A hub that looks so seldom stands still for the others (s).
STILL_S = 600.0


@pytest.fixture(params=["postgresql", "mariadb"])
def url(request):
    # Not a copy: whoever made it on MariaDB is still in it, and would be ended by a take-over.
    with empty_database(request.param) as url:
        make_tables(url)
        yield url


@contextlib.contextmanager
def connected(url, lock):
    """Give a connection to the history as a hub has it that leads by a lock."""
    engine = open_engine(url, writes=True, on_connect=lock.check_connection)
    try:
        with engine.connect() as connection:
            yield connection
    finally:
        engine.dispose()


def answers(connection) -> bool:
    try:
        return connection.scalar(sa.text("SELECT 1")) == 1
    except (sa.exc.SQLAlchemyError, OSError):
        return False


class Held:
    """A lock of a shard that is tried for, and what was said of it."""

    def __init__(self, url, shard="main", shards=("east", "west"), **more) -> None:
        """Prepare to try for ``shard``, on the database at ``url``."""
        self.taken, self.lost = threading.Event(), threading.Event()
        said = {"taken": self.taken.set, "lost": self.lost.set}
        self.lock = LeadLock(url, shard=shard, shards=shards, **said, **more)

    def __enter__(self):
        self.lock.start_looking()
        assert self.lock.tried.wait(PATIENCE_S)
        return self

    def __exit__(self, *_exc) -> None:
        self.lock.stop_looking()


def agree(url, shards, shard="main") -> None:
    async def agree() -> None:
        database = Database(url)
        await agree_on_plan(database, shards, shard=shard)
        await database.close()

    asyncio.run(agree())


async def end_session(database, lock) -> None:
    """End the session that has a lock, as a network does."""
    async with database.read() as connection:
        await connection.execute(sa.text(lock._words.end), {"session": lock._session})


def test_each_shard_has_one_lead_and_a_hub_may_have_several(url) -> None:
    agree(url, ["east", "west"])
    with Held(url) as main, Held(url, "east") as east, Held(url, "west") as west:
        for held in (main, east, west):
            assert held.taken.wait(PATIENCE_S)
        with Held(url, "east") as other:
            assert not other.taken.is_set()
            west.lock.stop_looking()
            with Held(url, "west") as next_one:
                assert next_one.taken.wait(PATIENCE_S)
            assert not other.taken.is_set()
            with connected(url, main.lock), connected(url, east.lock):
                # One that has not this shard, and one that has it no more.
                for refused in (other.lock, west.lock):
                    with pytest.raises(sa.exc.OperationalError, match="does not lead any more"):
                        connected(url, refused).__enter__()


@pytest.mark.parametrize("taken", ["east", "main"])
def test_a_lead_that_stands_still_is_ended_and_other_shards_go_on(url, taken) -> None:
    agree(url, ["east", "west"])
    left = [shard for shard in ("main", "east", "west") if shard != taken]
    with contextlib.ExitStack() as stack:
        others = [stack.enter_context(Held(url, shard)) for shard in left]
        still = stack.enter_context(Held(url, taken, look_s=STILL_S))
        kept = [stack.enter_context(connected(url, other.lock)) for other in others]
        ended = stack.enter_context(connected(url, still.lock))
        assert all(map(answers, (*kept, ended)))
        follower = stack.enter_context(Held(url, taken))
        assert follower.taken.wait(PATIENCE_S)
        assert not answers(ended)
        assert all(map(answers, kept))
        # Their locks are theirs yet: each may open one more.
        for other in others:
            with connected(url, other.lock) as more:
                assert answers(more)


async def test_connections_to_accounts_are_a_shards_too(url) -> None:
    await asyncio.to_thread(agree, url, ["east"])
    with Held(url, "east", shards=["east"]) as east, Held(url, "east", shards=["east"]) as other:
        assert east.taken.wait(PATIENCE_S)
        leading = Database(url, on_connect=east.lock.check_connection)
        refused = Database(url, on_connect=other.lock.check_connection)
        async with leading.read() as connection:
            watching = await connection.scalar(sa.text(east.lock._words.own))
        looking = Database(url)
        async with looking.read() as connection:
            found = await connection.scalars(sa.text(east.lock._words.others))
            assert set(found) == {watching}
        await looking.close()
        with pytest.raises(StoreDown, match="does not lead any more"):
            async with refused.read():
                pass
        await leading.close()
        await refused.close()


def test_main_ends_what_a_hub_of_before_the_division_has_open(url) -> None:
    with Held(url, shards=(), look_s=STILL_S) as still, connected(url, still.lock) as ended:
        assert answers(ended)
        with Held(url) as follower:
            assert follower.taken.wait(PATIENCE_S)
            assert not answers(ended)


async def test_a_lock_is_not_tried_for_while_it_may_not_be(url) -> None:
    await asyncio.to_thread(agree, url, ["east", "west"])
    may = threading.Event()
    held = Held(url, "east", may_take=may.is_set, look_s=0.02)
    with held:
        await stays(0.3, lambda: not held.taken.is_set(), "it was not tried for")
        # How fast the database answers is known all the same.
        assert held.lock.answered_ms
        may.set()
        assert await asyncio.to_thread(held.taken.wait, PATIENCE_S)


async def test_a_hub_with_other_shards_leads_none_until_those_of_before_are_gone(url) -> None:
    await asyncio.to_thread(agree, url, ["east"])
    east = Held(url, "east", shards=["east"])
    east_anew = Held(url, "east", shards=["east", "west"], look_s=0.02)
    main_anew = Held(url, "main", shards=["east", "west"], look_s=0.02)
    alone = Held(url, "main", shards=(), look_s=0.02)
    with east:
        assert east.taken.wait(PATIENCE_S)
        news = (east_anew, main_anew, alone)
        with east_anew, main_anew:
            with alone:
                await stays(
                    0.5, lambda: not any(held.taken.is_set() for held in news), "none of them leads"
                )
            east.lock.stop_looking()
            assert await asyncio.to_thread(main_anew.taken.wait, PATIENCE_S)
            # East follows once it is written down.
            assert not east_anew.taken.is_set()
            await asyncio.to_thread(agree, url, ["west", "east"])
            assert await asyncio.to_thread(east_anew.taken.wait, PATIENCE_S)


async def test_a_hub_alone_is_refused_while_a_shard_has_a_lead(url) -> None:
    await asyncio.to_thread(agree, url, ["east"])
    with Held(url, "east", shards=["east"]) as east:
        assert east.taken.wait(PATIENCE_S)
        for shards in ((), ("east",)):
            with pytest.raises(CannotStart, match="another hub uses this database"):
                await hold_only_hub(url, print, shards=shards, wait_s=0.1).__aenter__()
    async with hold_only_hub(url, print, shards=["east"]):
        with Held(url, "east", shards=["east"]) as other:
            assert not other.taken.is_set()


async def test_whoever_led_a_shard_of_before_leads_none_when_it_comes_again(url) -> None:
    database = Database(url)
    await agree_on_plan(database, ["east"])
    with Held(url, "east", shards=["east"]) as east:
        assert east.taken.wait(PATIENCE_S)
        east.lock.remember_epoch(await claim_lead(database, name="a", seal_hash=KEY, shard="east"))
        # What it has open yet, while its lock is gone for a moment.
        with connected(url, east.lock) as former:
            assert answers(former)
            await end_session(database, east.lock)
            await agree_on_plan(database, ())
            assert not answers(former)
        assert await asyncio.to_thread(east.lost.wait, PATIENCE_S)
    await database.close()


async def test_a_shards_lead_leads_on_when_its_lock_was_gone_for_a_moment(url) -> None:
    database = Database(url)
    await agree_on_plan(database, ["east"])
    for shard in ("main", "main", "east"):
        epoch = await claim_lead(database, name="a", seal_hash=KEY, shard=shard)
    with Held(url, "east", shards=["east"]) as east:
        assert east.taken.wait(PATIENCE_S)
        east.lock.remember_epoch(epoch)
        before = east.lock._session
        await end_session(database, east.lock)

        async def leads_anew() -> bool:
            return east.lost.is_set() or east.lock._session not in (None, before)

        await until_answered(leads_anew)
        assert not east.lost.is_set()
    await database.close()


async def test_a_plan_is_not_changed_while_a_shard_has_a_lead(url) -> None:
    database = Database(url)
    await agree_on_plan(database, ["east"])
    with Held(url, "east", shards=["east"]) as east:
        assert east.taken.wait(PATIENCE_S)
        with pytest.raises(CannotStart, match="a hub with other shards leads 'east' yet"):
            await agree_on_plan(database, ["west"], wait_s=0.1)
    assert await read_shards(database) == ["east"]
    await agree_on_plan(database, ["west"])
    assert await read_shards(database) == ["west"]
    with pytest.raises(CannotStart, match=r"have the shards west .* the shards east"):
        await agree_on_plan(database, ["east"], shard="east")
    await database.close()


async def test_each_shards_lead_has_numbers_of_its_own_and_the_key_of_all(url) -> None:
    database = Database(url)
    for shard, epoch in (("main", 1), ("east", 1), ("east", 2), ("main", 2)):
        assert await claim_lead(database, name="a", seal_hash=KEY, shard=shard) == epoch
    with pytest.raises(CannotStart, match=r"another seal\.key"):
        await claim_lead(database, name="stranger", seal_hash="b" * 64, shard="west")
    await database.close()


async def test_sites_whose_history_is_here_get_rows_before_they_are_divided(url) -> None:
    database = Database(url)
    homes = HistoryHomes(database)
    await homes.add_home("arm", "east")
    async with database.write() as connection:
        row = {"saved_row": 0, "longest_us": 0, "since_us": 0}
        for number, site in enumerate(("agv", "arm", "drone")):
            row |= {"id": number, "site": site, "address": "power/voltage"}
            await connection.execute(sa.insert(channel).values(row))
    await agree_on_plan(database, ["east"])
    found = {home.site: home.server for home in await homes.list_homes()}
    assert found == {"agv": "own", "arm": "east", "drone": "own"}
    await database.close()


async def test_whoever_stands_still_within_a_transaction_keeps_the_turn_for_seconds_alone(
    url,
) -> None:
    words = "SHOW idle_in_transaction_session_timeout"
    if "mariadb" in url:
        words = "SELECT @@idle_transaction_timeout"
    found = []
    for shares_turn in (True, False):
        database = Database(url, shares_turn=shares_turn)
        async with database.write():
            pass
        # In another transaction of the same connection.
        async with database.read() as connection:
            found.append(str(await connection.scalar(sa.text(words))))
        await database.close()
    assert found[0] in {"10s", "10"}
    assert found[1] == "0"
