"""The history over HTTP, with the store that the hub ships with."""

import csv
import io
import json

import pyarrow as pa
import pytest

from talaia.wire.frames import Ack

from .history.samples import batch

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
    store = stored.hub._history
    await store.append("agv", "old", 0, ["base/gone"], batch([(0, NOW, 7.0)]))
    listed = (await operator.get("/api/sites/agv/stored")).json()["channels"]
    gone = next(each for each in listed if each["address"] == "base/gone")
    assert gone == {
        "address": "base/gone", "described": False, "samples": 1, "first_us": NOW, "last_us": NOW,
    }  # fmt: skip
    speed = next(each for each in listed if each["address"] == "base/speed")
    assert (speed["described"], speed["samples"]) == (True, 100)
    query = {"signal": "base/gone", **WINDOW}
    series = (await operator.get("/api/sites/agv/history", params=query)).json()["series"]
    assert series[0]["v"] == [7.0]
    assert (await guest.get("/api/sites/agv/history", params=query)).status_code == 404
    listed = (await guest.get("/api/sites/agv/stored")).json()["channels"]
    assert [each["address"] for each in listed] == ["base/speed"]
