"""What cameras see, from a gateway's word to pages, logbook and alarms."""

from __future__ import annotations

import asyncio
import dataclasses
import time

import numpy as np
import pytest
import simplejpeg
from hypothesis import given, strategies as st
from msgspec import structs
from patience import PATIENCE_S
from sqlalchemy import insert
from sqlalchemy.exc import DataError

from talaia.hub.alarms.state_machine import What
from talaia.hub.errors import StoreDown
from talaia.hub.live.alarms.alarm_pictures import AlarmPictures
from talaia.hub.live.detection.sightings import KIND, OWN
from talaia.hub.live.pictures.jpeg_validator import NotAPicture, bare_jpeg
from talaia.hub.store.alarms.notification_outbox import OutboxMessage, OutboxNotice
from talaia.hub.store.sites.sightings import Sighted
from talaia.hub.store.tables import sightings
from talaia.model.alarms.alarm import Severity
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.wire import browser as page_wire, frames
from talaia.wire.browser import EventUpdate, SightingUpdate

from ..conftest import DESCRIPTION, RunningHub

# Its camera looks for persons and dogs.
WATCHED = DESCRIPTION
FRONT = "camera/front"
BEGAN = 1_700_000_000_000_000
MINUTE = 60_000_000
PATH = "/api/sites/agv/sightings"


def unwatched() -> str:
    """Describe the same vehicle with a camera that looks for nothing."""
    site = load_site(WATCHED)
    camera = site.devices["camera"]
    front = structs.replace(camera.streams["front"], detect=None)
    camera = structs.replace(camera, streams={"front": front}, signals={})
    devices = {**site.devices, "camera": camera}
    return dump_site(structs.replace(site, devices=devices, interlocks={}))


def jpeg(width: int = 64, height: int = 48) -> bytes:
    return simplejpeg.encode_jpeg(np.full((height, width, 3), 90, np.uint8))


def seen(**said) -> frames.SightingReport:
    told = {"stream": FRONT, "label": "person", "many": 1, "confidence": 0.8, "began_us": BEGAN}
    return frames.SightingReport(**{**told, **said})


@pytest.fixture
async def gateway(hub):
    """The connected gateway of a vehicle whose camera is watched."""
    gateway = await hub.gateway()
    welcome = await gateway.hello(WATCHED)
    assert "seen" in welcome.takes
    return gateway


async def listed(hub, **asked) -> list[dict]:
    answer = await (await hub.client("operator")).get(PATH, params=asked)
    assert answer.status_code == 200, answer.text
    return answer.json()["sightings"]


async def test_a_person_is_seen_and_gone_on_pages_in_the_list_and_in_the_logbook(hub, gateway):
    page = await hub.page("operator")
    await gateway.say(seen(thumbnail=jpeg()))
    news = await page.hear(SightingUpdate)
    assert (news.camera, news.label, news.ended_us) == (FRONT, "person", 0)
    assert await listed(hub) == [
        {
            "id": str(news.id),
            "camera": FRONT,
            "label": "person",
            "many": 1,
            "confidence": 0.8,
            "began_us": BEGAN,
            "ended_us": None,
            "picture": True,
            "seen": False,
            "story": None,
        }
    ]
    client = await hub.client("operator")
    assert (await client.get("/api/sites/agv/events", params={"kind": KIND})).json()["events"] == []
    await gateway.say(seen(many=2, confidence=0.9))
    assert (await page.hear(SightingUpdate)).many == 2
    story = {
        "path": [(BEGAN, 0.25, 0.5), (BEGAN + MINUTE, 1.0, 0.75)],
        "stays": [frames.ZoneStay(zone="Mat", entries=2, dwell_s=7.5)],
        "crossings": [frames.LineCrossing(line="Door", left=1, right=0)],
        "speed": 1.25,
    }
    await gateway.say(seen(many=2, confidence=0.9, ended_us=BEGAN + 3 * MINUTE, **story))
    assert (await page.hear(SightingUpdate)).ended_us == BEGAN + 3 * MINUTE
    assert (await listed(hub))[0]["story"] == {
        "path": [
            {"time_us": BEGAN, "x": 0.25, "y": 0.5},
            {"time_us": BEGAN + MINUTE, "x": 1.0, "y": 0.75},
        ],
        "stays": [{"zone": "Mat", "entries": 2, "dwell_s": 7.5}],
        "crossings": [{"line": "Door", "left": 1, "right": 0}],
        "speed": 1.25,
    }
    line = await page.hear(EventUpdate, lambda each: each.kind == KIND)
    # The site's own time: an hour before UTC in winter.
    assert line.message == "person seen at Front camera 23:13–23:16 (at most 2)"
    assert line.time_us == BEGAN
    events = (await client.get("/api/sites/agv/events", params={"kind": KIND})).json()["events"]
    assert [each["message"] for each in events] == [line.message]
    assert events[0]["sighting"]["id"] == str(news.id)
    assert events[0]["sighting"]["ended_us"] == BEGAN + 3 * MINUTE
    picture = await client.get(f"{PATH}/{news.id}/picture")
    assert picture.headers["content-type"] == "image/jpeg"
    assert picture.headers["x-content-type-options"] == "nosniff"
    assert "sandbox" in picture.headers["content-security-policy"]
    assert simplejpeg.decode_jpeg(picture.content).shape == (48, 64, 3)


