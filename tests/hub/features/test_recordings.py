"""Recordings come to the hub piece by piece, are listed, taken away and kept within a size."""

# ruff: noqa: D107

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import time
from zlib import crc32

import pytest
import websockets

from talaia.hub.live.files.recording_files import file_key
from talaia.hub.live.files.recordings import _MOST_COMING
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    PIECE,
    Bye,
    FileOffer,
    FilePiece,
    FileProgress,
    FilmOffer,
    RecorderState,
    RecordingRequest,
)

from ..conftest import DESCRIPTION, RunningHub

RECORDED = DESCRIPTION + "\nrecording: {before: 20}\n"
BODY = os.urandom(3 * PIECE + 1234)
AT = "/api/sites/agv/recordings"
CAMERA, FORMER = "camera/front", "base/former"


def offer(body=BODY, name="20260101T120000Z-abcdef", **more):
    digest = hashlib.sha256(body).hexdigest()
    told = {"begin_us": 1_767_268_800_000_000, "end_us": 1_767_268_860_000_000, **more}
    return FileOffer(
        id=name, size=len(body), digest=digest, why="STOP (software)", who="ada", messages=7,
        topics=["/odom", "/scan"], **told,
    )  # fmt: skip


def piece(at, body=BODY, name="20260101T120000Z-abcdef", size=PIECE):
    data = body[at : at + size]
    return FilePiece(id=name, at=at, check=crc32(data), data=data)


class Files:
    """A gateway's connection that brings files."""

    def __init__(self, connection) -> None:
        self.connection = connection

    async def ask(self, message):
        await self.connection.send(FILES_FROM_GATEWAY.encode(message))
        return FILES_FROM_HUB.decode(await self.connection.recv())

    async def bring(self, body=BODY, name="20260101T120000Z-abcdef", **more):
        """Hand over all of a file as a gateway does."""
        has = await self.ask(offer(body, name, **more))
        while not has.done and not has.refused:
            has = await self.ask(piece(has.have, body, name))
        return has

    async def bring_until_bye(self, body=BODY, name="20260101T120000Z-abcdef"):
        """Hand over a file until the hub sends it away, or has it."""
        has = await self.ask(offer(body, name))
        while isinstance(has, FileProgress) and not has.done and not has.refused:
            has = await self.ask(piece(has.have, body, name))
        return has


async def files(hub):
    return Files(await hub.dial("/gateway/files", {"Authorization": f"Bearer {hub.keys['agv']}"}))


@pytest.fixture
async def recorded_hub(hub):
    gateway = await hub.gateway()
    await gateway.hello(RECORDED)
    hub.linked = gateway
    return hub


async def listed(hub, who="operator"):
    answer = await (await hub.client(who)).get(AT)
    assert answer.status_code == 200, answer.text
    return answer.json()


async def test_a_recording_comes_in_is_listed_downloaded_in_ranges_and_deleted(
    recorded_hub, tmp_path
) -> None:
    hub = recorded_hub
    bringing = await files(hub)
    first = await bringing.ask(offer())
    assert (first.have, first.done) == (0, False)
    assert (await bringing.ask(piece(0))).have == PIECE
    # The connection is cut; what is on the disk is where the next one begins.
    await bringing.connection.close()
    found = await listed(hub)
    assert found["zone"] == "Europe/Madrid"
    (row,) = found["recordings"]
    assert (row["state"], row["size"]) == ("uploading", len(BODY))
    assert row["topics"] == ["/odom", "/scan"]
    operator = await hub.client("operator")
    assert (await operator.get(f"{AT}/{row['id']}/file")).status_code == 409
    bringing = await files(hub)
    assert (await bringing.ask(offer())).have == PIECE
    # A piece that comes twice changes nothing.
    assert (await bringing.ask(piece(0))).have == PIECE
    done = await bringing.bring()
    assert (done.done, done.have) == (True, len(BODY))
    # Offered again, since the answer was lost: it is there.
    assert (await bringing.ask(offer())).done
    (row,) = (await listed(hub))["recordings"]
    assert (row["state"], row["have"], row["why"], row["who"]) == (
        "complete", len(BODY), "STOP (software)", "gateway: ada",
    )  # fmt: skip
    whole = await operator.get(f"{AT}/{row['id']}/file")
    assert whole.content == BODY
    assert whole.headers["content-disposition"].startswith("attachment")
    assert whole.headers["accept-ranges"] == "bytes"
    some = await operator.get(f"{AT}/{row['id']}/file", headers={"Range": "bytes=100-299"})
    assert (some.status_code, some.content) == (206, BODY[100:300])
    beyond = await operator.get(f"{AT}/{row['id']}/file", headers={"Range": "bytes=99999999-"})
    assert beyond.status_code == 416
    assert (await operator.delete(f"{AT}/{row['id']}")).status_code == 403
    admin = await hub.client("admin")
    assert (await admin.delete(f"{AT}/{row['id']}")).status_code == 204
    assert (await admin.delete(f"{AT}/{row['id']}")).status_code == 404
    assert list((tmp_path / "recordings" / "agv").iterdir()) == []
    events = (await admin.get("/api/audit")).json()["rows"]
    kinds = [each["kind"] for each in events]
    assert {"recording stored", "recording downloaded", "recording deleted"} <= set(kinds)


