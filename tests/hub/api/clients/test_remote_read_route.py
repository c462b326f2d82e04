"""Past values as a real Prometheus reads them from the hub, and the dashboard's expressions."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import httpx
import pyarrow as pa
import pytest
import pytest_asyncio
from patience import PATIENCE_S
from shared_trust import usual_trust

from talaia.clock import SystemClock
from talaia.wire.protobuf import bytes_field, varint_field

from ...conftest import EXAMPLE, RunningHub
from .prometheus_server import (
    EVERYWHERE,
    VIEW_ALL,
    VIEW_BASE,
    open_protocol,
    query,
    serving,
    token,
)

pytestmark = pytest.mark.asyncio(loop_scope="module")

READ = "/clients/prometheus/read"
DASHBOARD = Path(__file__).parents[4] / "examples" / "grafana" / "dashboard.json"
# An hour ago, of which Prometheus knows nothing itself (s).
AGO_S = 3600


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def past(shared_settings):
    """A hub with a real history: ten samples, one each minute, from an hour ago on."""
    async with RunningHub(shared_settings, None) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        # With its alarms, which the dashboard shows.
        await gateway.hello(EXAMPLE)
        await open_protocol(hub)
        hub.start_s = SystemClock().wall_ns() // 10**9 // 60 * 60 - AGO_S
        rows = []
        for minute in range(10):
            time_us = (hub.start_s + 60 * minute) * 10**6
            rows += [("base/speed", time_us, minute / 4), ("power/voltage", time_us, 12.0 + minute)]
        await gateway.samples(*rows, live=False)
        hub.robot = gateway
        # Stored: the history is what is read.
        admin = await hub.client("admin")
        about = {
            "channel": "power/voltage",
            "from_us": hub.start_s * 10**6,
            "to_us": (hub.start_s + 600) * 10**6,
        }
        async with asyncio.timeout(PATIENCE_S):
            while True:
                said = (await admin.get("/api/sites/agv/history", params=about)).json()
                if len(said["series"][0]["v"]) == 10:
                    break
                await asyncio.sleep(0.05)
        yield hub


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def prometheus(past, tmp_path_factory):
    headers = await token(past, EVERYWHERE, VIEW_ALL)
    folder = tmp_path_factory.mktemp("prometheus")
    async with serving(folder, past.port, headers, reads_past=True) as client:
        yield client


def window_of(past) -> dict[str, int]:
    return {"start": past.start_s, "end": past.start_s + 540, "step": 60}


async def test_real_prometheus_answers_for_a_time_before_it_was_there(past, prometheus) -> None:
    (row,) = await query(prometheus, 'talaia_signal_value{signal="speed"}', **window_of(past))
    assert row["values"] == [
        [past.start_s + 60 * minute, str(minute / 4).removesuffix(".0")] for minute in range(10)
    ]
    # By the labels of what is scraped: one series goes on from the other.
    assert row["metric"] == {
        "__name__": "talaia_signal_value",
        "site": "agv",
        "device": "base",
        "signal": "speed",
        "unit": "m/s",
        "job": "talaia",
        "instance": f"127.0.0.1:{past.port}",
    }
    # As its functions want them, and by each kind of matcher.
    most = 'max_over_time(talaia_signal_value{device=~"pow.*",signal!~"curr.+",unit!=""}[10m])'
    rows = await query(prometheus, most, time=past.start_s + 540)
    assert [row["value"][1] for row in rows if row["metric"]["signal"] == "voltage"] == ["21"], rows


async def test_each_panel_of_the_dashboard_has_something_to_show(past, prometheus) -> None:
    read = json.loads(DASHBOARD.read_text())
    assert len({panel["id"] for panel in read["panels"]}) == len(read["panels"])
    expressions = [target["expr"] for panel in read["panels"] for target in panel["targets"]]
    for variable in read["templating"]["list"]:
        if variable["type"] == "query":
            asked = variable["query"]["query"]
            series, _, label = asked.removeprefix("label_values(").removesuffix(")").rpartition(",")
            expressions.append(f"count by ({label.strip()}) ({series})")
    assert len(expressions) >= 9
    # As Grafana puts in what "All" stands for.
    for name in ("site", "unit"):
        expressions = [expression.replace(f"${name}", ".*") for expression in expressions]
    async with asyncio.timeout(PATIENCE_S):
        while expressions := [one for one in expressions if not await query(prometheus, one)]:
            now_us = SystemClock().wall_ns() // 1000
            await past.robot.samples(("base/speed", now_us, 1.25))
            await asyncio.sleep(0.2)


async def test_nobody_reads_the_past_without_the_token_and_the_right(past) -> None:
    body = packed(("site", "agv"), past)
    allowed = await token(past, EVERYWHERE, VIEW_ALL)
    cookie = {"Cookie": await past.cookie("admin")}
    async with httpx.AsyncClient(base_url=past.origin, verify=usual_trust()) as client:
        assert (await client.post(READ, content=body)).status_code == 401
        assert (await client.post(READ, content=body, headers=cookie)).status_code == 401
        only_view = await client.post(READ, content=body, headers=await token(past, VIEW_BASE))
        assert (only_view.status_code, only_view.json()["code"]) == (403, "forbidden")
        everything = await client.post(READ, content=body, headers=allowed)
        assert everything.headers["content-encoding"] == "snappy"
        assert b"voltage" in unpacked(everything)
        of_base = await token(past, {**EVERYWHERE, "site": "agv"}, VIEW_BASE)
        narrow = unpacked(await client.post(READ, content=body, headers=of_base))
        assert b"speed" in narrow
        assert b"voltage" not in narrow
        other = await token(past, {**EVERYWHERE, "site": "moon"}, VIEW_ALL)
        refused = await client.post(READ, content=body, headers=other)
        assert refused.status_code == 403 or not unpacked(refused)
        await open_protocol(past, is_open=False)
        assert (await client.post(READ, content=body, headers=allowed)).json()["code"] == "shut"
        await open_protocol(past)


async def test_what_is_no_query_or_too_large_is_refused_with_the_reason(past) -> None:
    headers = await token(past, EVERYWHERE, VIEW_ALL)
    bomb = b"\xff\xff\xff\x7f" + b"\x00" * 20
    odd = {
        "nothing": (b"", "Snappy"),
        "no Snappy": (b"\xff" * 40, "Snappy"),
        "a bomb": (bomb, "over"),
        "cut off": (pa.compress(b"\x0a\x7f", codec="snappy", asbytes=True), "cut off"),
        "a bad expression": (packed(("site", "("), past, kind=2), "regular expression"),
    }
    async with httpx.AsyncClient(base_url=past.origin, verify=usual_trust()) as client:
        for case, (body, why) in odd.items():
            answer = await client.post(READ, content=body, headers=headers)
            assert answer.status_code == 400, (case, answer.text)
            assert why in answer.json()["message"], (case, answer.text)
        # An expression that would keep others busy for years is done at once.
        slow = packed(("signal", "(.*)*" * 30 + "x"), past, kind=2)
        assert (await client.post(READ, content=slow, headers=headers)).status_code == 200


def packed(matcher: tuple[str, str], past, *, kind: int = 0) -> bytes:
    """Ask for what a label has to be, of the hour and a half up to now."""
    said = varint_field(1, kind) + bytes_field(2, matcher[0]) + bytes_field(3, matcher[1])
    times = varint_field(1, past.start_s * 1000) + varint_field(2, (past.start_s + 5400) * 1000)
    return pa.compress(bytes_field(1, times + bytes_field(3, said)), codec="snappy", asbytes=True)


def unpacked(answer: httpx.Response) -> bytes:
    size, place = 0, 0
    for place, byte in enumerate(answer.content):
        size |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            break
    return pa.decompress(answer.content, size, codec="snappy", asbytes=True) if size else b""
