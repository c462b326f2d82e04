"""The gateway and a rosbridge server: its real words, and every bad word one could say.

The story below ran against RobotWebTools' rosbridge_suite (ros2, October 2024) on rclpy with the
robot of `robot_peer`, and what both said then is kept. To record it anew::

    export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
    ROS_DOMAIN_ID=42 ros2 run rosbridge_server rosbridge_websocket &
    export TALAIA_TEST_DOMAIN=42 TALAIA_ROSBRIDGE=ws://127.0.0.1:9090
    pytest tests/gateway/adapters/rosbridge/test_adapter.py -k story
"""

from __future__ import annotations

import asyncio
import json
import math
import os
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
import pytest
import simplejpeg
from fake_hub import fake_hub
from gateway_bench import addresses_of, command, drive, filled, running, take_lease
from hypothesis import given, strategies as st
from patience import PATIENCE_S, Stopwatch
from websockets.asyncio.server import serve

from talaia.gateway.adapters.rosbridge.cbor import read_cbor
from talaia.gateway.adapters.rosbridge.protocol import (
    bytes_of,
    nest_fields,
    outcome_of,
    progress_of,
    read_message,
    type_for,
)
from talaia.gateway.errors import FieldError, SettingsError
from talaia.model.site import Command, CommandKind
from talaia.wire.frames import (
    CommandPhase,
    CommandRequest,
    CommandState,
    DeviceState,
    StreamSubscription,
)

from .cbor_writer import head, written
from .rosbridge_bench import recording, replaying

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from gateway_bench import Peer

RECORDED = Path(__file__).parent / "recorded"
REAL = os.environ.get("TALAIA_ROSBRIDGE", "")

SITE = filled("""
talaia: 1
site: far
name: Far robot
connections:
  far: {kind: rosbridge, url: "%s", cbor: %s, keep_log: none}
devices:
  base:
    name: Base
    signals:
      <number, speed>
      spread:
        name: C
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: "pose.covariance[1]"}
      <pose, mode, speed1>
    streams:
      <front>
    commands:
      <wander, fail, absent, horn>
      count:
        name: Count
        kind: action
        target: /count
        type: test_msgs/action/Fibonacci
        progress: sequence[0]
        progress_end: 100
        arguments: {order: {type: integer, field: order}}
    drive: {topic: /cmd_vel, max_speed: 0.2, max_turn: 2, stop: {topic: /stop}}
""")


class NoRobot:
    """Stands where the robot stood when it was recorded."""

    async def do(self, what: str, **more: object) -> None:
        """Do nothing: what the robot did then is in the recording."""

    async def until_heard_by(self, listeners: int) -> None:
        """The recording has it."""


@asynccontextmanager
async def server(name: str, request: pytest.FixtureRequest) -> AsyncIterator[SimpleNamespace]:
    """The real server, recorded, when there is one; else what it said then."""
    path = RECORDED / f"{name}.jsonl"
    if REAL:
        async with recording(REAL, path) as url:
            yield SimpleNamespace(url=url, replay=None)
    else:
        async with replaying(path) as (replay, url):
            yield SimpleNamespace(url=url, replay=replay)


@pytest.fixture
def robot(request: pytest.FixtureRequest) -> Peer | NoRobot:
    return request.getfixturevalue("peer") if REAL else NoRobot()


@pytest.mark.parametrize("form", ["cbor", "json"])
async def test_the_story_of_a_robot_behind_a_real_server(
    form: str, robot: Peer | NoRobot, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    async with server(f"rosbridge-{form}", request) as far, fake_hub(addresses_of) as hub:
        text = SITE % (far.url, "true" if form == "cbor" else "false")
        async with running(hub.url, tmp_path, text):
            await hub.until(lambda: hub.hellos, "a hello")
            await robot.until_heard_by(1)
            await robot.do("mode", text="auto ✓")
            await robot.do("metric", text="{'name': 'speed1', 'magnitude': 1.4}")
            while not hub.values("base/speed"):
                # Its quality of service is best effort: it comes once the server has seen it.
                await robot.do("odom", speed=0.25)
                await asyncio.sleep(0.3)
            await robot.do("count", **{"from": 0, "to": 5, "hz": 20})
            await hub.until(lambda: len(hub.values("base/number")) == 5, "numbers")
            await hub.until(lambda: hub.values("base/speed1") and hub.values("base/mode"), "texts")
            await hub.until(lambda: hub.values("base/pose.yaw"), "a pose")
            assert hub.values("base/number") == [0.0, 1.0, 2.0, 3.0, 4.0]
            assert set(hub.values("base/speed")) == {0.25}
            assert set(hub.values("base/spread")) == {0.0}
            assert set(hub.values("base/pose.x")) == {1.5}
            assert set(hub.values("base/pose.yaw")) == {0.0}
            assert hub.values("base/mode") == ["auto ✓"]
            assert hub.values("base/speed1") == [1.4]
            done = await command(hub, "wander", "wander", active=True)
            assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "wandering")
            failed = await command(hub, "fail", "fail")
            assert (failed.phase, failed.message) == (CommandPhase.FAILED, "the wheel is off")
            absent = await command(hub, "absent", "absent")
            assert absent.phase is CommandPhase.REFUSED
            assert absent.message == "Service /absent does not exist"
            assert (await command(hub, "horn", "horn", tune="la")).phase is CommandPhase.SUCCEEDED
            counted = await command(hub, "count", "count", order=3)
            assert counted.phase is CommandPhase.SUCCEEDED
            await hub.send(StreamSubscription(streams=["base/front"]))
            async with asyncio.timeout(PATIENCE_S):
                while not hub.pictures:
                    await robot.do("image", encoding="rgb8")
                    await asyncio.sleep(0.1)
            red, green, blue = simplejpeg.decode_jpeg(hub.pictures[-1].data)[24, 32]
            assert red > 200
            assert max(green, blue) < 60
            await drive(hub, await take_lease(hub))
            if far.replay is not None:
                driven = far.replay.driven
                await hub.until(lambda: any(speed(one) > 0 for one in driven), "a velocity")
                await hub.until(lambda: speed(driven[-1]) == 0, "a zero")
                assert far.replay.unexpected == []
            else:
                await robot.until(lambda: any(row[0] > 0 for row in robot.heard("cmd")))
                await robot.until(lambda: robot.heard("cmd")[-1] == [0.0, 0.0])
                assert robot.heard("wander") == [True]
                assert robot.heard("horn") == ["la"]


