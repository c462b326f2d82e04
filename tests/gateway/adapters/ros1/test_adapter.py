"""The gateway between a real ROS 1 robot (Debian's rosmaster and rospy) and a hub."""

from __future__ import annotations

import asyncio
import json
import struct
import subprocess
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest
import simplejpeg
from fake_hub import FakeHub, fake_hub
from gateway_bench import (
    Peer,
    addresses_of,
    command,
    drive,
    filled,
    running,
    take_lease,
)
from hypothesis import given, strategies as st
from patience import PATIENCE_S, Stopwatch
from ports import free_port

from talaia.cli.importing.decoding import decoder_of
from talaia.cli.importing.mcap_file import McapFile
from talaia.gateway.adapters.ros1.frames import (
    FrameSplitter,
    ReceivedMessage,
    TappedPiece,
    frame_of,
)
from talaia.gateway.adapters.ros1.node import environment_of
from talaia.gateway.errors import AdapterLost
from talaia.wire.frames import (
    CommandCancel,
    CommandPhase,
    CommandRequest,
    CommandState,
    DeviceState,
    Event,
    FileOffer,
    LeaseState,
    ReconnectRequest,
    RecorderState,
    RecordingRequest,
    StopRequest,
    StopState,
    StreamSubscription,
)

from . import ros1_bench

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

SCRIPT = Path(__file__).parents[4] / "src/talaia/gateway/adapters/ros1/bridge.py"

SITE = filled("""
talaia: 1
site: old
name: ROS 1 robot
connections:
  old: {kind: ros1, master: "http://127.0.0.1:%d"}
devices:
  base:
    name: Base
    signals:
      <number, speed, pose, mode>
      state:
        name: State
        type: state
        states: [idle, auto]
        source: {topic: /mode, type: std_msgs/msg/String, field: data}
      range: {name: R, source: {topic: /scan, type: sensor_msgs/msg/LaserScan, field: "ranges[1]"}}
      flag: {name: F, source: {topic: /odd, type: nowhere_msgs/msg/Odd, field: "flags[1]"}}
      axis: {name: A, source: {topic: /odd, type: nowhere_msgs/msg/Odd, field: "axes[2]"}}
      word:
        name: W
        type: text
        source: {topic: /odd, type: nowhere_msgs/msg/Odd, field: other.word}
      gain: {name: G, source: {parameter: /base/gain}}
      limits: {name: L, type: text, source: {parameter: /base/limits}}
      wrong: {name: X, source: {topic: /stop, type: std_msgs/msg/Float64, field: data}}
    streams:
      <front>
      small: {name: S, source: {topic: /images/compressed, type: sensor_msgs/msg/CompressedImage}}
    commands:
      <wander, fail, absent, horn>
      slow: {name: Slow, target: /slow, type: std_srvs/srv/Trigger, timeout: 60}
      odd: {name: Odd, target: /odd, type: nowhere_msgs/srv/Odd}
      count:
        name: Count
        kind: action
        target: /count
        type: actionlib/action/Test
        progress: feedback
        progress_end: 10
        arguments: {to: {type: integer, field: goal, minimum: 0, maximum: 100}}
      tune:
        name: Tune
        kind: parameter
        target: /base
        arguments:
          gain: {type: number, field: gain}
          limits: {type: numbers, field: limits, default: ""}
    drive:
      topic: /cmd_vel
      max_speed: 0.2
      max_turn: 2
      stop: {topic: /stop, confirmed_by: [base/speed]}
  cart:
    name: A CloudConnect vehicle
    signals:
      speed1: {name: M, source: {topic: /metric, type: std_msgs/msg/String, name: speed1}}
    streams:
      images: {name: Camera, source: {topic: /images, type: sensor_msgs/msg/Image}}
    drive: {topic: /control, message: std_msgs/msg/String, max_speed: 1, max_turn: 1}
  lift:
    name: Stamped
    drive: {topic: /cmd_vel_stamped, message: geometry_msgs/msg/TwistStamped, max_speed: 1,
            max_turn: 1}
""")


class Robot(NamedTuple):
    """One hub and one robot, and where they are."""

    hub: FakeHub
    peer: Peer
    port: int
    home: Path


