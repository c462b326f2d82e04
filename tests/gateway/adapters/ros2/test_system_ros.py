"""A gateway whose ROS 2 is a system's: all of it is done by a process of that ROS's own Python.

The other Python is this one, with the wheels, unless ``TALAIA_TEST_ROS_PYTHON`` names one that has
rclpy (`make proofs ONLY=bridge` makes one of Python 3.10). The robot is a process with rclpy.
"""

from __future__ import annotations

import ast
import asyncio
import os
import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from fake_hub import FakeHub, fake_hub
from gateway.adapters.ros2.bridged_program import bridge_of, bridged, bridged_environment
from gateway_bench import addresses_of, command, drive, take_lease
from patience import PATIENCE_S
from websockets.protocol import State

from talaia.gateway.adapters.ros2.rclpy_bridge.velocities import STALE_NS, VelocityPublisher
from talaia.model.closed_lists import ArgumentType
from talaia.model.discovery.probe_report import found_from
from talaia.wire.frames import CommandPhase, DriveState, StopRequest, StopState

if TYPE_CHECKING:
    from gateway_bench import Peer

SOURCES = Path(__file__).parents[4] / "src/talaia/gateway/adapters/ros2"


async def driving(hub: FakeHub, peer: Peer) -> None:
    """Take the lease and drive until the robot moves."""
    epoch = await take_lease(hub)
    before = len(peer.heard("cmd"))
    async with asyncio.timeout(PATIENCE_S):
        while not any(row[0] > 0 for row in peer.heard("cmd")[before:]):
            await drive(hub, epoch)
            await asyncio.sleep(0.02)


async def counted(hub: FakeHub, peer: Peer, first: int) -> None:
    await peer.do("count", **{"from": first, "to": first + 200, "hz": 400})
    wanted = [float(each) for each in range(first, first + 200)]
    await hub.until(lambda: hub.values("base/number")[-200:] == wanted, "all numbers, in order")


@pytest.mark.robot
@pytest.mark.timeout(90)
async def test_all_that_a_gateway_does_with_ros2_goes_through_the_other_python(
    peer: Peer, tmp_path: Path
) -> None:
    async with fake_hub(addresses_of) as hub, bridged(hub.url, tmp_path) as gateway:
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        await counted(hub, peer, 0)
        await peer.do("mode", text="auto ✓")
        await hub.until(lambda: hub.values("base/mode") == ["auto ✓"], "a latched text")
        async with asyncio.timeout(PATIENCE_S):
            while not (hub.values("base/pose.x") and hub.values("base/speed1")):
                await peer.do("odom", speed=0.25)
                await peer.do("metric", text="{'name': 'speed1', 'magnitude': 1.4}")
                await asyncio.sleep(0.1)
        assert (hub.values("base/pose.x")[-1], hub.values("base/speed")[-1]) == (1.5, 0.25)
        await hub.until(lambda: 1.5 in hub.values("base/gain"), "a parameter")
        for name, args, phase, words in (
            ("tune", {"gain": 2.5}, CommandPhase.SUCCEEDED, ""),
            ("wander", {"active": True}, CommandPhase.SUCCEEDED, "wandering"),
            ("fail", {}, CommandPhase.FAILED, "the wheel is off"),
            ("absent", {}, CommandPhase.REFUSED, "/absent"),
            ("horn", {"tune": "la"}, CommandPhase.SUCCEEDED, ""),
            ("count", {"order": 5}, CommandPhase.SUCCEEDED, ""),
            ("count", {"order": 13}, CommandPhase.FAILED, ""),
        ):
            done = await command(hub, name, f"{name} {args}", **args)
            assert (done.phase, words in done.message) == (phase, True), done
        await hub.send(StopRequest(device="base", id="s1", who="Ada"))
        assert (await hub.next(StopState, lambda state: state.id == "s1")).latched
        await peer.until(lambda: True in peer.heard("stop"))
        assert (peer.heard("horn"), peer.heard("goal")) == (["la"], [5, 13])
        await hub.until(lambda: 2.5 in hub.values("base/gain"), "the parameter that was set")
        # Its process dies, and the gateway begins another.
        os.kill(bridge_of(gateway.pid), signal.SIGKILL)
        async with asyncio.timeout(PATIENCE_S):
            while hub.values("base/number")[-1] != 1000:
                await peer.do("count", **{"from": 1000, "to": 1001, "hz": 10})
                await asyncio.sleep(0.1)
        done = await command(hub, "wander", "again", active=True)
        assert done.phase is CommandPhase.SUCCEEDED


@pytest.mark.robot
async def test_a_probe_sees_a_robot_through_the_other_python(peer: Peer) -> None:
    probe = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "talaia", "probe", "--ros2", "--seconds", "4", "--json",
        stdout=asyncio.subprocess.PIPE, env=bridged_environment(),
    )  # fmt: skip
    said, _ = await asyncio.wait_for(probe.communicate(), PATIENCE_S)
    found = found_from(said, "the probe")
    fields = {topic.topic: {field.path for field in topic.fields} for topic in found.topics}
    assert fields["/number"] == {"data"}
    assert "twist.twist.linear.x" in fields["/odom"]
    assert {service.service for service in found.services} >= {"/wander", "/fail"}
    assert [field.path for action in found.actions for field in action.fields] == ["order"]
    assert peer.heard("cmd") == []


