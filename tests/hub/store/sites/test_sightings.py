"""What the database keeps of sightings, on every kind of database."""

from __future__ import annotations

import pytest

from talaia.clock import HandClock
from talaia.hub.store.audit import Audit, AuditEntry, AuditFilter
from talaia.hub.store.sites.sightings import Sighted, SightingsAsked, SightingStore

PICTURE = bytes(range(256)) * 200
SEEN = Sighted("agv", "camera/front", "person", 100, 0, 1, 0.7, 5, "boot-1", "", PICTURE)
OVER = SEEN._replace(ended_us=200, many=3, confidence=0.9, told_us=6, picture=b"")
CAMERAS = ("camera/front",)


def note(sighted: Sighted) -> AuditEntry:
    return AuditEntry(1_000, "sighting", site=sighted.site, device="camera", message=sighted.label)


@pytest.fixture
def store(database) -> SightingStore:
    return SightingStore(database)


async def test_a_sighting_is_one_row_and_one_line_however_often_it_is_told(database, store):
    (begun,) = await store.save_sightings([SEEN], note)
    assert (begun.again, begun.entry, begun.kept.pictured) == (False, None, True)
    assert [each.id for each in await store.list_open()] == [begun.kept.id]
    (over,) = await store.save_sightings([OVER], note)
    assert (over.kept.id, over.again, over.kept.pictured) == (begun.kept.id, False, True)
    assert over.kept.noted_us == over.entry.time_us == 1_000
    assert await store.save_sightings([OVER._replace(told_us=9)], note) == []
    (later,) = await store.save_sightings([OVER._replace(ended_us=300)], note)
    assert (later.again, later.entry) == (True, None)
    assert await store.list_open() == []
    audit = Audit(database, HandClock())
    rows, _ = await audit.find_records(AuditFilter(kind="sighting"), 10)
    assert len(rows) == 1
    assert (await audit.verify_chain()).broken == 0
    assert await store.sighting_picture("agv", begun.kept.id) == ("camera/front", PICTURE)
    assert await store.sighting_picture("moon", begun.kept.id) is None


async def test_lines_of_one_moment_lead_each_to_its_own_sighting(store):
    dog = OVER._replace(label="dog")
    first, second = await store.save_sightings([OVER, dog], note)
    times = {first.entry.time_us, second.entry.time_us}
    assert times == {1_000, 1_001}
    found = await store.find_noted("agv", times)
    assert {each.noted_us: each.sighted.label for each in found} == {1_000: "person", 1_001: "dog"}
    assert await store.find_noted("moon", times) == []


async def test_names_are_told_apart_by_case_and_pages_follow_each_other(store):
    rows = [OVER._replace(began_us=at, ended_us=at + 1) for at in (10, 30, 20, 30_000)]
    await store.save_sightings([*rows, OVER._replace(began_us=30, label="PERSON")], note)
    assert await store.seen_labels("agv") == sorted(
        [("camera/front", "PERSON"), ("camera/front", "person")]
    ) or await store.seen_labels("agv") == [("camera/front", "person"), ("camera/front", "PERSON")]
    asked = SightingsAsked(cameras=CAMERAS, label="person")
    page, more = await store.find_sightings("agv", asked, 2)
    assert ([each.sighted.began_us for each in page], more) == ([30_000, 30], True)
    rest = SightingsAsked(cameras=CAMERAS, label="person", before=page[-1].id)
    page, more = await store.find_sightings("agv", rest, 2)
    assert ([each.sighted.began_us for each in page], more) == ([20, 10], False)
    assert await store.find_sightings("agv", SightingsAsked(), 2) == ([], False)


async def test_the_oldest_go_and_what_is_in_sight_stays(store):
    rows = [OVER._replace(began_us=at, ended_us=at + 1, told_us=at) for at in (10, 20, 30)]
    await store.save_sightings([SEEN._replace(began_us=1, told_us=1), *rows], note)
    assert await store.delete_old(11, 100) == 1
    assert await store.delete_old(0, 2) == 1
    found, _ = await store.find_sightings("agv", SightingsAsked(cameras=CAMERAS), 10)
    assert [each.sighted.began_us for each in found] == [30, 1]