@pytest.fixture
def ros1_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    ros1_bench.need_ros1()
    home = tmp_path / "ros"
    home.mkdir()
    monkeypatch.setenv("ROS_HOME", str(home))
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    return home


@pytest.fixture
def port(ros1_home: Path) -> Iterator[int]:
    number = free_port()
    with ros1_bench.master(number, ros1_home):
        yield number


@pytest.fixture
async def robot(port: int, ros1_home: Path, tmp_path: Path) -> AsyncIterator[Robot]:
    async with (
        ros1_bench.robot(port, ros1_home) as peer,
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "data", SITE % port),
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1, to_all=True)
        yield Robot(hub, peer, port, ros1_home)


pytestmark = pytest.mark.robot


async def seen(hub: FakeHub, kind: type, which) -> object:
    """Wait for a message that fits; what else came stays to be looked at."""

    def found() -> list:
        return [each for each in hub.messages if isinstance(each, kind) and which(each)]

    await hub.until(found, f"a {kind.__name__} that fits")
    return found()[0]


async def test_raw_messages_are_recorded_with_the_definitions_that_came_with_them(
    port: int, ros1_home: Path, tmp_path: Path
) -> None:
    """Also a topic that no signal reads; an import reads the file without any package."""
    text = SITE % port + "\nrecording: {upload: 5000, topics: [/number, /odd, /images]}\n"
    async with (
        ros1_bench.robot(port, ros1_home) as peer,
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "data", text) as gateway,
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        ring = gateway.recording.recorder._ring
        await peer.do("count", **{"from": 0, "to": 20, "hz": 400})
        async with asyncio.timeout(PATIENCE_S):
            while {raw.topic for raw in list(ring._held)} != {"/number", "/odd", "/images"}:
                # Until the robot has found who listens.
                await peer.do("odd", flags=[7, 9], word="héllo")
                await peer.do("image", encoding="rgb8")
                await asyncio.sleep(0.05)
        await hub.until(lambda: len(hub.values("base/number")) == 20, "numbers")
        await hub.send(RecordingRequest(on=True, who="Ada"))
        await hub.next(RecorderState, lambda state: state.on)
        await hub.send(RecordingRequest(on=False, who="Ada"))

        def offers() -> list[FileOffer]:
            # Of the camera there is a film beside it.
            return [each for each in hub.offers if isinstance(each, FileOffer)]

        await hub.until(offers, "an offer")
        offer = offers()[-1]
        await hub.until(lambda: len(hub.files[offer.id]) == offer.size, "the whole file")
    path = tmp_path / "robot.mcap"
    path.write_bytes(hub.files[offer.id])
    recorded = McapFile(path)
    read = {number: decoder_of(known) for number, (_, known) in recorded.topics.items()}
    found: dict[str, list] = {}
    for number, _, data in recorded.iterate_messages(list(read)):
        found.setdefault(recorded.topics[number][0], []).append(read[number](data))
    recorded.close()
    assert [each.data for each in found["/number"]] == [float(each) for each in range(20)]
    assert found["/odd"][0].other.word == "héllo"
    assert found["/images"][0].encoding == "rgb8"
    assert {known.encoding for _, known in recorded.topics.values()} == {"ros1"}


async def test_every_kind_of_signal_is_read_of_any_type(robot: Robot) -> None:
    hub, peer = robot.hub, robot.peer
    await peer.do("count", **{"from": 0, "to": 200, "hz": 400})
    await peer.do("mode", text="auto")
    await peer.do("odom", speed=0.25)
    await peer.do("scan", ranges=[1.0, 2.5, 3.0])
    await peer.do("odd", flags=[7, 9], word="héllo")
    await peer.do("metric", text="{'name': 'speed1', 'magnitude': 1.5}")
    await peer.do("metric", text='{"name": "speed1", "magnitude": 2.5}')
    await peer.until(lambda: peer.heard("counted"))
    await hub.until(lambda: len(hub.values("base/number")) == 200, "numbers")
    await hub.until(lambda: len(hub.values("cart/speed1")) == 2, "metrics")
    await hub.until(lambda: hub.values("base/word"), "a word")
    assert hub.values("base/number") == [float(each) for each in range(200)]
    assert hub.values("base/speed") == [0.25]
    assert (hub.values("base/pose.x"), hub.values("base/pose.yaw")) == ([1.5], [0.0])
    assert hub.values("base/mode") == ["auto"]
    assert hub.values("base/state") == [1.0]
    assert hub.values("base/range") == [2.5]
    # A type that no machine but the robot has: read by the definition it sends.
    assert hub.values("base/flag") == [9.0]
    assert hub.values("base/axis") == [3.0]
    assert hub.values("base/word") == ["héllo"]
    assert hub.values("cart/speed1") == [1.5, 2.5]


