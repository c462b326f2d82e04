"""Topics whose message packages the gateway does not have, between a real robot and a hub."""

from __future__ import annotations

import asyncio
import json
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest
import pytest_asyncio
from fake_hub import FakeHub, fake_hub
from gateway.conftest import peer_in
from gateway_bench import Peer, addresses_of, running
from patience import PATIENCE_S
from rosbags.highlevel import AnyReader

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import topic_of
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import FieldFound, Found
from talaia.model.site import SignalType
from talaia.wire.frames import (
    CommandCancel,
    CommandPhase,
    CommandRequest,
    CommandState,
    Event,
    FileOffer,
    RecorderState,
    RecordingRequest,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

pytestmark = [pytest.mark.robot, pytest.mark.asyncio(loop_scope="module")]
WRONG_HASH = "RIHS01_" + "ab" * 32
MISSING = ("diagnostic_msgs", "trajectory_msgs", "test_msgs")
SITE = """
talaia: 1
site: test
name: Test robot
ros2: {node: gateway_without_packages}
recording: {before: 60, after: 1, upload: 5000, topics: [/arm/trajectory, /own/nested, /own/words]}
devices:
  arm:
    name: Arm
    signals:
      shoulder:
        name: Shoulder
        source:
          topic: /arm/trajectory
          type: trajectory_msgs/msg/JointTrajectory
          field: points[1].positions[0]
      level:
        name: Level
        type: state
        states: [ok, warning, error, stale]
        source:
          topic: /diagnostics
          type: diagnostic_msgs/msg/DiagnosticArray
          field: status[0].level
      words:
        name: Words
        type: text
        source: {topic: /own/words, type: test_msgs/msg/WStrings, field: wstring_value}
      inner:
        name: Inner
        source:
          topic: /own/nested
          type: test_msgs/msg/MultiNested
          field: bounded_sequence_of_bounded_sequences[0].int16_values[1]
      undescribed:
        name: Undescribed
        source:
          topic: /own/undescribed
          type: test_msgs/msg/BoundedSequences
          field: alignment_check
      changed:
        name: Changed
        source:
          topic: /own/changed
          type: test_msgs/msg/Nested
          field: basic_types_value.int32_value
      motor:
        name: Motor
        type: state
        states: [ok, warning, error, stale]
        source:
          topic: /diagnostics
          type: diagnostic_msgs/msg/DiagnosticArray
          name: "motor: left"
      motor_text:
        name: Motor's words
        type: text
        source:
          topic: /diagnostics
          type: diagnostic_msgs/msg/DiagnosticArray
          name: "motor: left"
      temperature:
        name: Temperature
        unit: °C
        source: {topic: /temperature, type: sensor_msgs/msg/Temperature, field: temperature}
      other:
        name: Other
        source: {topic: /mode, type: nowhere_msgs/msg/Odd, field: data}
    commands:
      add:
        name: Add
        target: /add
        type: diagnostic_msgs/srv/AddDiagnostics
        arguments: {space: {type: text, field: load_namespace, max_length: 2000}}
      count:
        name: Count
        kind: action
        target: /count
        type: test_msgs/action/Fibonacci
        progress: sequence[0]
        progress_end: 1000
        arguments: {order: {type: integer, field: order}}
      order:
        name: Order
        kind: topic
        target: /own/orders
        type: test_msgs/msg/MultiNested
        arguments:
          word: {type: text, field: "array_of_arrays[1].string_values[2]"}
          count: {type: integer, field: "array_of_arrays[1].int32_values[0]"}
      speak:
        name: Speak
        kind: topic
        target: /own/speech
        type: test_msgs/msg/WStrings
        arguments:
          word: {type: text, field: wstring_value}
          last: {type: text, field: "array_of_wstrings[2]"}
      unheard: {name: Unheard, kind: topic, target: /nobody, type: test_msgs/msg/Nested}
      misheard: {name: Misheard, kind: topic, target: /own/orders, type: test_msgs/msg/Nested}
      silent:
        name: Silent
        target: /silent/add
        type: diagnostic_msgs/srv/AddDiagnostics
      absent:
        name: Absent
        target: /nobody
        type: diagnostic_msgs/srv/AddDiagnostics
      other_type:
        name: Other type
        target: /add
        type: diagnostic_msgs/srv/SelfTest
      missing:
        name: Missing
        target: /add
        type: nowhere_msgs/srv/Odd
"""


class _WithoutPackages:
    """An import hook that finds no message package of `MISSING`."""

    @staticmethod
    def find_spec(name: str, *_: object) -> None:
        if name.partition(".")[0] in MISSING:
            raise ModuleNotFoundError(f"{name} is kept from this test")


@pytest.fixture(scope="module")
def without_packages() -> Iterator[None]:
    """Let nobody in this process import the packages that only the robot has."""
    kept = {
        name: sys.modules.pop(name)
        for name in list(sys.modules)
        if name.partition(".")[0] in MISSING
    }
    sys.meta_path.insert(0, _WithoutPackages)
    yield
    sys.meta_path.remove(_WithoutPackages)
    sys.modules.update(kept)


def definition_hash(name: str) -> str:
    """Give the hash that ROS's own generator installed for a type."""
    package, middle, short = name.split("/")
    told = json.loads(Path(sys.prefix, "share", package, middle, f"{short}.json").read_bytes())
    return next(each["hash_string"] for each in told["type_hashes"] if each["type_name"] == name)


def look(seconds: float, definitions: Path | None = None) -> Found:
    """Probe the graph; not at the top, for it joins ROS when it is imported."""
    from talaia.gateway.adapters.ros2.probe import probe_graph

    return probe_graph(None, seconds, definitions)


class Bench(NamedTuple):
    """A robot, and the hub of a gateway that hears it."""

    peer: Peer
    hub: FakeHub


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def bench(
    own_domain: int, without_packages: None, tmp_path_factory: pytest.TempPathFactory
) -> AsyncIterator[Bench]:
    pytest.importorskip("rclpy", reason="needs ROS 2")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(own_domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        folder = tmp_path_factory.mktemp("gateway")
        async with (
            peer_in(own_domain, Path(__file__).with_name("types_peer.py")) as peer,
            fake_hub(addresses_of) as hub,
            running(hub.url, folder, SITE),
        ):
            await hub.until(lambda: hub.hellos, "a hello")
            # Once, before or after the gateway listens: their publishers keep them.
            await peer.do("words", text="añ✓😀")
            await peer.do("nested", text="q")
            await peer.do("trajectory", points=[[1, 2], [3.5, 4]])
            await peer.do("undescribed", check=7)
            yield Bench(peer, hub)


async def test_latched_messages_of_types_that_only_the_robot_has_are_read(bench: Bench) -> None:
    hub = bench.hub
    await hub.until(lambda: hub.values("arm/inner") and hub.values("arm/words"), "own types")
    await hub.until(lambda: hub.values("arm/shoulder"), "the arm's plan")
    assert hub.values("arm/words") == ["añ✓😀"]
    assert hub.values("arm/inner") == [-4.0]
    assert hub.values("arm/shoulder") == [3.5]


async def test_a_type_that_its_node_does_not_describe_is_read_by_a_file(bench: Bench) -> None:
    await bench.hub.until(lambda: bench.hub.values("arm/undescribed"), "it")
    assert bench.hub.values("arm/undescribed") == [7.0]


async def test_messages_go_on_coming_in_order(bench: Bench) -> None:
    peer, hub = bench
    async with asyncio.timeout(PATIENCE_S):
        while not hub.values("arm/level"):
            await peer.do("diagnostics", levels={"motor": 2})
            await asyncio.sleep(0.05)
    before = len(hub.values("arm/level"))
    for level in (0, 1, 2, 3) * 10:
        await peer.do("diagnostics", levels={"motor": level})
    await hub.until(lambda: hub.values("arm/level")[before:].count(3.0) == 10, "all")
    assert hub.values("arm/level")[before:][-40:] == [0.0, 1.0, 2.0, 3.0] * 10


async def test_diagnostics_are_read_by_the_name_of_what_they_are_about(bench: Bench) -> None:
    peer, hub = bench
    await hub.until(lambda: hub.values("arm/level"), "diagnostics that are heard")
    await peer.do("diagnostics", levels={"lidar": 1, "motor: left": 2})
    await hub.until(lambda: hub.values("arm/motor_text"), "words")
    assert hub.values("arm/motor") == [2.0]
    assert hub.values("arm/motor_text") == ["motor: left is at 2"]


async def test_samples_have_the_time_of_their_messages_stamp(bench: Bench) -> None:
    peer, hub = bench
    async with asyncio.timeout(PATIENCE_S):
        while not hub.values("arm/temperature"):
            await peer.do("temperature", value=20, late=0)
            await asyncio.sleep(0.05)
    for value, late in ((21, 1.5), (22, 1.0), (23, 3600)):
        await peer.do("temperature", value=value, late=late)
    await hub.until(lambda: 23.0 in hub.values("arm/temperature"), "all")
    times = {
        value: time_us
        for samples in hub.samples.values()
        for name, time_us, value in samples.values()
        if name == "arm/temperature"
    }
    stamps = [stamp // 1000 for stamp in peer.heard("stamp")[-3:]]
    assert [times[21.0], times[22.0]] == stamps[:2]
    # An hour old: its arrival counts.
    assert times[23.0] - stamps[2] > 3_590_000_000


async def test_a_probe_describes_what_only_the_robot_knows(bench: Bench) -> None:
    """By another node, in a thread, while the robot goes on; and what is proposed of it."""
    peer, _ = bench
    looking = asyncio.ensure_future(asyncio.to_thread(look, 4.0))
    while not looking.done():
        await peer.do("diagnostics", levels={"motor: left": 2, "lidar": 0})
        await asyncio.wait([looking], timeout=0.2)
    found = await looking
    topics = {topic.topic: topic for topic in found.topics}
    assert topics["/diagnostics"].names == ("lidar", "motor: left")
    fields = {field.path: field for field in topics["/arm/trajectory"].fields}
    assert fields["points[1].positions[0]"].type == "number"
    fields = {field.path: field for field in topics["/own/undescribed"].fields}
    assert fields["alignment_check"].type == "integer"
    assert topics["/own/words"].fields[0] == FieldFound("wstring_value", "text")
    assert topics["/own/nested"].latched
    assert not topics["/diagnostics"].latched
    assert topics["/own/undescribed"].problem == ""
    services = {service.service: service for service in found.services}
    assert services["/add"].fields == (FieldFound("load_namespace", "text"),)
    assert services["/add"].problem == ""
    actions = {action.action: action for action in found.actions}
    assert actions["/count"].fields == (FieldFound("order", "integer"),)
    site = propose_description(found, "robot", "Robot", "UTC").site
    motor = site.devices["diagnostics"].signals["motor_left"]
    assert (motor.type, motor.states[2]) == (SignalType.STATE, "Error")
    mode = next(
        signal
        for device in site.devices.values()
        for signal in device.signals.values()
        if topic_of(signal.source) == "/mode"
    )
    assert mode.max_age == 0
    assert not [finding for finding in check_site(site) if "$" in finding.where]


async def test_a_probe_reads_types_by_the_definitions_that_are_named(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from talaia.gateway.adapters.ros2.type_definitions import definition_finder

    # As where nothing of the robot's is installed, not even its files.
    monkeypatch.setattr(definition_finder, "ros_prefixes", list)
    for package in ("test_msgs", "builtin_interfaces"):
        shutil.copytree(Path(sys.prefix, "share", package), tmp_path / package)
    problems = []
    for definitions in (None, tmp_path):
        found = await asyncio.to_thread(look, 6.0, definitions)
        (topic,) = (each for each in found.topics if each.topic == "/own/undescribed")
        problems.append(topic.problem)
    assert "test_msgs/msg/BoundedSequences" in problems[0]
    assert problems[1] == ""
    assert "alignment_check" in {field.path for field in topic.fields}
    # The gateway has to read the same.
    ros2 = propose_description(found, "robot", "Robot", "UTC").site.ros2
    assert ros2 is not None
    assert ros2.definitions == str(tmp_path)


async def test_a_topic_of_another_type_than_described_is_named(bench: Bench) -> None:
    event = await bench.hub.next(Event, lambda each: "/mode" in each.message)
    assert "std_msgs/msg/String" in event.message
    assert "nowhere_msgs/msg/Odd" in event.message


async def test_another_version_of_a_type_is_named_with_both_hashes_and_not_read(
    bench: Bench,
) -> None:
    peer, hub = bench
    installed = definition_hash("test_msgs/msg/Nested")
    await peer.do("begin_other_version", topic="/own/changed", type="test_msgs/msg/Nested")
    event = await hub.next(Event, lambda each: "/own/changed" in each.message)
    assert f"its publisher's test_msgs/msg/Nested is {WRONG_HASH}" in event.message
    assert installed in event.message
    assert hub.values("arm/changed") == []


async def test_a_topic_in_two_versions_is_read_again_when_one_has_ended(bench: Bench) -> None:
    peer, hub = bench
    await hub.until(lambda: hub.values("arm/inner"), "the first")
    before = len(hub.values("arm/inner"))
    other = {"topic": "/own/nested", "type": "test_msgs/msg/MultiNested"}
    await peer.do("begin_other_version", **other)
    event = await hub.next(Event, lambda each: "/own/nested" in each.message)
    assert "published in two versions" in event.message
    assert WRONG_HASH in event.message
    assert len(hub.values("arm/inner")) == before
    await peer.do("end_other_version", **other)
    async with asyncio.timeout(PATIENCE_S):
        while len(hub.values("arm/inner")) == before:
            await peer.do("nested", text="again")
            await asyncio.sleep(0.1)
    assert set(hub.values("arm/inner")) == {-4.0}


async def ask(bench: Bench, name: str, number: int, **args: object) -> CommandState:
    """Ask for a command, and wait for how it ends."""
    command_id = f"{name}{number}"
    request = CommandRequest(
        id=command_id, device="arm", command=name, args=args, ttl_ms=5000, who="Ada"
    )
    await bench.hub.send(request)
    under_way = {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
    return await bench.hub.next(
        CommandState, lambda state: state.id == command_id and state.phase not in under_way
    )


async def test_a_service_of_a_type_that_is_not_installed_is_called(bench: Bench) -> None:
    for number, space in enumerate(("/ns", "none", "/" + "é" * 1999)):
        ended = await ask(bench, "add", number, space=space)
        good = CommandPhase.SUCCEEDED if space.startswith("/") else CommandPhase.FAILED
        assert (ended.phase, ended.message) == (good, f"asked for {space[:20]}")
        assert bench.peer.heard("added")[-1] == space


async def test_a_goal_of_a_type_that_is_not_installed_ends_as_the_robot_says(bench: Bench) -> None:
    ended = await ask(bench, "count", 1, order=3)
    assert ended.phase is CommandPhase.SUCCEEDED
    ended = await ask(bench, "count", 2, order=0)
    assert (ended.phase, ended.message) == (
        CommandPhase.REFUSED,
        "the robot does not accept it",
    )
    assert bench.peer.heard("goal") == [3]


async def test_such_a_goal_tells_its_progress_and_is_cancelled(bench: Bench) -> None:
    hub = bench.hub
    await hub.send(
        CommandRequest(
            id="long", device="arm", command="count", args={"order": 1000}, ttl_ms=5000, who="Ada"
        )
    )
    await hub.next(CommandState, lambda state: state.id == "long" and state.progress > 0.004)
    await hub.send(CommandCancel(id="long", device="arm", who="Ada"))
    ended = await hub.next(
        CommandState, lambda state: state.id == "long" and state.phase is CommandPhase.CANCELLED
    )
    assert 0 < ended.progress < 0.9


async def test_a_message_of_a_type_that_is_not_installed_is_published(bench: Bench) -> None:
    for number, word in enumerate(("begin", "añ✓😀")):
        ended = await ask(bench, "order", number, word=word, count=-7)
        assert (ended.phase, ended.message) == (CommandPhase.SUCCEEDED, "published")
        await bench.peer.until(lambda number=number: len(bench.peer.heard("order")) > number)
    assert bench.peer.heard("order") == [["begin", -7, False], ["añ✓😀", -7, False]]


async def test_wide_texts_are_published_as_the_robot_reads_them(bench: Bench) -> None:
    ended = await ask(bench, "speak", 0, word="añ✓😀", last="€")
    assert (ended.phase, ended.message) == (CommandPhase.SUCCEEDED, "published")
    await bench.peer.until(lambda: bench.peer.heard("speech"))
    assert bench.peer.heard("speech") == [["añ✓😀", "", "", "€"]]


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("unheard", "nobody on the robot listens to /nobody"),
        ("misheard", "/own/orders is listened to as test_msgs/msg/MultiNested, not as"),
    ],
)
async def test_a_message_that_nobody_could_read_is_not_published(
    bench: Bench, name: str, why: str
) -> None:
    ended = await ask(bench, name, 0)
    assert ended.phase is CommandPhase.REFUSED
    assert why in ended.message


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("silent", "does not say which version of diagnostic_msgs/srv/AddDiagnostics it has"),
        ("absent", "the robot does not offer /nobody now"),
        ("other_type", "/add is of type diagnostic_msgs/srv/AddDiagnostics, not"),
        ("missing", "install the ROS package nowhere_msgs"),
    ],
)
async def test_a_service_that_cannot_be_called_safely_is_refused(
    bench: Bench, name: str, why: str
) -> None:
    before = len(bench.peer.heard("added"))
    ended = await ask(bench, name, 0)
    assert ended.phase is CommandPhase.REFUSED
    assert why in ended.message
    assert len(bench.peer.heard("added")) == before


async def test_a_service_whose_node_has_another_version_is_not_called(bench: Bench) -> None:
    """By the process that calls, given a hash of no version."""
    before = len(bench.peer.heard("added"))
    module = "talaia.gateway.adapters.ros2.made_types.service_caller"
    caller = await asyncio.create_subprocess_exec(
        sys.executable, "-m", module, "caller_under_test",
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
    )  # fmt: skip
    order = {"number": 1, "service": "/add", "type": "diagnostic_msgs/srv/AddDiagnostics",
             "hash": WRONG_HASH, "request": "AAEAAAEAAAAA"}  # fmt: skip
    assert caller.stdin is not None
    assert caller.stdout is not None
    caller.stdin.write(json.dumps(order).encode() + b"\n")
    told = json.loads(await asyncio.wait_for(caller.stdout.readline(), PATIENCE_S))
    assert "the node /types_peer has another version" in told["refused"]
    caller.stdin.close()
    assert await asyncio.wait_for(caller.wait(), PATIENCE_S) == 0
    assert len(bench.peer.heard("added")) == before


async def test_they_are_recorded_with_definitions_that_others_read_them_by(
    bench: Bench, tmp_path: Path
) -> None:
    hub = bench.hub
    await hub.until(lambda: hub.values("arm/inner") and hub.values("arm/shoulder"), "messages")
    await hub.send(RecordingRequest(on=True, who="ada", why="to look at"))
    await hub.next(RecorderState, lambda state: state.on)
    await hub.send(RecordingRequest(on=False, who="ada"))
    await hub.until(lambda: hub.offers, "an offer")
    offer = hub.offers[-1]
    assert isinstance(offer, FileOffer)
    await hub.until(lambda: len(hub.files[offer.id]) == offer.size, "the file")
    path = tmp_path / "robot.mcap"
    path.write_bytes(hub.files[offer.id])
    with AnyReader([path]) as reader:
        types = {each.topic: each.msgtype for each in reader.connections}
        texts = {each.topic: each.msgdef.data for each in reader.connections}
        plan = next(
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == "/arm/trajectory"
        )
    assert types["/own/nested"] == "test_msgs/msg/MultiNested"
    assert "wstring[<=3] bounded_sequence_of_wstrings" in texts["/own/words"]
    # With the authors' comments, which only the sources tell.
    assert "# Bounded sequences of different types" in texts["/own/nested"]
    assert plan.joint_names == ["shoulder", "elbow"]
    assert list(plan.points[1].positions) == [3.5, 4.0]