async def test_what_does_not_fit_is_refused_or_sent_away(recorded_hub) -> None:
    hub = recorded_hub
    bringing = await files(hub)
    assert (await bringing.bring()).done
    other = await bringing.ask(offer(b"another"))
    assert "another recording has that name" in other.refused
    assert "cannot be kept" in (await bringing.ask(offer(b"", "empty"))).refused
    for bad in (
        piece(0, name="never-offered"),
        FilePiece(id="20260101T120000Z-abcdef", at=0, check=1, data=b"x"),
        FilePiece(id="20260101T120000Z-abcdef", at=len(BODY), check=crc32(b"x"), data=b"x"),
    ):
        bringing = await files(hub)
        await bringing.ask(offer())
        assert isinstance(await bringing.ask(bad), Bye)
    for name in ("../../etc/passwd", "a/b", ".", "x" * 99, ""):
        bringing = await files(hub)
        raw = FILES_FROM_GATEWAY.encode(offer(name="ok")).replace(
            b"\xa2ok", bytes([0xD9, len(name)]) + name.encode()
        )
        await bringing.connection.send(raw)
        assert isinstance(FILES_FROM_HUB.decode(await bringing.connection.recv()), Bye)


async def test_bytes_that_are_not_what_was_offered_are_asked_for_again(recorded_hub) -> None:
    hub = recorded_hub
    bringing = await files(hub)
    told = offer()
    await bringing.ask(told)
    wrong = bytes(len(BODY))
    has = FileProgress(id=told.id)
    for at in range(0, len(BODY), PIECE):
        has = await bringing.ask(piece(at, wrong))
    assert (has.done, has.have) == (False, 0)
    assert "sent again" in (await listed(hub))["recordings"][0]["note"]
    assert (await bringing.bring()).done


async def test_beyond_the_size_the_oldest_go_and_what_is_larger_is_refused(
    settings, history, tmp_path
) -> None:
    small = dataclasses.replace(settings, recordings_bytes=5_000)
    async with RunningHub(small, history) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(RECORDED)
        bringing = await files(hub)
        for number in range(3):
            body = os.urandom(2_000)
            assert (await bringing.bring(body, f"r{number}", begin_us=number)).done
        assert [each["id"] for each in (await listed(hub))["recordings"]] == ["r2", "r1"]
        assert "larger than all" in (await bringing.bring(os.urandom(6_000), "large")).refused
    assert not (tmp_path / "recordings" / "agv" / "r0.mcap").exists()