async def test_a_parameter_is_set_and_read(robot: Robot) -> None:
    hub = robot.hub
    assert hub.values("base/gain") == []
    assert (await command(hub, "tune", "t1", gain=2.5)).phase is CommandPhase.SUCCEEDED
    await hub.until(lambda: hub.values("base/gain"), "the parameter")
    assert hub.values("base/gain")[-1] == 2.5
    assert (await command(hub, "tune", "t2", gain=1, limits="1, 2.5")).phase is (
        CommandPhase.SUCCEEDED
    )
    await hub.until(lambda: hub.values("base/limits")[-1:] == ["[1.0, 2.5]"], "the list")


async def test_driving_reaches_each_kind_of_listener_and_ends_in_zeros(robot: Robot) -> None:
    hub, peer = robot.hub, robot.peer
    for device, key, moving, still in (
        ("base", "cmd", [0.2, 0.0], [0.0, 0.0]),
        ("cart", "control", "w", "s"),
        ("lift", "stamped", None, [0.0, 0.0]),
    ):
        await drive(hub, await take_lease(hub, device), device=device)
        # Whoever is driven by characters is told to halt when the gateway starts, too.
        await peer.until(
            lambda key=key, still=still: (
                any(each != still for each in peer.heard(key)) and peer.heard(key)[-1] == still
            )
        )
        moved = [each for each in peer.heard(key) if each != still]
        if device == "cart":
            assert moved == [moving]
    # A stamp of 0 stays the robot's own now.
    assert {row[1] for row in peer.heard("stamped")} == {0.0}
    assert max(row[0] for row in peer.heard("cmd")) <= 0.2


async def test_stop_reaches_the_robot_and_is_confirmed_by_it(robot: Robot) -> None:
    hub, peer = robot.hub, robot.peer
    await hub.send(StopRequest(device="base", id="s1", who="Ada"))
    assert (await hub.next(StopState, lambda each: each.id == "s1")).latched
    await peer.until(lambda: True in peer.heard("stop") and [0.0, 0.0] in peer.heard("cmd"))
    assert set(peer.heard("stop")) == {True}
    confirmed = asyncio.ensure_future(hub.next(StopState, lambda each: each.confirmed))
    while not confirmed.done():
        await peer.do("odom", speed=0.0)
        await asyncio.wait([confirmed], timeout=0.05)
    assert confirmed.result().confirmed


async def test_commands_end_as_the_robot_says(robot: Robot) -> None:
    hub, peer = robot.hub, robot.peer
    told = await hub.next(Event, lambda each: each.kind == "type_missing")
    assert "nowhere_msgs" in told.message
    done = await command(hub, "wander", "w1", active=True)
    assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "wandering")
    failed = await command(hub, "fail", "f1")
    assert (failed.phase, failed.message) == (CommandPhase.FAILED, "the wheel is off")
    absent = await command(hub, "absent", "a1")
    assert (absent.phase, "/absent" in absent.message) == (CommandPhase.REFUSED, True)
    odd = await command(hub, "odd", "o1")
    assert (odd.phase, "nowhere_msgs/srv/Odd" in odd.message) == (CommandPhase.REFUSED, True)
    assert (await command(hub, "horn", "h1", tune="la")).phase is CommandPhase.SUCCEEDED
    await peer.until(lambda: peer.heard("horn") == ["la"])
    assert peer.heard("wander") == [True]


