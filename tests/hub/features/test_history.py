"""The history over HTTP, with the store that the hub ships with."""

import asyncio
import csv
import io
import json

import pyarrow as pa
import pytest

from talaia.hub.history.errors import HistoryError
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import Ack

from ..conftest import DESCRIPTION
from ..history.samples import batch

NOW = 1_700_000_000_000_000
WINDOW = {"from_us": NOW, "to_us": NOW + 1_000_000}


@pytest.fixture
async def stored(hub_that_stores):
    """A hub that has stored some samples of the example vehicle."""
    async with hub_that_stores() as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello()
        rows = [("base/speed", NOW + at * 1000, at / 100) for at in range(100)]
        rows += [(f"base/pose.{part}", NOW + at, float(at)) for at in range(3) for part in "xy"]
        rows += [("base/pose.yaw", NOW + at, 0.5) for at in range(3)]
        await gateway.samples(*rows)
        await gateway.hear(Ack, lambda ack: ack.below == len(rows))
        hub.linked = gateway
        yield hub


async def test_a_signal_stands_for_its_channels(stored) -> None:
    client = await stored.client("operator")
    query = {"signal": ["base/pose", "base/speed"], "channel": "base/pose.x", **WINDOW}
    series = (await client.get("/api/sites/agv/history", params=query)).json()["series"]
    assert [each["address"] for each in series] == [
        "base/pose.x", "base/pose.y", "base/pose.yaw", "base/speed",
    ]  # fmt: skip
    assert series[1]["v"] == [0.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("query", "headers"),
    [({"format": "arrow"}, {}), ({}, {"Accept": "application/vnd.apache.arrow.stream"})],
)
async def test_a_window_comes_as_arrow_to_who_asks_for_it(stored, query, headers) -> None:
    client = await stored.client("guest")
    query = {"signal": "base/speed", **WINDOW, **query}
    answer = await client.get("/api/sites/agv/history", params=query, headers=headers)
    assert answer.headers["content-type"] == "application/vnd.apache.arrow.stream"
    table = pa.ipc.open_stream(answer.content).read_all()
    assert table.column("v").to_pylist() == [at / 100 for at in range(100)]
    about = json.loads(table.schema.metadata[b"talaia"])
    assert about["series"] == [{"address": "base/speed", "kind": "exact", "rows": 100, "gaps": []}]


async def test_last_value_and_statistics(stored) -> None:
    client = await stored.client("guest")
    query = {"signal": "base/speed", "before_us": NOW + 5_000}
    answer = await client.get("/api/sites/agv/last", params=query)
    assert answer.json() == {
        "values": [{"address": "base/speed", "t_us": NOW + 4_000, "v": 0.04, "text": None}]
    }
    query = {"signal": "base/speed", **WINDOW}
    (found,) = (await client.get("/api/sites/agv/statistics", params=query)).json()["statistics"]
    assert found["count"] == 100
    assert found["mean"] == pytest.approx(0.495)
    assert found["deviation"] == pytest.approx(0.288661, rel=1e-5)
    assert found["high"] == {"t_us": NOW + 99_000, "v": 0.99, "text": None}
    assert found["gap_us"] == 0


async def test_an_export_is_a_file_of_every_sample(stored) -> None:
    client = await stored.client("operator")
    query = {"signal": ["base/pose", "base/speed"], "format": "csv", **WINDOW}
    answer = await client.get("/api/sites/agv/export", params=query)
    assert answer.headers["content-type"] == "text/csv; charset=utf-8"
    assert 'filename="agv-1700000000-1700000001.csv"' in answer.headers["content-disposition"]
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert len(rows) == 102
    assert rows[0]["base/speed (m/s)"] == "0"
    assert [row["base/pose.x (m)"] for row in rows[:4]] == ["0", "1", "2", ""]


@pytest.mark.parametrize(
    ("path", "query", "status"),
    [
        ("history", {"signal": "base/turn_rate", **WINDOW}, 404),
        ("history", WINDOW, 422),
        ("last", {"signal": "base/turn_rate", "before_us": 1}, 404),
        ("statistics", {"signal": "base/turn_rate", **WINDOW}, 404),
        ("export", {"signal": "base/turn_rate", "format": "csv", **WINDOW}, 404),
        ("export", {"signal": "base/speed", "format": "xls", **WINDOW}, 422),
        ("export", {"signal": "base/speed", "format": "csv", "from_us": 2, "to_us": 1}, 422),
    ],
)
async def test_a_guest_is_refused_what_is_not_public(stored, path, query, status) -> None:
    client = await stored.client("guest")
    answer = await client.get(f"/api/sites/agv/{path}", params=query)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"


async def test_a_removed_signal_keeps_its_history_for_who_may_view_its_device(stored) -> None:
    operator, guest = await stored.client("operator"), await stored.client("guest")
    store = stored.hub.history.store
    await store.append_samples(
        "agv", "old", 0, addresses=["base/gone"], columns=batch([(0, NOW, 7.0)])
    )
    listed = (await operator.get("/api/sites/agv/stored")).json()["channels"]
    gone = next(each for each in listed if each["address"] == "base/gone")
    assert gone == {
        "address": "base/gone", "described": False, "samples": 1, "first_us": NOW, "last_us": NOW,
        "name": "", "unit": "", "type": "", "states": [], "decimals": -1,
    }  # fmt: skip
    speed = next(each for each in listed if each["address"] == "base/speed")
    assert (speed["described"], speed["samples"]) == (True, 100)
    query = {"signal": "base/gone", **WINDOW}
    series = (await operator.get("/api/sites/agv/history", params=query)).json()["series"]
    assert series[0]["v"] == [7.0]
    assert (await guest.get("/api/sites/agv/history", params=query)).status_code == 404
    listed = (await guest.get("/api/sites/agv/stored")).json()["channels"]
    assert [each["address"] for each in listed] == ["base/speed"]