async def test_what_is_told_twice_is_kept_and_noted_once(hub, gateway):
    page = await hub.page("operator")
    over = seen(ended_us=BEGAN + MINUTE)
    await gateway.say(seen())
    await gateway.say(over)
    await page.hear(SightingUpdate, lambda news: news.ended_us)
    await gateway.say(over)
    # Another, so that it is known when the repetition has been dealt with.
    await gateway.say(seen(began_us=BEGAN + 2 * MINUTE))
    await page.hear(SightingUpdate, lambda news: news.began_us > BEGAN)
    assert [each["began_us"] for each in await listed(hub)] == [BEGAN + 2 * MINUTE, BEGAN]
    assert not any(isinstance(each, SightingUpdate) for each in page.heard)
    client = await hub.client("operator")
    events = (await client.get("/api/sites/agv/events", params={"kind": KIND})).json()["events"]
    assert len(events) == 1


async def test_sightings_are_found_by_time_camera_and_class_and_page_by_page(hub, gateway):
    page = await hub.page("operator")
    for at in range(4):
        began = BEGAN + at * MINUTE
        label = "dog" if at == 2 else "person"
        await gateway.say(seen(label=label, began_us=began, ended_us=began + 1_000_000))
    await gateway.say(seen(began_us=BEGAN + 9 * MINUTE))
    await page.hear(SightingUpdate, lambda news: news.began_us == BEGAN + 9 * MINUTE)

    async def minutes(**asked) -> list[int]:
        return [(each["began_us"] - BEGAN) // MINUTE for each in await listed(hub, **asked)]

    assert await minutes() == [9, 3, 2, 1, 0]
    assert await minutes(label="dog") == [2]
    assert await minutes(camera="camera/back") == []
    assert await minutes(from_us=BEGAN + MINUTE + 1, to_us=BEGAN + 2 * MINUTE) == [2, 1]
    # What is in sight is so until it is over.
    assert await minutes(from_us=BEGAN + 20 * MINUTE) == [9]
    assert await minutes(open=True) == [9]
    assert await minutes(open=False, limit=2) == [3, 2]
    last = (await listed(hub, limit=2))[-1]["id"]
    assert await minutes(before=last, limit=2) == [2, 1]
    client = await hub.client("operator")
    assert (await client.get(PATH + "/labels")).json()["labels"] == [
        {"camera": FRONT, "label": "dog"},
        {"camera": FRONT, "label": "person"},
    ]


async def test_each_person_looks_through_what_is_new_to_them_by_day_and_camera(hub, gateway):
    page = await hub.page("operator")
    # The last of the site's own day, and the first two of the next one.
    midnight = 1_700_002_800_000_000
    stay = frames.ZoneStay(zone='Mat "A"', entries=1, dwell_s=2.0)
    for began, stays in ((midnight - 1, []), (midnight, [stay]), (midnight + MINUTE, [])):
        await gateway.say(seen(began_us=began, ended_us=began + 1, stays=stays))
    await page.hear(SightingUpdate, lambda news: news.began_us == midnight + MINUTE)
    client = await hub.client("operator")

    async def days() -> list[tuple[str, int, int]]:
        answer = (await client.get(PATH + "/days")).json()["days"]
        assert {each["camera"] for each in answer} <= {FRONT}
        return [(each["day"], each["count"], each["unseen"]) for each in answer]

    assert await days() == [("2023-11-15", 2, 2), ("2023-11-14", 1, 1)]
    newest, matted, _ = await listed(hub)
    for seen_twice in (True, True):
        asked = {"ids": [matted["id"], "999"], "seen": seen_twice}
        answer = await client.post(PATH + "/seen", json=asked)
        assert answer.json() == {"ids": [matted["id"]]}
    assert await days() == [("2023-11-15", 2, 1), ("2023-11-14", 1, 1)]
    assert [each["seen"] for each in await listed(hub)] == [False, True, False]
    assert matted["id"] not in [each["id"] for each in await listed(hub, unseen=True)]
    assert [each["id"] for each in await listed(hub, zone='Mat "A"')] == [matted["id"]]
    assert await listed(hub, zone="Mat") == []
    # Another person has seen none of it.
    admin = await hub.client("admin")
    assert len((await admin.get(PATH, params={"unseen": True})).json()["sightings"]) == 3
    await client.post(PATH + "/seen", json={"ids": [matted["id"]], "seen": False})
    assert await days() == [("2023-11-15", 2, 2), ("2023-11-14", 1, 1)]
    # Whoever may not see the camera marks nothing, and is not told what there is.
    guest = await hub.client("guest")
    answer = await guest.post(PATH + "/seen", json={"ids": [newest["id"]]})
    assert answer.json() == {"ids": []}
    assert (await guest.get(PATH + "/days")).json() == {"days": []}
    # Marks go with their sighting.
    await client.post(PATH + "/seen", json={"ids": [matted["id"]]})
    assert await hub.hub.sightings.store.delete_old(2**52, 0) == 3
    assert await days() == []


async def test_ten_thousand_sightings_are_counted_by_day_in_a_moment(hub, gateway):
    one = Sighted("agv", FRONT, "person", BEGAN, BEGAN + 1, 1, 0.9, BEGAN, "boot")._asdict()
    rows = [
        {**one, "began_us": BEGAN + at * MINUTE, "noted_us": 0, "pictured": False}
        for at in range(10_000)
    ]
    async with hub.hub.core.database.write() as connection:
        await connection.execute(insert(sightings), rows)
    client = await hub.client("operator")
    began_s = time.process_time()
    answer = (await client.get(PATH + "/days")).json()["days"]
    first = (await client.get(PATH, params={"unseen": True, "limit": 60})).json()
    spent_s = time.process_time() - began_s
    assert sum(each["count"] for each in answer) == 10_000
    assert (len(first["sightings"]), first["more"]) == (60, True)
    # Both together, on a machine that does other things as well.
    assert spent_s < 2.0, f"{spent_s:.2f} s of the processor"


@pytest.mark.parametrize("pictured", [True, False])
async def test_a_message_about_a_person_carries_the_picture_of_that_person(hub, pictured):
    gateway, page = await hub.gateway(), await hub.page("operator")
    text = (
        "\nalarms:\n  guest: {name: Guest, kind: detection, stream: camera/front, label: person}\n"
        "  late: {name: Late, kind: stale, signal: base/speed}\n"
    )
    await gateway.hello(WATCHED + text)
    picture = jpeg()
    await gateway.say(seen(thumbnail=picture if pictured else b""))
    news = await page.hear(SightingUpdate)
    pictures = AlarmPictures(hub.hub.core.sites, hub.hub.sightings.store)

    async def found(alarm: str, what: What = What.RAISED, device: str = "camera"):
        line = OutboxNotice(
            1, "agv", alarm, what, Severity.WARNING, "Guest", "seen", BEGAN + 1, device
        )
        return await pictures.find_picture(OutboxMessage("k", 1, 1, 1, "", "UTC", 1, (line,)))

    shown = await found("guest")
    if not pictured:
        assert shown is None
        return
    assert shown is not None
    assert simplejpeg.decode_jpeg(shown.jpeg).shape == (48, 64, 3)
    client = await hub.client("operator")
    assert (await client.get(shown.path)).content == shown.jpeg
    assert shown.path == f"{PATH}/{news.id}/picture"
    # Not of what is over, nor of another kind of alarm, nor to who was asked about another device.
    assert await found("guest", What.CLEARED) is None
    assert await found("late") is None
    assert await found("guest", device="base") is None


@pytest.mark.parametrize("public", [False, True])
async def test_a_guest_is_told_of_what_a_public_camera_sees_and_of_no_other(hub, public):
    gateway = await hub.gateway()
    shown = "        quality: 70\n        visibility: public\n"
    await gateway.hello(WATCHED.replace("        quality: 70\n", shown) if public else WATCHED)
    operator, guest = await hub.page("operator"), await hub.page("guest")
    await gateway.say(seen(thumbnail=jpeg()))
    news = await operator.hear(SightingUpdate)
    late = await hub.page("guest")
    client = await hub.client("guest")
    found = (await client.get(PATH)).json()["sightings"]
    picture = await client.get(f"{PATH}/{news.id}/picture")
    if public:
        assert (await guest.hear(SightingUpdate)).id == news.id
        assert (await late.hear(SightingUpdate)).id == news.id
        assert [each["id"] for each in found] == [str(news.id)]
        assert picture.status_code == 200
    else:
        assert not any(isinstance(each, SightingUpdate) for each in guest.heard + late.heard)
        assert found == []
        assert picture.status_code == 404
        assert (await client.get(PATH + "/labels")).json()["labels"] == []


async def test_what_the_description_does_not_look_for_is_left_out_and_said_once(
    hub, gateway, caplog
):
    page = await hub.page("operator")
    await gateway.say(seen(label="dragon"))
    await gateway.say(seen(stream="camera/back"))
    await gateway.say(seen(began_us=-5))
    await gateway.say(seen(began_us=2**60))
    await gateway.say(seen(thumbnail=b"<script>alert(1)</script>"))
    await page.hear(SightingUpdate)
    found = await listed(hub)
    # The sighting counts, though its picture is none.
    assert [(each["label"], each["picture"]) for each in found] == [("person", False)]
    assert sum("are left out" in each.message for each in caplog.records) == 1


async def test_a_gateway_that_sees_without_end_is_bounded_and_an_end_is_always_heard(hub, gateway):
    page = await hub.page("operator")
    for at in range(1500):
        await gateway.say(seen(began_us=BEGAN + at))
    await gateway.say(seen(ended_us=BEGAN + MINUTE))
    await page.hear(SightingUpdate, lambda news: news.ended_us)
    client = await hub.client("operator")
    answer = (await client.get(PATH, params={"limit": 500})).json()
    assert (len(answer["sightings"]), answer["more"]) == (500, False)


async def test_another_run_of_the_gateway_ends_what_the_one_before_it_saw(
    hub, gateway, monkeypatch
):
    monkeypatch.setattr("talaia.hub.live.detection.sightings.GRACE_S", 0.0)
    page = await hub.page("operator")
    await gateway.say(seen())
    await page.hear(SightingUpdate)
    await gateway.close()
    same = await hub.gateway()
    await same.hello(WATCHED)
    await same.say(seen(many=3))
    assert (await page.hear(SightingUpdate)).many == 3
    await same.close()
    other = await hub.gateway()
    await other.hello(WATCHED, boot="boot-2")
    assert (await page.hear(SightingUpdate)).ended_us > BEGAN


async def test_a_camera_that_is_watched_no_more_has_nothing_in_sight(hub, gateway):
    page = await hub.page("operator")
    await gateway.say(seen())
    await page.hear(SightingUpdate)
    await gateway.close()
    other = await hub.gateway()
    await other.hello(unwatched())
    assert (await page.hear(SightingUpdate)).ended_us > BEGAN


async def test_what_is_in_sight_outlives_a_restart_of_the_hub(settings, history):
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        page, gateway = await hub.page("operator"), await hub.gateway()
        await gateway.hello(WATCHED)
        await gateway.say(seen())
        await page.hear(SightingUpdate)
        keys = hub.keys
    async with RunningHub(settings, history) as hub:
        hub.keys = keys
        page, gateway = await hub.page("operator"), await hub.gateway()
        assert (await page.hear(SightingUpdate)).ended_us == 0
        await gateway.hello(WATCHED)
        await gateway.say(seen(ended_us=BEGAN + MINUTE))
        assert (await page.hear(SightingUpdate, lambda news: news.ended_us)).many == 1


async def test_nobody_stays_in_sight_of_a_gateway_that_stays_away(hub, gateway, monkeypatch):
    monkeypatch.setattr("talaia.hub.live.detection.sightings._AWAY_S", 0.0)
    page = await hub.page("operator")
    await gateway.say(seen())
    await page.hear(SightingUpdate)
    await gateway.close()
    assert (await page.hear(SightingUpdate)).ended_us > BEGAN


async def test_what_a_killed_hub_saw_itself_is_over_when_it_is_begun_anew(settings, history):
    told = Sighted("agv", FRONT, "person", BEGAN, 0, 1, 0.9, BEGAN + MINUTE, OWN + "killed")
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        await (await hub.gateway()).hello(WATCHED)
        await hub.hub.sightings.store.save_sightings([told], lambda _: None)
    async with RunningHub(settings, history) as hub:
        await hub.hub.sightings.journal.settle_writes()
        assert [each["ended_us"] for each in await listed(hub)] == [BEGAN + MINUTE]


async def test_old_sightings_go_and_what_is_in_sight_stays(settings, history):
    settings = dataclasses.replace(settings, sightings_most=2)
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        page, gateway = await hub.page("operator"), await hub.gateway()
        await gateway.hello(WATCHED)
        await gateway.say(seen())
        for at in range(1, 4):
            began = BEGAN + at * MINUTE
            await gateway.say(seen(began_us=began, ended_us=began + 1))
        await page.hear(SightingUpdate, lambda news: news.began_us == BEGAN + 3 * MINUTE)
        store, now_us = hub.hub.sightings.store, time.time_ns() // 1000
        assert await store.delete_old(now_us - 3_600_000_000, 2) == 2
        assert [each["began_us"] for each in await listed(hub)] == [BEGAN + 3 * MINUTE, BEGAN]
        assert await store.delete_old(now_us + 3_600_000_000, 2) == 1
        assert [each["began_us"] for each in await listed(hub)] == [BEGAN]


async def test_while_the_database_is_away_sightings_wait_with_their_pictures(
    hub, gateway, monkeypatch, caplog
):
    page, store = await hub.page("operator"), hub.hub.sightings.store
    put, tried, ends = store.save_sightings, asyncio.Event(), asyncio.Event()

    async def fails(told, note):
        if not ends.is_set():
            tried.set()
            await ends.wait()
            raise StoreDown("the database does not answer", "")
        return await put(told, note)

    monkeypatch.setattr(store, "save_sightings", fails)
    await gateway.say(seen(thumbnail=jpeg()))
    await tried.wait()
    # Said while the one before is being written.
    await gateway.say(seen(many=2))
    await gateway.say(frames.Beat(n=1, mono_us=1))
    await gateway.hear(frames.BeatReply)
    ends.set()
    assert (await page.hear(SightingUpdate)).many == 2
    assert (await listed(hub))[0]["picture"]
    said = [each.message for each in caplog.records if "sightings" in each.message]
    assert said == ["sightings cannot be kept; they wait", "sightings are kept again"]


async def test_what_the_database_does_not_take_holds_up_nothing(hub, gateway, monkeypatch, caplog):
    page, store = await hub.page("operator"), hub.hub.sightings.store
    put, asked = store.save_sightings, asyncio.Event()

    async def refuses(told, note):
        if told[0].began_us == BEGAN:
            asked.set()
            raise DataError("INSERT", {}, ValueError("not this"))
        return await put(told, note)

    monkeypatch.setattr(store, "save_sightings", refuses)
    await gateway.say(seen())
    await asked.wait()
    await gateway.say(seen(began_us=BEGAN + 1))
    assert (await page.hear(SightingUpdate)).began_us == BEGAN + 1
    assert "sightings cannot be kept, and are left out: 1" in caplog.text


async def test_boxes_reach_the_pages_that_asked_and_the_newest_wins(hub, gateway):
    asks, other = [await hub.viewer("operator", FRONT) for _ in range(2)]
    await gateway.hear(frames.StreamSubscription, lambda watch: watch.streams == [FRONT])
    await asks.say(page_wire.BoxesRequest(on=True))
    watch = await gateway.hear(frames.StreamSubscription, lambda watch: watch.boxes)
    assert (watch.boxes, watch.forms) == ([FRONT], {FRONT: ["jpeg"]})
    camera = await hub.camera()
    thing = frames.DetectedObject(label="dog", score=0.7, left=0.1, top=0.2, right=0.3, bottom=0.4)
    await camera.say(frames.DetectedBoxes(stream=FRONT, seq=3, time_us=7, things=[thing]))
    boxes = await asks.hear(page_wire.CameraPictureBoxes)
    assert (boxes.seq, boxes.time_us, boxes.things) == (3, 7, [thing])
    # Two pictures are under way, so that the next ones wait, and with them their boxes.
    for seq in range(1, 5):
        await camera.say(
            frames.PictureFrame(
                stream=FRONT, seq=seq, time_us=1, mono_us=seq, width=2, height=2, data=b"x"
            )
        )
        if seq <= 2:
            await asks.hear(page_wire.CameraPicture, lambda shot, seq=seq: shot.seq == seq)
            continue
        await camera.say(frames.DetectedBoxes(stream=FRONT, seq=seq, time_us=1, things=[]))
        await camera.say(frames.Beat(n=seq, mono_us=1))
        await camera.hear(frames.BeatReply)
    await asks.say(page_wire.PictureShown(seq=2))
    # No box goes before a picture that waits.
    last = page_wire.CameraPictureBoxes(seq=4, time_us=1, things=[])
    async with asyncio.timeout(PATIENCE_S), asks._news:
        await asks._news.wait_for(lambda: last in asks.heard and 4 in shots_of(asks))
    told = [(type(each), each.seq) for each in asks.heard]
    assert told == [(page_wire.CameraPicture, 4), (page_wire.CameraPictureBoxes, 4)]
    assert not any(isinstance(each, page_wire.CameraPictureBoxes) for each in other.heard)
    gateway.heard.clear()
    await asks.say(page_wire.BoxesRequest(on=False))
    assert (
        await gateway.hear(frames.StreamSubscription, lambda watch: not watch.boxes)
    ).streams == [FRONT]


def shots_of(viewer) -> list[int]:
    return [each.seq for each in viewer.heard if isinstance(each, page_wire.CameraPicture)]


@given(st.binary(max_size=300) | st.binary(max_size=200).map(lambda more: jpeg()[:400] + more))
def test_any_bytes_are_a_picture_or_are_refused(data):
    try:
        found = bare_jpeg(data)
    except NotAPicture:
        pass
    else:
        assert (found[:2], found[-2:]) == (b"\xff\xd8", b"\xff\xd9")
        assert len(found) <= len(data)


def test_a_picture_is_kept_without_what_it_does_not_need():
    data = jpeg()
    remark = b"\xff\xfe\x00\x0e<script></s>"
    place = b"\xff\xe1\x00\x0cExif\x00\x00here"
    found = bare_jpeg(data[:2] + remark + place + data[2:])
    assert b"script" not in found
    assert b"Exif" not in found
    assert (simplejpeg.decode_jpeg(found) == simplejpeg.decode_jpeg(data)).all()


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"GIF89a", "does not begin"),
        (jpeg()[:-2], "cut off"),
        (jpeg()[:300], "cut off"),
        (jpeg() + b"<html>", "follows its end"),
        (jpeg(2000, 40), "2000 × 40 px"),
        (jpeg(4, 4), "4 × 4 px"),
        (b"\xff\xd8\xff\xd9", "before its picture"),
    ],
)
def test_what_is_no_small_picture_is_refused_with_a_reason(data, why):
    with pytest.raises(NotAPicture, match=why):
        bare_jpeg(data)