async def test_an_action_tells_its_progress_its_end_and_is_cancelled(robot: Robot) -> None:
    hub, peer = robot.hub, robot.peer
    ask = CommandRequest(
        id="c1", device="base", command="count", args={"to": 10}, ttl_ms=5000, who="A"
    )
    await hub.send(ask)
    done = await seen(hub, CommandState, lambda x: x.id == "c1" and x.phase == "succeeded")
    assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "counted")
    shares = [
        each.progress
        for each in hub.messages
        if isinstance(each, CommandState) and each.phase is CommandPhase.RUNNING
    ]
    assert shares == sorted(shares)
    assert any(0.0 < share < 1.0 for share in shares)
    bad = await command(hub, "count", "c2", to=13)
    assert (bad.phase, bad.message) == (CommandPhase.FAILED, "thirteen brings bad luck")
    ask = CommandRequest(
        id="c3", device="base", command="count", args={"to": 90}, ttl_ms=5000, who="A"
    )
    await hub.send(ask)
    await peer.until(lambda: 90 in peer.heard("goal"))
    await hub.send(CommandCancel(id="c3", device="base", who="Ben"))
    ended = await hub.next(
        CommandState, lambda x: x.id == "c3" and x.phase is CommandPhase.CANCELLED
    )
    assert ended.message == "stopped half way"


async def test_pictures_come_only_while_somebody_looks(robot: Robot) -> None:
    hub, peer = robot.hub, robot.peer

    async def show(stream: str, **what: object) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not [each for each in hub.pictures if each.stream == stream]:
                await peer.do(**what)
                await asyncio.sleep(0.05)

    await peer.do("image", encoding="rgb8")
    await peer.do("count", **{"from": 0, "to": 3, "hz": 10})
    await hub.until(lambda: len(hub.values("base/number")) == 3, "samples behind the picture")
    assert hub.pictures == []
    await hub.send(StreamSubscription(streams=["cart/images", "base/small"]))
    await show("cart/images", what="image", encoding="rgb8")
    red, green, blue = simplejpeg.decode_jpeg(hub.pictures[-1].data)[24, 32]
    assert red > 200
    assert max(green, blue) < 60
    await show("base/small", what="jpeg", hex=hub.pictures[-1].data.hex())
    assert "base/front" not in {each.stream for each in hub.pictures}


async def test_a_topic_of_another_type_is_told_once_with_both_names(robot: Robot) -> None:
    hub = robot.hub
    await hub.send(StopRequest(device="base", id="s1", who="Ada"))
    told = await hub.next(Event, lambda each: each.kind == "unreadable")
    assert "/stop" in told.message
    assert "std_msgs/msg/Bool" in told.message
    assert "std_msgs/msg/Float64" in told.message


async def test_a_device_connected_anew_says_what_is_not_there(robot: Robot) -> None:
    hub, peer = robot.hub, robot.peer
    await hub.send(ReconnectRequest(device="base", who="Ada"))
    told = await hub.next(Event, lambda each: each.kind.startswith("device "))
    assert told.kind == "device not reconnected"
    assert "/absent (no such service now)" in told.message
    assert "/number" not in told.message
    await peer.until_heard_by(1)
    await peer.do("count", **{"from": 0, "to": 5, "hz": 100})
    await hub.until(lambda: len(hub.values("base/number")) == 5, "samples")


async def test_a_restart_of_the_master_shows_unknown_at_once_and_all_is_back_by_itself(
    ros1_home: Path, tmp_path: Path
) -> None:
    port = free_port()
    async with fake_hub(addresses_of) as hub:
        with ros1_bench.master(port, ros1_home) as first:
            async with ros1_bench.robot(port, ros1_home) as peer:
                gateway = running(hub.url, tmp_path / "data", SITE % port)
                await gateway.__aenter__()
                await hub.until(lambda: hub.hellos, "a hello")
                await peer.until_heard_by(1)
                await drive(hub, await take_lease(hub))
                await peer.until(lambda: any(row[0] > 0 for row in peer.heard("cmd")))
                ask = CommandRequest(id="s", device="base", command="slow", ttl_ms=5000, who="Ada")
                await hub.send(ask)
                await peer.until(lambda: peer.heard("slow"))
                with Stopwatch() as watch:
                    first.kill()
                    state = await seen(hub, DeviceState, lambda x: x.device == "base")
                assert not state.reached
                assert "no ROS master answers" in state.why
                assert watch.seconds < 2.0
                unknown = await seen(hub, CommandState, lambda x: x.phase == "unknown")
                assert "look at the device" in unknown.message
                await seen(hub, LeaseState, lambda x: x.device == "base" and not x.session)
                await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])
        kinds = [each.kind for each in hub.messages if isinstance(each, Event)]
        assert kinds.count("connection lost") == 1
        try:
            with ros1_bench.master(port, ros1_home):
                async with ros1_bench.robot(port, ros1_home) as peer:
                    await seen(hub, DeviceState, lambda x: x.device == "base" and x.reached)
                    await peer.until_heard_by(1)
                    await peer.do("count", **{"from": 7, "to": 8, "hz": 100})
                    await hub.until(lambda: 7.0 in hub.values("base/number"), "a sample")
                    assert (await command(hub, "wander", "w", active=True)).phase == "succeeded"
                    assert not [row for row in peer.heard("cmd") if row != [0.0, 0.0]]
        finally:
            await gateway.__aexit__(None, None, None)


