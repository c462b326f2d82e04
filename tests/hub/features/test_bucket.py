"""Recordings, films and pictures in a bucket: as in a folder, and nothing lost while it is away."""

from __future__ import annotations

import dataclasses
import logging
import os
import re
from contextlib import asynccontextmanager

import httpx
import pytest
import pytest_asyncio
from patience import until_answered

from talaia.wire.frames import PIECE, Bye

from ..conftest import DESCRIPTION, MemoryHistory, RunningHub, settings_in
from ..databases import origin_of
from ..object_stores import BUCKET, KEY_ID, SECRET, FaultyLine, ObjectStore
from .test_archive import files_of, fits_bytes, upload
from .test_recorded_topics import BEGIN_US, RULES, SECOND_US, asked, foreign_bag
from .test_recordings import AT, FILMS, RECORDED, bring_film, files, offer, piece

NAME = "20260101T120000Z-abcdef"
# More than one part of an upload.
LONG = os.urandom(9 * 1024 * 1024 + 77)
SHORT = os.urandom(3 * PIECE + 1234)
KEY = f"files/recordings/agv/{NAME}.mcap"


@pytest.fixture(autouse=True)
def _tables_are_made():
    # Outside any event loop, for it runs one.
    origin_of("sqlite")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def store():
    async with ObjectStore() as running:
        yield running


@pytest.fixture
def line(store):
    with FaultyLine(store.port) as made:
        yield made


def settings_of(folder, line, **more):
    folder.mkdir(exist_ok=True)
    key = folder / "bucket-key"
    key.write_text(f"{KEY_ID}\n{SECRET}\n")
    return dataclasses.replace(
        settings_in(folder),
        files=f"s3://{BUCKET}/files",
        files_endpoint=line.url,
        files_key_file=key,
        **more,
    )


@asynccontextmanager
async def linked_hub(settings, description=RECORDED):
    """Run a hub with people and a gateway that is there."""
    async with RunningHub(settings, MemoryHistory()) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(description)
        yield hub


@pytest.fixture
async def stored_hub(tmp_path, store, line):
    """Give a hub whose files are in an empty bucket."""
    await empty_bucket(store)
    async with linked_hub(settings_of(tmp_path, line)) as hub:
        hub.line = line
        yield hub


async def empty_bucket(store) -> None:
    for key in await store.keys():
        await store.remove(key)


async def bring(hub, body, name=NAME):
    """Hand over a recording as a gateway does, on a connection of its own."""
    bringing = await files(hub)
    done = await bringing.bring(body, name)
    await bringing.connection.close()
    return done


async def names(hub):
    client = await hub.client("operator")
    return {row["id"]: row["state"] for row in (await client.get(AT)).json()["recordings"]}


async def until_keys(store, wanted) -> None:
    async def are_there() -> bool:
        return set(await store.keys()) == wanted

    await until_answered(are_there)


def beside(key: str) -> set[str]:
    return {key, re.sub(r"\.m\w+$", ".json", key)}


async def test_a_recording_is_acknowledged_from_the_bucket_and_comes_back_whole_and_in_ranges(
    stored_hub, store, tmp_path
) -> None:
    hub = stored_hub
    assert (await bring(hub, LONG)).done
    # The store has it, by its own word; nothing of it is on the hub's disk.
    assert set(await store.keys()) == beside(KEY)
    assert await store.content(KEY) == LONG
    assert await store.uploads() == 0
    assert list((tmp_path / "recordings" / "agv").iterdir()) == []
    assert await names(hub) == {NAME: "complete"}
    client, at = await hub.client("operator"), f"{AT}/{NAME}/file"
    whole = await client.get(at)
    assert whole.content == LONG
    assert whole.headers["content-disposition"] == f'attachment; filename="agv-{NAME}.mcap"'
    assert "sandbox" in whole.headers["content-security-policy"]
    for words, first, end in (
        ("bytes=100-299", 100, 300),
        (f"bytes={len(LONG) - 5}-", len(LONG) - 5, len(LONG)),
        ("bytes=-7", len(LONG) - 7, len(LONG)),
        (f"bytes=4000000-{10**12}", 4_000_000, len(LONG)),
    ):
        some = await client.get(at, headers={"Range": words})
        assert (some.status_code, some.content) == (206, LONG[first:end])
        assert some.headers["content-range"] == f"bytes {first}-{end - 1}/{len(LONG)}"
    beyond = await client.get(at, headers={"Range": f"bytes={len(LONG)}-"})
    assert (beyond.status_code, beyond.headers["content-range"]) == (416, f"bytes */{len(LONG)}")
    # A version that is not this one any more: all of it, as with a folder.
    other = await client.get(at, headers={"Range": "bytes=0-9", "If-Range": '"another"'})
    assert (other.status_code, other.content) == (200, LONG)
    admin = await hub.client("admin")
    assert (await admin.delete(f"{AT}/{NAME}")).status_code == 204
    assert (await client.get(at)).status_code == 404
    await until_keys(store, set())


