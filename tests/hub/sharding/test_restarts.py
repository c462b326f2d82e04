"""A hub that begins or ends touches nothing of what another one has under way."""

from __future__ import annotations

import pytest
from patience import until_answered
from sqlalchemy import insert, select

from talaia.clock import SystemClock
from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.audit import Audit, AuditFilter
from talaia.hub.store.mission_tables import missions
from talaia.hub.store.missions.mission_store import MissionStore, RunRecord
from talaia.hub.store.sites.recordings import Recorded, RecordingList, RecordingState
from talaia.hub.store.sites.sightings import Sighted, SightingStore
from talaia.hub.store.tables import users
from talaia.model.missions.mission import Mission
from talaia.model.missions.mission_file import write_mission_json

from .two_shards import AGV, EAST, LAB

BOTH = (AGV, LAB)
PATROL = write_mission_json(Mission(name="Patrol", steps=()))


@pytest.fixture
async def known(shards):
    """Both hubs, each of which knows its site."""
    for site in BOTH:
        await shards.gateway(site)
    return shards


async def begin_anew(shards, shard: str) -> None:
    await shards.end(shard)
    await shards.start(shard)


async def test_a_mission_goes_on_while_the_hub_of_other_sites_begins_anew(known) -> None:
    store = MissionStore(known.database, SystemClock())

    async def states() -> dict[str, str]:
        return {site: (await store.list_runs(site, 1))[0].state for site in BOTH}

    for site in BOTH:
        await store.add_run(
            RunRecord(site, 1, "Patrol", who="operator", begun_by="operator", began_us=1)
        )
    await begin_anew(known, MAIN)
    assert await states() == {AGV: "running", LAB: "interrupted"}
    await begin_anew(known, EAST)
    assert await states() == {AGV: "interrupted", LAB: "interrupted"}


async def test_a_mission_that_is_due_is_the_matter_of_the_hub_that_has_its_site(known) -> None:
    store = MissionStore(known.database, SystemClock())

    async def runs() -> dict[str, list[str]]:
        return {site: [run.state for run in await store.list_runs(site, 9)] for site in BOTH}

    for shard in (MAIN, EAST):
        await known.end(shard)
    async with known.database.write() as connection:
        owner = await connection.scalar(select(users.c.id).where(users.c.name == "operator"))
        row = {"owner_id": owner, "text": PATROL, "due_us": 1, "name": "Patrol", "changed_us": 1}
        await connection.execute(insert(missions), [{"site": site, **row} for site in BOTH])
    await known.start(MAIN)

    async def is_missed(site: str) -> bool:
        return (await runs())[site] == ["missed"]

    # What is long past its time is told of, and not done.
    await until_answered(lambda: is_missed(LAB))
    assert await runs() == {AGV: [], LAB: ["missed"]}
    await known.start(EAST)
    await until_answered(lambda: is_missed(AGV))
    assert await runs() == {AGV: ["missed"], LAB: ["missed"]}


async def test_what_is_in_sight_stays_so_while_the_hub_of_other_sites_begins_anew(known) -> None:
    store = SightingStore(known.database)
    # The hub looked itself, and only it can say that it sees no more.
    seen = [
        Sighted(site, "base/front", "person", 1, 0, many=1, confidence=1, told_us=1, boot="hub 1")
        for site in BOTH
    ]
    await store.save_sightings(seen, lambda _sighted: None)
    await known.end(EAST)
    await begin_anew(known, MAIN)
    await known.end(MAIN)
    assert [kept.sighted.site for kept in await store.list_open()] == [AGV]
    await known.start(EAST)
    await known.end(EAST)
    assert await store.list_open() == []


async def test_lists_of_recordings_are_brought_together_by_the_hub_that_has_the_site(known) -> None:
    rows = RecordingList(known.database)
    for site in BOTH:
        # Of the other hub it may lie in a folder that is not this one's.
        await rows.save_recording(
            Recorded(
                site, "r1", RecordingState.COMPLETE, why="", who="", note="", begin_us=1, end_us=2,
                size=1, have=1, messages=1, digest="0", topics=(),
            )
        )  # fmt: skip

    async def states() -> dict[str, str]:
        return {site: (await rows.recordings_of(site))[0].state for site in BOTH}

    await begin_anew(known, MAIN)
    assert await states() == {AGV: "complete", LAB: "failed"}
    await begin_anew(known, EAST)
    assert await states() == {AGV: "failed", LAB: "failed"}


async def test_a_file_in_the_folder_is_put_into_the_list_by_the_hub_that_has_the_site(
    known,
) -> None:
    rows = RecordingList(known.database)
    for site in BOTH:
        folder = known.settings.data / "recordings" / site
        folder.mkdir(parents=True)
        (folder / "20260101T000000-1.mcap").write_bytes(b"recorded")
    await begin_anew(known, MAIN)
    assert [len(await rows.recordings_of(site)) for site in BOTH] == [0, 1]


async def test_the_log_names_the_shard_that_began_and_is_one_chain(known) -> None:
    await begin_anew(known, EAST)
    audit = Audit(known.database, SystemClock())
    for hub in (known.main, known.east):
        await hub.hub.audit.log.wait_written()
    rows, _ = await audit.find_records(AuditFilter(kind="hub "), 10)
    told = [(row.entry.kind, row.entry.message) for row in reversed(rows)]
    assert told == [
        ("hub started", "shard main"),
        ("hub started", "shard east"),
        ("hub stopped", "shard east"),
        ("hub started", "shard east"),
    ]
    assert not (await audit.verify_chain()).broken


async def test_one_hub_signs_heads_and_offers_to_set_up(known) -> None:
    assert known.main.hub.audit.heads is not None
    assert known.east.hub.audit.heads is None
    assert {task.name for task in known.east.hub.audit.tasks} == {"write"}
