"""Which rows of a shared database are a shard's own, on each database."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sqlalchemy import delete, insert, select

from talaia.clock import SECOND, HandClock, SystemClock
from talaia.hub.archive.frame_queues import FrameQueues
from talaia.hub.archive.frame_rows import HookState, MeasureState
from talaia.hub.sharding.own_shard import OwnShard
from talaia.hub.sharding.plan import MAIN, ShardPlan, WholeShard
from talaia.hub.store.alarm_tables import alarm_definitions
from talaia.hub.store.alarms.alarm_states import AlarmStore
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.shard_handover import ShardHandover
from talaia.hub.store.missions.mission_store import MissionStore
from talaia.hub.store.observing.request_rows import insert_requests, insert_row
from talaia.hub.store.observing.request_store import RequestStore
from talaia.hub.store.sites.recordings import Recorded, RecordingList, RecordingState
from talaia.hub.store.sites.robot_log import RobotLogStore, StoredLine
from talaia.hub.store.sites.sightings import Sighted, SightingStore
from talaia.hub.store.tables import frames

from ..store.observing.test_observing_store import Office, proposal

PLAN = ShardPlan(("east", "west"))
# ``south`` is on another server that is no shard.
HOMES = {"a": "east", "b": "west", "c": "south"}
SITES = ("a", "b", "c", "d")
OWN = {MAIN: ["c", "d"], "east": ["a"], "west": ["b"]}


@pytest.fixture(params=sorted(OWN))
async def shard(request, database):
    homes = HistoryHomes(database)
    for site, server in HOMES.items():
        await homes.add_home(site, server)
    return OwnShard(request.param, PLAN, homes, ShardHandover(database))


async def test_rows_and_names_say_the_same_of_each_site(shard, database) -> None:
    table = alarm_definitions
    async with database.write() as connection:
        rows = [{"site": site, "alarm": "a", "definition": "", "who": "", "changed_us": 1}
                for site in SITES]  # fmt: skip
        await connection.execute(insert(table), rows)
    async with database.read() as connection:
        query = select(table.c.site).where(*shard.own_rows(table.c.site)).order_by(table.c.site)
        found = list((await connection.execute(query)).scalars())
    assert found == OWN[shard.name]
    await shard.open()
    assert [site for site in SITES if shard.has_site(site)] == found
    # The engine reads them so.
    assert (
        sorted(one.site for one in await AlarmStore(database, shard.own_rows).list_made()) == found
    )
    # Deleting, too.
    async with database.write() as connection:
        await connection.execute(delete(table).where(*shard.own_rows(table.c.site)))
    left = await AlarmStore(database).list_made()
    assert sorted(one.site for one in left) == [site for site in SITES if site not in found]


async def test_a_site_that_is_new_since_is_known_once_it_is_read_again(shard, database) -> None:
    await shard.open()
    await HistoryHomes(database).add_home("new", shard.name if shard.name != MAIN else "east")
    is_own = shard.name != MAIN
    assert await shard.look_up("d") is (shard.name == MAIN)
    await shard.refresh()
    assert shard.has_site("new") is is_own


async def test_what_grows_old_goes_where_it_is_own(shard, database) -> None:
    clock = SystemClock()
    sightings = SightingStore(database, shard.own_rows)
    seen = [
        Sighted(site, "a/b", "cat", 1, 2, many=1, confidence=1, told_us=3, boot="1")
        for site in SITES
    ]
    await sightings.save_sightings(seen, lambda _sighted: None)
    log = RobotLogStore(database, clock, own=shard.own_rows)
    for site in SITES:
        await log.store_lines(site, "boot", 0, [StoredLine(1, 20, "", "said", "", "", 0, 0)])
    assert await sightings.delete_old(10, 100) == len(OWN[shard.name])
    assert await log.delete_old(10, 100) == len(OWN[shard.name])


async def test_lists_of_all_sites_are_of_own_ones(shard, database) -> None:
    rows = RecordingList(database, shard.own_rows)
    for site in SITES:
        await rows.save_recording(
            Recorded(
                site, "r1", RecordingState.COMPLETE, why="", who="", note="", begin_us=1, end_us=2,
                size=1, have=1, messages=1, digest="0", topics=(),
            )
        )  # fmt: skip
    assert sorted(row.site for row in await rows.list_recordings()) == OWN[shard.name]
    # The words are taken by each database, also where there is nothing.
    clock = SystemClock()
    assert await MissionStore(database, clock, shard.own_rows).due_missions(2**53) == []
    assert await MissionStore(database, clock, shard.own_rows).unfinished_runs() == []
    assert await RequestStore(database, clock, shard.own_rows).expire_requests() == []
    assert await AlarmStore(database, shard.own_rows).load_states() == {}


async def test_pictures_are_measured_and_handed_over_where_their_site_is_own(
    shard, database
) -> None:
    row = {
        "device": "cam", "night": "2026-01-01", "name": "a.fits", "time_us": 1, "target": "",
        "target_key": "", "filter": "", "kind": "light", "width": 1, "height": 1, "bytes": 1,
        "digest": "0", "problems": "",
    }  # fmt: skip
    for measured, hook in ((MeasureState.WAITS, 0), (MeasureState.MEASURED, HookState.WAITS)):
        async with database.write() as connection:
            await connection.execute(delete(frames))
            states = {"measured": measured, "hook": hook}
            # From the last site on, so that the oldest is not the first.
            rows = [{"site": site, **row, **states} for site in reversed(SITES)]
            await connection.execute(insert(frames), rows)
        queues = FrameQueues(database, None, shard.own_rows)
        found = await (queues.next_for_hook() if hook else queues.next_unmeasured())
        assert found.site == OWN[shard.name][-1]


async def test_requests_expire_where_their_site_is_own(shard, database) -> None:
    clock = HandClock()
    office = await Office(database, clock).begin()
    for site in SITES:
        await office.proposals.add_proposal(proposal(site=site))
    async with database.write() as connection:
        for site in SITES:
            group = replace(office.kept(), site=site)
            number = await insert_row(connection, group, 1)
            await insert_requests(connection, number, group, who="ada", now_us=1)
    clock.advance(3601 * SECOND)
    store = RequestStore(database, clock, shard.own_rows)
    assert sorted(one.site for one in await store.expire_requests()) == OWN[shard.name]
    assert await store.expire_requests() == []


async def test_a_hub_of_all_sites_leaves_no_row_out(database) -> None:
    assert WholeShard().own_rows(alarm_definitions.c.site) == ()
    await HistoryHomes(database).add_home("a", "east")
    await WholeShard().refresh()
    assert WholeShard().has_site("a")