async def test_a_sensor_that_a_new_description_renames_or_leaves_out_keeps_its_history(
    stored,
) -> None:
    rows = [("base/wandering", NOW + at, float(at % 2)) for at in range(4)]
    await stored.linked.close()
    before = await stored.gateway()
    await before.hello(boot="boot-2")
    await before.samples(*rows)
    await before.hear(Ack, lambda ack: ack.below == 4)
    await before.close()
    # The gateway comes back: speed has another name, and the wander mode is gone.
    changed = DESCRIPTION.replace("      speed:\n", "      ground_speed:\n")
    changed = changed.replace("base/speed", "base/ground_speed")
    start, end = changed.index("      wandering:"), changed.index("    commands:")
    changed = changed[:start] + changed[end:]
    after = await stored.gateway()
    await after.hello(changed, boot="boot-3")
    addresses = [channel.address for channel in load_site(changed).channels()]
    after.channels = {address: at for at, address in enumerate(addresses)}
    await after.samples(("base/ground_speed", NOW + 200_000, 8.0))
    await after.hear(Ack, lambda ack: ack.below == 1)

    client = await stored.client("operator")
    query = {"former": "true"}
    former = (await client.get("/api/sites/agv/stored", params=query)).json()["channels"]
    speed, mode = former
    assert (speed["address"], speed["name"], speed["unit"]) == ("base/speed", "Speed", "m/s")
    assert (mode["address"], mode["name"]) == ("base/wandering", "Wander mode")
    assert (mode["type"], mode["states"]) == ("state", ["off", "on"])
    assert not speed["described"]
    assert (speed["samples"], mode["samples"]) == (100, 4)
    query = {"channel": ["base/speed", "base/ground_speed"], **WINDOW}
    old, new = (await client.get("/api/sites/agv/history", params=query)).json()["series"]
    assert old["v"] == [at / 100 for at in range(100)]
    assert new["v"] == [8.0]
    # A file says of a sensor that is gone what it said before.
    query = {"channel": ["base/speed", "base/wandering"], "format": "csv", **WINDOW}
    answer = await client.get("/api/sites/agv/export", params=query)
    table = list(csv.DictReader(io.StringIO(answer.text)))
    assert [row["base/wandering"] for row in table[:4]] == ["off", "on", "off", "on"]
    assert "base/speed (m/s)" in table[0]
    guest = await stored.client("guest")
    query = {"former": "true"}
    assert (await guest.get("/api/sites/agv/stored", params=query)).json() == {"channels": []}


async def test_storage_says_what_each_signal_takes_and_how_long_it_is_kept(stored) -> None:
    changed = DESCRIPTION.replace("      speed:\n", "      speed:\n        keep: 30\n")
    await stored.linked.close()
    gateway = await stored.gateway()
    await gateway.hello(changed, boot="boot-2")
    store = stored.hub.history.store
    # Few samples make a block.
    choice = store._ledger._choice
    choice._limits = choice._limits._replace(block=256, largest=256)
    rows = [(at, NOW + i * 1000, i / 7) for i in range(500) for at in (0, 1)]
    for first in range(0, 10_000, 1_000):
        await store.append_samples(
            "agv", "b", first, addresses=["base/speed", "base/gone"], columns=batch(rows)
        )
    admin, operator = await stored.client("admin"), await stored.client("operator")
    said = (await admin.get("/api/storage")).json()
    gone, speed = said["channels"]
    assert (speed["name"], speed["described"], speed["keep_days"]) == ("Speed", True, 30.0)
    assert (gone["address"], gone["described"], gone["keep_days"]) == ("base/gone", False, 0.0)
    assert said["blocks_bytes"] == speed["bytes"] + gone["bytes"] > 0
    assert said["place"].endswith("talaia.db")
    assert said["disk_bytes"] > said["free_bytes"] > 0
    assert (said["limit_bytes"], said["trouble"]) == (0, "")
    for path in ("/api/storage", "/api/storage/outlook"):
        assert (await operator.get(path)).status_code == 403


async def test_the_outlook_says_why_nothing_is_stored_and_when_it_is_again(stored) -> None:
    admin, store = await stored.client("admin"), stored.hub.history.store
    outlook = "/api/storage/outlook"
    assert (await admin.get(outlook)).json()["trouble"] == ""

    def allow(pages: int) -> None:
        # No database may be larger than this: as if the disk had no more room.
        with store._writing.connect() as connection:
            connection.exec_driver_sql(f"PRAGMA max_page_count = {pages}")

    rows = [(0, NOW + i, f"{i} " + "x" * 2_000) for i in range(400)]
    # Not on the loop: the hub may be in a transaction of its own, which ends there.
    await asyncio.to_thread(allow, 1)
    said = ""
    # A line of the hub's own may still find room, and then the history is stored again.
    for _attempt in range(5):
        with pytest.raises(HistoryError, match="full"):
            await store.append_samples("agv", "b", 0, addresses=["base/said"], columns=batch(rows))
        if "full" in (said := (await admin.get(outlook)).json()["trouble"]):
            break
    assert "full" in said
    await asyncio.to_thread(allow, 2**30)
    await store.append_samples("agv", "b", 0, addresses=["base/said"], columns=batch(rows))
    assert (await admin.get(outlook)).json()["trouble"] == ""