async def test_a_film_in_a_bucket_is_played_in_ranges(stored_hub, store) -> None:
    hub = stored_hub
    assert (await bring_film(hub)).done
    (key,) = [key for key in await store.keys() if key.endswith(".mp4")]
    body, client = await store.content(key), await hub.client("operator")
    at = f"{FILMS}/20260101T120000Z-f00001/file"
    some = await client.get(at, headers={"Range": "bytes=100-299"})
    assert (some.status_code, some.content) == (206, body[100:300])
    assert some.headers["content-type"] == "video/mp4"
    assert some.headers["content-disposition"].startswith("inline")
    all_of_it = await client.get(at, headers={"Range": "bytes=0-"})
    assert (all_of_it.status_code, all_of_it.content) == (206, body)


async def test_recorded_topics_are_read_out_of_the_bucket(tmp_path, store, line) -> None:
    await empty_bucket(store)
    async with linked_hub(settings_of(tmp_path / "a", line), DESCRIPTION + RULES) as hub:
        bringing = await files(hub)
        bag, end_us = foreign_bag(tmp_path), BEGIN_US + 30 * SECOND_US
        assert (await bringing.bring(bag, begin_us=BEGIN_US, end_us=end_us)).done
        found = await asked(hub, "", at_us=BEGIN_US + 10 * SECOND_US)
        assert [topic["topic"] for topic in found["topics"]] == ["/odom"]
        line.away = True
        client = await hub.client("operator")
        gone = await client.get(f"{AT}/{NAME}/file")
        assert (gone.status_code, gone.json()["code"]) == (503, "files")
        assert "the store of files" in gone.json()["message"]
        line.away = False
        # It was away for a moment, and not unreadable.
        found = await asked(hub, "", at_us=BEGIN_US + 10 * SECOND_US)
        assert [topic["topic"] for topic in found["topics"]] == ["/odom"]


async def test_a_hub_with_another_folder_finds_what_is_in_the_bucket(tmp_path, store, line) -> None:
    await empty_bucket(store)
    first = settings_of(tmp_path / "east", line)
    first = dataclasses.replace(first, database_url=first.url)
    async with linked_hub(first) as hub:
        assert (await bring(hub, SHORT)).done
        # What has not come whole lies in this hub's folder.
        half = await files(hub)
        await half.ask(offer(SHORT, "20260101T130000Z-aaaaaa"))
        await half.ask(piece(0, SHORT, "20260101T130000Z-aaaaaa"))
        # A row that is lost is made anew from the bucket.
        await hub.hub.recordings.files._rows.remove_recording("agv", NAME)
    second = dataclasses.replace(
        settings_of(tmp_path / "west", line), database_url=first.database_url
    )
    async with RunningHub(second, MemoryHistory()) as hub:
        hub.keys["agv"] = ""

        async def is_listed() -> bool:
            return (await names(hub)).get(NAME) == "complete"

        await until_answered(is_listed)
        client = await hub.client("operator")
        (row,) = [row for row in (await client.get(AT)).json()["recordings"] if row["id"] == NAME]
        assert (row["why"], row["topics"]) == ("STOP (software)", ["/odom", "/scan"])
        assert (await client.get(f"{AT}/{NAME}/file")).content == SHORT


async def test_the_list_says_of_a_recording_that_somebody_took_out_of_the_bucket(
    stored_hub, store
) -> None:
    hub = stored_hub
    assert (await bring(hub, SHORT)).done
    await store.remove(KEY)
    (stored,) = [task for task in hub.hub.recordings.tasks if task.name == "stored"]
    await stored.run.__self__.fit_list()
    assert await names(hub) == {NAME: "failed"}
    client = await hub.client("operator")
    assert (await client.get(f"{AT}/{NAME}/file")).status_code == 409