async def test_what_a_gateway_announces_or_sends_costs_no_other_site_a_recording(
    settings, history, tmp_path
) -> None:
    small = dataclasses.replace(settings, recordings_bytes=5_000)
    async with RunningHub(small, history) as hub:
        await hub.populate()
        await (await hub.gateway()).hello(RECORDED)
        key = await hub.hub.gateways.registry.new_key("hostile")
        mine = await files(hub)
        assert (await mine.bring(os.urandom(3_000), "mine")).done
        theirs = Files(await hub.dial("/gateway/files", {"Authorization": f"Bearer {key}"}))
        # Announced, and never sent: nothing of anybody goes.
        for number in range(2 * _MOST_COMING):
            huge = offer(os.urandom(5_000), f"h{number}")
            assert not (await theirs.ask(huge)).refused
        assert (await mine.bring(os.urandom(2_000), "more")).done
        # Sent whole, and not what it was said to be; then as it was said to be.
        told = offer(os.urandom(PIECE), "liar")
        await theirs.ask(told)
        assert not (await theirs.ask(piece(0, bytes(PIECE), "liar"))).done
        for number in range(3):
            body = os.urandom(4_000)
            assert (await theirs.bring(body, f"t{number}", begin_us=number)).done
        assert {each["id"] for each in (await listed(hub))["recordings"]} == {"mine", "more"}
    # Nor does it keep more files on the disk than may be on their way.
    assert len(list((tmp_path / "recordings" / "hostile").iterdir())) <= 2 * _MOST_COMING + 4


async def test_an_upload_that_stands_still_for_weeks_ends(settings, history, tmp_path) -> None:
    folder = tmp_path / "recordings" / "agv"
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        await (await hub.gateway()).hello(RECORDED)
        bringing = await files(hub)
        await bringing.ask(offer(name="left"))
        await bringing.ask(piece(0, name="left"))
    weeks_ago = time.time() - 15 * 86_400
    for path in folder.glob("left.*"):
        os.utime(path, (weeks_ago, weeks_ago))
    async with RunningHub(settings, history) as hub:
        hub.keys = {"agv": await hub.hub.gateways.registry.new_key("agv")}
        assert (await (await files(hub)).bring(name="next")).done
        rows = {row["id"]: row for row in (await listed(hub))["recordings"]}
    assert (rows["next"]["state"], rows["left"]["state"]) == ("complete", "failed")
    assert "not gone on with it" in rows["left"]["note"]
    assert not list(folder.glob("left.*"))


async def test_files_without_rows_are_listed_again_and_nothing_is_deleted(
    settings, history, tmp_path
) -> None:
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(RECORDED)
        bringing = await files(hub)
        assert (await bringing.bring()).done
        await bringing.ask(offer(os.urandom(2 * PIECE), "half"))
        # As if the database were a new one.
        for name in ("20260101T120000Z-abcdef", "half"):
            assert await hub.hub.recordings.files._rows.remove_recording("agv", name)
    folder = tmp_path / "recordings" / "agv"
    (folder / "strange.mcap").write_bytes(b"found")
    (folder / "half.mcap.part").write_bytes(b"some")
    (folder / "notes.txt").write_text("not ours")
    async with RunningHub(settings, history) as hub:
        hub.keys["agv"] = ""
        rows = {each["id"]: each for each in (await listed(hub))["recordings"]}
        assert rows["20260101T120000Z-abcdef"]["why"] == "STOP (software)"
        assert {name: row["state"] for name, row in rows.items()} == {
            "20260101T120000Z-abcdef": "complete", "strange": "complete", "half": "uploading",
        }  # fmt: skip
        assert rows["strange"]["size"] == 5
    (folder / "strange.mcap").unlink()
    async with RunningHub(settings, history) as hub:
        rows = {each["id"]: each for each in (await listed(hub))["recordings"]}
        assert (rows["strange"]["state"], rows["strange"]["note"]) == (
            "failed", "its file is not there",
        )  # fmt: skip
    assert (folder / "notes.txt").exists()


async def test_a_person_begins_and_ends_one_and_sees_how_it_stands(recorded_hub) -> None:
    hub = recorded_hub
    operator = await hub.client("operator")
    before = (await listed(hub))["recorder"]
    assert (before["described"], before["online"], before["on"]) == (True, True, False)
    assert before["may_record"]
    assert not before["may_delete"]
    assert before["topics"][0] == "/odom"
    assert (await operator.post(AT, json={"on": True, "why": " wheels "})).status_code == 202
    assert await hub.linked.hear(RecordingRequest) == RecordingRequest(
        on=True, who="operator", why="wheels"
    )
    await hub.linked.say(RecorderState(on=True, id="r1", why="wheels", who="operator", since_us=5))
    while not (now := (await listed(hub))["recorder"])["on"]:
        continue
    assert (now["why"], now["who"], now["since_us"]) == ("wheels", "operator", 5)
    assert (await operator.post(AT, json={"on": False})).status_code == 202
    assert await hub.linked.hear(RecordingRequest) == RecordingRequest(on=False, who="operator")
    guest = await hub.client("guest")
    assert (await guest.post(AT, json={"on": True})).status_code == 403
    assert (await guest.get(AT)).status_code == 403