def speed(said: dict) -> float:
    return said["msg"].get("linear", {}).get("x", 0.0)


async def test_a_server_that_goes_away_shows_unknown_within_two_seconds_and_is_found_again(
    tmp_path: Path,
) -> None:
    heard: list[dict] = []

    async def listen(client) -> None:
        async for data in client:
            said = json.loads(data)
            heard.append(said)
            if said["op"] == "subscribe" and said["topic"] == "/number":
                await client.send('{"op": "publish", "topic": "/number", "msg": {"data": 4}}')

    async with fake_hub(addresses_of) as hub:
        first = await serve(listen, "127.0.0.1", 0, compression=None)
        port = first.sockets[0].getsockname()[1]
        text = SITE % (f"ws://127.0.0.1:{port}", "false")
        async with running(hub.url, tmp_path, text):
            await hub.until(lambda: hub.values("base/number") == [4.0], "a sample")
            ask = CommandRequest(id="f", device="base", command="fail", ttl_ms=5000, who="Ada")
            await hub.send(ask)
            await hub.until(lambda: calls_of(heard), "the call")
            with Stopwatch() as watch:
                first.close()
                unknown = await hub.next(CommandState, lambda each: each.phase == "unknown")
                assert "look at the device" in unknown.message
                state = await hub.next(DeviceState)
            assert (state.device, state.reached) == ("base", False)
            assert watch.seconds < 2
            await first.wait_closed()
            calls = len(calls_of(heard))
            async with serve(listen, "127.0.0.1", port, compression=None):
                await hub.next(DeviceState, lambda each: each.reached)
                await hub.until(lambda: hub.values("base/number") == [4.0, 4.0], "a sample")
            # A call is never said twice.
            assert len(calls_of(heard)) == calls == 1


def calls_of(heard: list[dict]) -> list[dict]:
    """Give the calls of commands; what is asked of rosapi is none."""
    return [each for each in heard if each.get("service") == "/fail"]