async def test_a_store_that_dies_midway_loses_nothing_and_is_told_of_in_words(
    tmp_path, caplog
) -> None:
    caplog.set_level(logging.INFO)
    async with ObjectStore() as own:
        with FaultyLine(own.port) as line:
            async with linked_hub(settings_of(tmp_path, line)) as hub:
                admin = await hub.client("admin")
                bringing = await files(hub)
                assert (await bringing.ask(offer(SHORT))).have == 0
                assert (await bringing.ask(piece(0, SHORT))).have == PIECE
                await own.kill()
                # The gateway is sent away, and keeps its file.
                said = await bringing.bring_until_bye(SHORT)
                assert isinstance(said, Bye)
                assert await names(hub) == {NAME: "uploading"}
                # What an admin sees on every page; the history's own trouble spares its look.
                hub.history.trouble = "is away as well"
                told = (await admin.get("/api/storage/outlook")).json()
                assert told["files_trouble"].startswith("the store of files ")
                (problem,) = (await admin.get("/api/hubs")).json()["problems"]
                assert problem.startswith("The store of files ")
                # A store that forgot everything while it was away.
                await own.start()
                # What had come is still here: nothing is sent twice.
                bringing = await files(hub)
                done = await bringing.ask(offer(SHORT))
                assert (done.done, done.have) == (True, len(SHORT))
                assert await own.content(KEY) == SHORT

                async def is_well() -> bool:
                    await hub.hub.files.store.probe_store()
                    return (await admin.get("/api/hubs")).json()["problems"] == []

                await until_answered(is_well)
    said = [record.message for record in caplog.records]
    losses = [line for line in said if "the store of files" in line and "; nothing is " in line]
    returns = [line for line in said if line.startswith("files of") and line.endswith(" again")]
    assert len(losses) == len(returns) <= 2
    assert losses
    assert SECRET not in caplog.text
    assert KEY_ID not in caplog.text


@pytest.mark.parametrize(("status", "code"), [(507, "InsufficientStorage"), (403, "QuotaExceeded")])
async def test_a_store_that_is_full_still_shows_what_it_has(
    stored_hub, store, status, code, caplog
) -> None:
    hub = stored_hub
    assert (await bring(hub, SHORT)).done
    hub.line.refusal = (status, code)
    bringing = await files(hub)
    said = await bringing.bring_until_bye(LONG, "20260101T130000Z-aaaaaa")
    assert isinstance(said, Bye)
    client = await hub.client("admin")
    assert (await client.get(f"{AT}/{NAME}/file")).content == SHORT
    await hub.hub.files.store.probe_store()
    (problem,) = (await client.get("/api/hubs")).json()["problems"]
    assert problem == f"The store of files has no room ({code})"
    assert KEY_ID not in caplog.text
    hub.line.refusal = None
    assert (await bring(hub, LONG, "20260101T130000Z-aaaaaa")).done
    assert (await client.get("/api/hubs")).json()["problems"] == []
    assert await store.uploads() == 0


@pytest.mark.parametrize("fault", ["lose", "spoil"])
async def test_what_the_store_took_and_does_not_have_is_not_acknowledged(
    stored_hub, store, fault
) -> None:
    hub = stored_hub
    setattr(hub.line, fault, True)
    bringing = await files(hub)
    assert isinstance(await bringing.bring_until_bye(SHORT), Bye)
    assert await names(hub) == {NAME: "uploading"}
    (problem,) = (await (await hub.client("admin")).get("/api/hubs")).json()["problems"]
    assert "other than what was written" in problem
    setattr(hub.line, fault, False)
    assert (await bring(hub, SHORT)).done
    assert await store.content(KEY) == SHORT


@pytest.mark.parametrize(("fault", "value"), [("cut", 1000), ("etag", True)])
async def test_a_lying_answer_is_never_shown_as_a_whole_file(stored_hub, fault, value) -> None:
    hub = stored_hub
    assert (await bring(hub, LONG)).done
    setattr(hub.line, fault, value)
    client = await hub.client("operator")
    with pytest.raises(httpx.RemoteProtocolError):
        await client.get(f"{AT}/{NAME}/file")
    setattr(hub.line, fault, False)
    assert (await client.get(f"{AT}/{NAME}/file")).content == LONG