async def test_nothing_is_recorded_of_a_site_that_is_away_or_does_not_describe_it(hub) -> None:
    operator = await hub.client("operator")
    gateway = await hub.gateway()
    await gateway.hello()
    refused = await operator.post(AT, json={"on": True})
    assert (refused.status_code, refused.json()["code"]) == (409, "undescribed")
    assert not (await listed(hub))["recorder"]["described"]
    await gateway.close()
    other = await hub.gateway()
    await other.hello(RECORDED, boot="boot-2")
    await other.close()
    while (refused := await operator.post(AT, json={"on": True})).status_code == 202:
        continue
    assert refused.json()["code"] == "offline"


async def test_the_door_for_files_opens_to_a_gateways_key_alone(hub) -> None:
    for headers in ({}, {"Authorization": "Bearer x"}, {"Cookie": await hub.cookie("admin")}):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await hub.dial("/gateway/files", headers)
        assert refused.value.response.status_code == 401


async def test_the_words_beside_a_file_say_what_its_row_says(recorded_hub, tmp_path) -> None:
    bringing = await files(recorded_hub)
    await bringing.bring()
    about = json.loads(
        (tmp_path / "recordings" / "agv" / "20260101T120000Z-abcdef.json").read_text()
    )
    assert about["why"] == "STOP (software)"
    assert about["digest"] == hashlib.sha256(BODY).hexdigest()


def film(body=BODY, name="20260101T120000Z-f00001", stream=CAMERA, **more):
    digest = hashlib.sha256(body).hexdigest()
    told = {"begin_us": 1_767_268_800_000_000, "end_us": 1_767_268_860_000_000, **more}
    return FilmOffer(
        id=name, stream=stream, size=len(body), digest=digest, why="STOP (software)", who="ada",
        pictures=9, **told,
    )  # fmt: skip


async def bring_film(hub, **more):
    bringing = await files(hub)
    has = await bringing.ask(film(**more))
    while not has.done and not has.refused:
        has = await bringing.ask(piece(has.have, name=film(**more).id))
    await bringing.connection.close()
    return has


FILMS = "/api/sites/agv/films"


async def test_a_film_comes_in_and_is_shown_in_ranges_to_those_who_see_its_camera(
    recorded_hub, tmp_path
) -> None:
    hub = recorded_hub
    assert (await bring_film(hub)).done
    assert (await bring_film(hub, name="20260101T120000Z-f00002", stream=FORMER)).done
    operator = await hub.client("operator")
    found = (await operator.get(FILMS)).json()
    assert [each["stream"] for each in found["films"]] == [CAMERA, FORMER]
    assert (found["films"][0]["pictures"], found["films"][0]["state"]) == (9, "complete")
    at = f"{FILMS}/20260101T120000Z-f00001/file"
    some = await operator.get(at, headers={"Range": "bytes=100-299"})
    assert (some.status_code, some.content) == (206, BODY[100:300])
    assert some.headers["content-type"] == "video/mp4"
    assert some.headers["content-disposition"].startswith("inline")
    assert f"agv-{CAMERA.replace('/', '-')}-2026" in some.headers["content-disposition"]
    # Only what has something of the time that is asked for.
    end_us = 1_767_268_860_000_000
    for query, count in (
        (f"from_us={end_us}", 2), (f"from_us={end_us + 1}", 0),
        (f"to_us={end_us - 60_000_000}", 2), (f"to_us={end_us - 60_000_001}", 0),
    ):  # fmt: skip
        assert len((await operator.get(f"{FILMS}?{query}")).json()["films"]) == count
    # A recording is no film, and a film stands among the recordings.
    assert (await (await files(hub)).bring()).done
    assert (await operator.get(f"{FILMS}/20260101T120000Z-abcdef/file")).status_code == 404
    rows = (await operator.get(AT)).json()["recordings"]
    assert sorted(each["stream"] for each in rows) == ["", FORMER, CAMERA]
    # A guest sees the device, and the camera that is no more does not open it to them.
    guest = await hub.client("guest")
    assert [each["id"] for each in (await guest.get(FILMS)).json()["films"]] == []
    assert (await guest.get(at)).status_code == 404
    # One picture is for the same people; who may see it reads that these bytes are no film.
    picture = f"{at.removesuffix('file')}picture?at_us={end_us}"
    assert (await guest.get(picture)).status_code == 404
    said = await operator.get(picture)
    assert (said.status_code, said.json()["code"]) == (409, "unreadable")
    assert (await operator.get(picture.replace("f00001", "abcdef"))).status_code == 404
    admin = await hub.client("admin")
    assert (await admin.delete(f"{AT}/20260101T120000Z-f00001")).status_code == 204
    assert (await operator.get(at)).status_code == 404
    names = sorted(each.name for each in (tmp_path / "recordings" / "agv").glob("*.m*"))
    assert names == ["20260101T120000Z-abcdef.mcap", "20260101T120000Z-f00002.mp4"]