@pytest.mark.robot
@pytest.mark.timeout(90)
async def test_a_robot_comes_to_rest_when_its_gateway_freezes_or_is_killed(
    peer: Peer, tmp_path: Path
) -> None:
    async with fake_hub(addresses_of) as hub, bridged(hub.url, tmp_path) as gateway:
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        bridge = bridge_of(gateway.pid)
        await driving(hub, peer)
        gateway.send_signal(signal.SIGSTOP)
        frozen_ns = time.monotonic_ns()
        await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])
        at = next(row["at"] for row in reversed(peer.rows) if row.get("cmd", [0])[0] > 0)
        # The last velocity stood for half a second, and a busy machine may be late.
        assert peer.rows[-1]["at"] - max(at, frozen_ns) < 1.5e9
        gateway.send_signal(signal.SIGCONT)
        await hub.next(DriveState, lambda state: state.linear == 0)
        # Its link may have been lost meanwhile.
        await hub.until(lambda: hub.links[-1].state is State.OPEN, "a link")
        await driving(hub, peer)
        gateway.kill()
        await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])
        # It ends by itself.
        await hub.until(lambda: not Path(f"/proc/{bridge}").exists(), "its end")


class Outlet:
    """What stands for rclpy's publisher."""

    def __init__(self) -> None:  # noqa: D107
        self.published: list[bytes] = []

    def publish(self, message: bytes) -> None:
        self.published.append(message)


def test_a_velocity_that_has_waited_in_the_pipe_is_not_published_and_a_zero_always() -> None:
    outlet = Outlet()
    publisher = VelocityPublisher(outlet, b"zero")
    now = time.monotonic_ns()
    publisher.publish(b"fast", now)
    publisher.publish(b"of the past", now - STALE_NS - 1)
    publisher.publish(b"zero", now - 10 * STALE_NS)
    assert outlet.published == [b"fast", b"zero"]


def test_a_zero_leaves_the_wheels_as_they_were_told_last_and_not_as_of_the_past() -> None:
    outlet = Outlet()
    # Two letters of speed, one of the angle.
    publisher = VelocityPublisher(outlet, b"00-", (2, 3))
    now = time.monotonic_ns()
    publisher.publish(b"99L", now)
    publisher.publish(b"99R", now - STALE_NS - 1)
    publisher.end_silence(0.0)
    assert outlet.published == [b"99L", b"00L"]
    publisher.publish(b"00L", now - 10 * STALE_NS)
    publisher.end_silence(60.0)
    assert outlet.published[2:3] == [b"00L"]


def test_zeros_follow_a_velocity_that_nobody_renews_and_nothing_else() -> None:
    outlet = Outlet()
    publisher = VelocityPublisher(outlet, b"zero")
    publisher.end_silence(0.0)
    assert outlet.published == []
    publisher.publish(b"fast", time.monotonic_ns())
    publisher.end_silence(60.0)
    assert outlet.published == [b"fast"]
    publisher.end_silence(0.0)
    publisher.end_silence(0.0)
    assert outlet.published == [b"fast", b"zero", b"zero"]


@pytest.mark.parametrize(
    ("kind", "items", "shown"),
    [
        (ArgumentType.NUMBERS, [0.5, 3.0], "[0.5, 3.0]"),
        (ArgumentType.INTEGERS, [1, -(2**40)], "[1, -1099511627776]"),
        (ArgumentType.BOOLEANS, [True, False], "[true, false]"),
        (ArgumentType.TEXTS, ["a, b"], '["a, b"]'),
        (ArgumentType.BYTES, [0, 255], "[0, 255]"),
    ],
)
def test_a_list_parameter_goes_through_a_bridge_as_it_goes_by_rclpy(
    kind: ArgumentType, items: list[object], shown: str
) -> None:
    pytest.importorskip("rclpy", reason="needs ROS 2")
    from rcl_interfaces.msg import ParameterValue
    from rclpy.serialization import deserialize_message, serialize_message

    from talaia.gateway.adapters.ros2.nodes.parameters import fill_list, value_of
    from talaia.gateway.adapters.ros2.rclpy_bridge.descriptions import describe_type
    from talaia.gateway.adapters.ros2.system_ros.types import RemoteMessage

    # As the bridge answers, which is not needed here.
    remote = RemoteMessage("rcl_interfaces/msg/ParameterValue", lambda _, name: describe_type(name))
    ours, theirs = remote(), ParameterValue()
    for one in (ours, theirs):
        fill_list(one, kind, items)
        assert value_of(one) == shown
    encoded = remote.encode(ours)
    assert deserialize_message(encoded, ParameterValue) == theirs
    assert value_of(remote.decode(serialize_message(theirs))) == shown


@pytest.mark.parametrize(
    "file",
    sorted([SOURCES / "bridge.py", *SOURCES.glob("rclpy_bridge/*.py")]),
    ids=lambda p: p.stem,
)
def test_what_the_other_python_runs_is_written_for_it_and_needs_ros_alone(file: Path) -> None:
    tree = ast.parse(file.read_text(), feature_version=(3, 8))
    imported = {
        name.split(".")[0]
        for node in ast.walk(tree)
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom) and not node.level
            else []
        )
    }
    # The last is ROS's own from Iron on; Humble is done without it.
    known = {"rclpy", "rclpy_bridge", "std_msgs", "type_description_interfaces"}
    assert imported - set(sys.stdlib_module_names) <= known