async def test_the_oldest_goes_from_the_bucket_even_if_that_is_away_meanwhile(
    tmp_path, store, line
) -> None:
    await empty_bucket(store)
    limit = len(SHORT) + 1000
    settings = settings_of(tmp_path, line, recordings_bytes=limit)
    async with linked_hub(settings) as hub:
        assert (await bring(hub, SHORT)).done
        assert (await bring(hub, SHORT, "20260101T130000Z-aaaaaa")).done
        newer = "files/recordings/agv/20260101T130000Z-aaaaaa.mcap"
        await until_keys(store, beside(newer))
        line.away = True
        admin = await hub.client("admin")
        # Who deletes does not wait for the store.
        assert (await admin.delete(f"{AT}/20260101T130000Z-aaaaaa")).status_code == 204
        assert await names(hub) == {}
    # A hub that is started anew still knows what is to be removed, and does not list it.
    line.away = False
    async with RunningHub(settings, MemoryHistory()) as hub:
        await until_keys(store, set())
        assert await names(hub) == {}


async def test_a_name_that_was_removed_and_comes_again_stays(stored_hub, store) -> None:
    hub = stored_hub
    assert (await bring(hub, SHORT)).done
    hub.line.away = True
    admin = await hub.client("admin")
    assert (await admin.delete(f"{AT}/{NAME}")).status_code == 204
    hub.line.away = False
    # Its gateway never had the answer, and offers it again.
    assert (await bring(hub, SHORT)).done
    bucket = hub.hub.files.store
    while await bucket._remove_some():
        pass
    assert await store.content(KEY) == SHORT
    assert await names(hub) == {NAME: "complete"}


async def test_a_picture_is_kept_measured_shown_and_packed_out_of_the_bucket(
    tmp_path, store, line
) -> None:
    await empty_bucket(store)
    async with linked_hub(settings_of(tmp_path, line), DESCRIPTION) as hub:
        data = fits_bytes()
        assert (await upload(await files_of(hub), data)).done
        client = await hub.client("operator")

        async def is_measured() -> bool:
            (frame,) = (await client.get("/api/sites/agv/frames")).json()["frames"]
            return bool(frame["measured"])

        await until_answered(is_measured)
        (frame,) = (await client.get("/api/sites/agv/frames")).json()["frames"]
        (key,) = await store.keys()
        assert key == f"files/archive/agv/{frame['night']}/{frame['name']}"
        # Measured, so with more cards; the pixels are as they came, in the store, too.
        kept = await store.content(key)
        assert kept.endswith(data[2880:])
        assert len(kept) == frame["bytes"]
        at = f"/api/sites/agv/frames/{frame['id']}"
        whole = await client.get(f"{at}/file")
        assert whole.content == kept
        assert (await client.get(f"{at}/file", headers={"Range": "bytes=0-5"})).content == b"SIMPLE"
        preview = await client.get(f"{at}/preview")
        assert preview.content.startswith(b"\x89PNG")
        assert (await client.get(at)).json()["header"]
        assert not list((tmp_path / "archive").glob("**/*.fits"))
    # The copies of this run are gone with it, and the picture is read out of the bucket.
    async with RunningHub(hub.settings, MemoryHistory()) as hub:
        client = await hub.client("operator")
        preview = await client.get(f"{at}/preview")
        assert preview.content.startswith(b"\x89PNG")
        await store.remove(key)
        assert (await client.get(f"{at}/file")).status_code == 410


async def test_what_lay_in_the_folder_before_is_found_there_as_ever(tmp_path, store, line) -> None:
    await empty_bucket(store)
    settings = settings_of(tmp_path, line)
    async with linked_hub(dataclasses.replace(settings, files="")) as hub:
        assert (await bring(hub, SHORT)).done
    async with RunningHub(settings, MemoryHistory()) as hub:
        client = await hub.client("operator")
        some = await client.get(f"{AT}/{NAME}/file", headers={"Range": "bytes=1-3"})
        assert some.content == SHORT[1:4]
        assert await names(hub) == {NAME: "complete"}
    assert await store.keys() == []


async def test_metrics_say_whether_the_store_is_there(stored_hub) -> None:
    from talaia.hub.clients.site_metrics import HubFigures, _hub_metrics

    def shown(figures: HubFigures) -> dict[str, float]:
        return {
            sample.name: sample.value
            for metric in _hub_metrics(figures)
            for sample in metric.samples
        }

    assert "talaia_file_store_up" not in shown(HubFigures("1", 0, {}))
    assert shown(HubFigures("1", 0, {}, (), files_up=True))["talaia_file_store_up"] == 1
    assert shown(HubFigures("1", 0, {}, (), files_up=False))["talaia_file_store_up"] == 0