async def test_films_that_the_list_has_lost_are_listed_again(recorded_hub) -> None:
    hub = recorded_hub
    assert (await bring_film(hub)).done
    recordings = hub.hub.recordings.files
    folder = recordings._files._folder / "agv"
    (folder / "20260101T120000Z-f00009.mp4").write_bytes(b"nobody knows whose")
    await recordings._rows.remove_recording("agv", "20260101T120000Z-f00001")
    await recordings.open()
    rows = {each.id: each for each in await recordings.recordings_of("agv")}
    assert rows["20260101T120000Z-f00001"].stream == CAMERA
    assert rows["20260101T120000Z-f00009"].stream == "unknown"
    assert recordings.store.find_local(file_key(rows["20260101T120000Z-f00009"]))


async def test_a_person_films_one_camera_if_its_gateway_can(recorded_hub) -> None:
    hub = recorded_hub
    operator = await hub.client("operator")
    ask = {"on": True, "why": "a bird", "stream": CAMERA}
    said = await operator.post(AT, json=ask)
    assert (said.status_code, said.json()["code"]) == (409, "unable")
    assert (await operator.get(FILMS)).json()["may_film"] is False
    await hub.linked.say(RecorderState(on=False, can_film=True, films=[CAMERA]))
    while not (found := (await operator.get(FILMS)).json())["may_film"]:
        continue
    assert (found["may_film"], found["filming"]) == (True, [CAMERA])
    assert (await operator.post(AT, json=ask)).status_code == 202
    asked = await hub.linked.hear(RecordingRequest)
    assert (asked.on, asked.stream, asked.why) == (True, CAMERA, "a bird")
    assert (await operator.post(AT, json={**ask, "stream": "camera/none"})).status_code == 404
    guest = await hub.client("guest")
    found = (await guest.get(FILMS)).json()
    assert (found["may_film"], found["filming"]) == (False, [])
    assert (await guest.post(AT, json=ask)).status_code == 403


async def test_a_recording_of_a_camera_s_topic_says_that_there_is_no_film_of_it(
    recorded_hub,
) -> None:
    hub = recorded_hub
    bringing = await files(hub)
    digest = hashlib.sha256(BODY).hexdigest()
    offered = FileOffer(
        id="r1", size=len(BODY), digest=digest, begin_us=1_000_000, end_us=2_000_000,
        topics=["/images"],
    )  # fmt: skip
    has = await bringing.ask(offered)
    while not has.done:
        has = await bringing.ask(piece(has.have, name="r1"))
    operator = await hub.client("operator")
    (only,) = (await operator.get(FILMS)).json()["unfilmed"]
    assert only == {
        "recording": "r1", "stream": CAMERA, "begin_us": 1_000_000, "end_us": 2_000_000,
    }  # fmt: skip
    assert (await (await hub.client("guest")).get(FILMS)).json()["unfilmed"] == []
    assert (await bring_film(hub, begin_us=1_500_000, end_us=1_600_000)).done
    assert (await operator.get(FILMS)).json()["unfilmed"] == []