async def test_a_server_that_stands_still_is_noticed_by_its_pings(tmp_path: Path) -> None:
    async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        # Shakes hands as a server does, and is never heard of again.
        import base64
        import hashlib

        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        key = next(
            each.split(": ")[1]
            for each in head.split("\r\n")
            if each.lower().startswith("sec-websocket-key")
        )
        magic = (key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()
        accepted = base64.b64encode(hashlib.sha1(magic).digest()).decode()  # noqa: S324
        writer.write(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Accept: {accepted}\r\n\r\n".encode()
        )
        await reader.read()
        writer.close()

    one = await asyncio.start_server(accept, "127.0.0.1", 0)
    port = one.sockets[0].getsockname()[1]
    async with fake_hub(addresses_of) as hub:
        async with running(hub.url, tmp_path, SITE % (f"ws://127.0.0.1:{port}", "true")):
            await hub.until(lambda: hub.hellos, "a hello")
            state = await hub.next(DeviceState)
            assert not state.reached
        one.close()


async def test_a_token_is_sent_and_stands_in_no_description(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str] = []

    async def listen(client) -> None:
        seen.append(client.request.headers["Authorization"])
        await client.wait_closed()

    monkeypatch.setenv("FAR_TOKEN", "sesame")
    async with fake_hub(addresses_of) as hub, serve(listen, "127.0.0.1", 0) as far:
        url = f"ws://127.0.0.1:{far.sockets[0].getsockname()[1]}"
        text = (SITE % (url, "true")).replace("cbor:", "token_env: FAR_TOKEN, cbor:")
        async with running(hub.url, tmp_path, text):
            await hub.until(lambda: seen and hub.hellos, "the token")
            assert set(seen) == {"Bearer sesame"}
            assert "sesame" not in hub.hellos[0].description
        monkeypatch.delenv("FAR_TOKEN")
        with pytest.raises(SettingsError, match="FAR_TOKEN"):
            async with running(hub.url, tmp_path, text):
                pass


# ── the protocol, without a server ──


@pytest.mark.parametrize(
    ("said", "phase", "message"),
    [
        ('"values": {"success": true, "message": "m"}, "result": true', "succeeded", "m"),
        ('"values": {"success": false, "message": ""}, "result": true', "failed", "did not"),
        ('"values": "Service /x does not exist", "result": false', "refused", "does not exist"),
        ('"values": "boom", "result": false', "failed", "boom"),
        ('"values": {}', "succeeded", ""),
    ],
)
def test_answers_of_services_end_a_command(said: str, phase: str, message: str) -> None:
    outcome = outcome_of(read_message(f'{{"op": "service_response", "id": "call 1", {said}}}'))
    assert (outcome.phase, message in outcome.message) == (phase, True)


@pytest.mark.parametrize(
    ("status", "phase"),
    [(4, "succeeded"), (5, "cancelled"), (6, "failed"), (0, "unknown"), (99, "unknown")],
)
def test_results_of_actions_end_a_command(status: int, phase: str) -> None:
    said = (
        f'{{"op": "action_result", "id": "1", "values": {{}}, "status": {status}, "result": true}}'
    )
    assert outcome_of(read_message(said)).phase == phase


def test_feedback_tells_the_progress() -> None:
    rule = Command(
        name="C", target="/c", type="a/action/B", kind=CommandKind.ACTION,
        progress="sequence[0]", progress_end=100,
    )  # fmt: skip
    said = read_message('{"op": "action_feedback", "id": "1", "values": {"sequence": [25]}}')
    assert progress_of(said, rule).progress == 0.25
    assert (
        progress_of(read_message('{"op": "action_feedback", "values": {}}'), rule).progress == 0.0
    )


def test_fields_by_path_become_nested_maps_and_lists() -> None:
    assert nest_fields({"a.b": 1, "a.c": True, "d": "x"}) == {"a": {"b": 1, "c": True}, "d": "x"}
    assert nest_fields({"a[0].x": 1, "a[1].x": 2}) == {"a": [{"x": 1}, {"x": 2}]}
    for wrong in ({"a[1]": 1}, {"a": 1, "a.b": 2}):
        with pytest.raises(FieldError):
            nest_fields(wrong)


def test_types_are_written_as_each_ros_does() -> None:
    assert type_for("std_msgs/msg/String", 1) == "std_msgs/String"
    assert type_for("std_msgs/msg/String", 2) == "std_msgs/msg/String"


def test_what_json_cannot_carry_is_read_as_it_was_meant() -> None:
    said = read_message('{"op": "publish", "topic": "/t", "msg": {"data": null}}')
    assert math.isnan(said.body.data)
    picture = bytes_of(read_message('{"op": "publish", "msg": {"data": "AQID"}}').body)
    assert picture.data == b"\x01\x02\x03"
    with pytest.raises(FieldError):
        bytes_of(read_message('{"op": "publish", "msg": {"data": "%%%"}}').body)


@given(st.one_of(st.text(max_size=60), st.binary(max_size=60)))
def test_any_frame_is_read_or_refused(data: str | bytes) -> None:
    with suppress(FieldError):
        read_message(data)


VALUES = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(-(2**63), 2**63), st.floats(allow_nan=False),
        st.binary(max_size=8), st.text(max_size=8),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=4), inner, max_size=4)
    ),
    max_leaves=20,
)  # fmt: skip


@given(VALUES, st.data())
def test_cbor_is_read_back_and_a_cut_one_is_refused(value: object, data: st.DataObject) -> None:
    raw = written(value)
    assert read_cbor(raw, dict) == value
    cut = data.draw(st.integers(0, len(raw) - 1))
    with pytest.raises(FieldError):
        read_cbor(raw[:cut], dict)


def test_typed_arrays_and_small_floats_of_cbor_are_read() -> None:
    doubles = np.array([1.5, -2.0], "<f8").tobytes()
    array = read_cbor(b"\xd8\x56" + head(2, 16) + doubles, dict)
    assert list(array) == [1.5, -2.0]
    assert read_cbor(b"\xf9\x3c\x00", dict) == 1.0
    with pytest.raises(FieldError):
        read_cbor(b"\xd8\x56" + head(2, 3) + b"abc", dict)
    # A length that lies makes no memory.
    with pytest.raises(FieldError):
        read_cbor(head(4, 2**60), dict)
    with pytest.raises(FieldError):
        read_cbor(b"\x81" * 100_000, dict)