class Bridge:
    """The node's process, told by the test as by a gateway."""

    def __init__(self, port: int, home: Path) -> None:  # noqa: D107
        self.process = subprocess.Popen(
            [ros1_bench.PYTHON, "-u", str(SCRIPT)],
            env=ros1_bench.environment(port, home),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self.tell(node="under_test", namespace="/")
        assert self.process.stdout is not None
        size, _ = struct.unpack("<IB", self.process.stdout.read(5))
        assert json.loads(self.process.stdout.read(size - 1)) == {
            "op": "ready",
            "node": "/under_test",
        }
        zero = {"linear.x": 0.0, "angular.z": 0.0}
        kind = "geometry_msgs/msg/Twist"
        self.tell(op="voice", id="drive", topic="/cmd_vel", type=kind, zero=zero)

    def tell(self, **what: object) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(frame_of(what))
        self.process.stdin.flush()

    def move(self) -> None:
        self.tell(op="say", id="drive", fields={"linear.x": 0.1, "angular.z": 0.0})

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            pipe.close()


@pytest.mark.parametrize("end", ["dies", "falls silent"])
async def test_the_node_says_zero_when_its_gateway_ends(
    end: str, port: int, ros1_home: Path
) -> None:
    async with ros1_bench.robot(port, ros1_home) as peer:
        bridge = Bridge(port, ros1_home)
        try:
            async with asyncio.timeout(PATIENCE_S):
                while not peer.heard("cmd"):
                    bridge.move()
                    await asyncio.sleep(0.05)
            bridge.move()
            last = time.monotonic_ns()
            if end == "dies":
                bridge.process.stdin.close()
            await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])
            took = peer.rows[-1]["at"] - last
            assert took < (0.5e9 if end == "dies" else 1.5e9)
            if end == "dies":
                assert bridge.process.wait(PATIENCE_S) == 0
        finally:
            bridge.close()


# ── the frames, without ROS ──


@given(
    st.lists(
        st.one_of(
            st.dictionaries(st.text(max_size=5), st.integers(), max_size=3),
            st.tuples(st.integers(0, 65535), st.integers(0, 2**62), st.binary(max_size=50)),
        ),
        max_size=8,
    ),
    st.integers(1, 40),
)
def test_frames_are_read_however_the_pipe_cuts_them(said: list, cut: int) -> None:
    sent, expected = b"", []
    for each in said:
        if isinstance(each, dict):
            frame = {**each, "op": "x"}
            sent, expected = sent + frame_of(frame), [*expected, frame]
        else:
            body = struct.pack("<Hq", *each[:2]) + each[2]
            sent += struct.pack("<IB", len(body) + 1, 1) + body
            expected.append(ReceivedMessage(*each))
    reader, found = FrameSplitter(), []
    for start in range(0, len(sent), cut):
        found += reader.split_data(sent[start : start + cut])
    assert found == expected


@given(st.binary(max_size=60))
def test_any_bytes_are_frames_or_a_lost_adapter(data: bytes) -> None:
    with suppress(AdapterLost):
        assert all(
            isinstance(each, ReceivedMessage | TappedPiece | dict)
            for each in FrameSplitter().split_data(data)
        )


def test_the_node_gets_nothing_that_is_for_our_python_only() -> None:
    ours = {"PATH": "/bin", "LD_LIBRARY_PATH": "/wheels", "ROS_IP": "10.0.0.1"}
    theirs = environment_of("http://robot:11311", ours)
    assert theirs == {
        "PATH": "/bin", "ROS_IP": "10.0.0.1", "ROS_MASTER_URI": "http://robot:11311"
    }  # fmt: skip
