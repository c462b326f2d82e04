"""What is seen of a real ROS 1 graph (Debian's rosmaster and rospy), and what is made of it."""

from __future__ import annotations

import asyncio
import struct
import xmlrpc.client
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import pytest
from hypothesis import given, strategies as st
from ports import free_port

from talaia.gateway.adapters.message_fields import shape_of
from talaia.gateway.adapters.ros1.master import fields_of, header_of
from talaia.gateway.adapters.ros1.message_types import definition_of
from talaia.gateway.adapters.ros1.probe import probe_graph
from talaia.gateway.errors import AdapterLost, FieldError
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import Found
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

from . import ros1_bench

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from gateway_bench import Peer

DEFINITION = """
uint8 MODE_IDLE=0
uint8 MODE_AUTO=1
string NAME=robot
uint8 mode
# how far [m]
float32 reach
Part[2] parts
time when
duration[] waits
================================================================================
MSG: own_msgs/Part
float64 hot   # in degrees Celsius
bool[3] flags
"""
# As `rosparam` sets them: some within the robot's own node, some in no node's name space.
PARAMETERS = {
    "/robot_peer/gain": 0.5,
    "/robot_peer/enabled": True,
    "/robot_peer/costmap/width": 40,
    "/robot_peer/frame": "base_link",
    "/robot_peer/wifi_password": "hush",
    "/robot_peer/cloud": {"key": "hush", "keyframes": 3},
    "/robot_peer/gains": [1, 2.5],
    "/robot_peer/legs": [[1], [2]],
    "/robot_peer/nobody": [],
    "/robot_peer/rooms": ["hall", "lab"],
    "/robot_description": "<robot/>" * 100,
    "/base/track": 0.4,
    "/gain": 1.0,
    "/use_sim_time": True,
}


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_IP", "127.0.0.1")


@asynccontextmanager
async def robot(tmp_path: Path) -> AsyncIterator[tuple[int, Peer]]:
    ros1_bench.need_ros1()
    port = free_port()
    with ros1_bench.master(port, tmp_path):
        async with ros1_bench.robot(port, tmp_path) as peer:
            yield port, peer


async def seen(tmp_path: Path, seconds: float = 3.0) -> Found:
    """Look at the robot while it publishes at 10 Hz."""
    async with robot(tmp_path) as (port, peer):
        with xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}") as master:
            for name, value in PARAMETERS.items():
                master.setParam("/test", name, value)
        looking = asyncio.ensure_future(
            asyncio.to_thread(probe_graph, f"http://127.0.0.1:{port}", seconds)
        )
        await peer.do("mode", text="auto")
        while not looking.done():
            await peer.do("odom", speed=0.5)
            await peer.do("metric", text="{'name': 'speed1', 'magnitude': 1.4}")
            await peer.do("metric", text='{"name": "light 2", "magnitude": 3}')
            await peer.do("odd", flags=[7, 8], word="x")
            await peer.do("image", encoding="rgb8")
            await asyncio.sleep(0.1)
        return await looking


async def test_a_probe_lists_topics_services_and_actions_of_types_that_no_package_here_has(
    tmp_path: Path,
) -> None:
    found = await seen(tmp_path)
    assert msgspec.json.decode(msgspec.json.encode(found), type=Found) == found
    topics = {each.topic: each for each in found.topics}
    assert 7 < topics["/odom"].rate < 13
    assert topics["/odom"].type == "nav_msgs/msg/Odometry"
    speeds = {each.path: each.unit for each in topics["/odom"].fields}
    assert speeds["twist.twist.linear.x"] == "m/s"
    odd = [each.path for each in topics["/odd"].fields]
    assert odd == ["flags[0]", "flags[1]", "axes[0]", "axes[1]", "axes[2]", "other.word"]
    assert topics["/metric"].names == ("light 2", "speed1")
    assert topics["/mode"].publishers == 1
    # Nothing was ever said under the last of them: its publisher was asked.
    latched = ("/mode", "/odd", "/odom", "/kept")
    assert [topics[each].latched for each in latched] == [True, False, False, True]
    assert {each.path for each in topics["/kept"].fields} >= {"axes[0]", "other.word"}
    assert found.sim_time
    assert topics["/cmd_vel"].subscribers == 1
    assert topics["/number"].rate == 0.0
    assert [each.path for each in topics["/number"].fields] == ["data"]
    assert not any(each.startswith(("/count", "/rosout")) for each in topics)
    assert all(each.problem == "" for each in topics.values())
    services = {each.service: each for each in found.services}
    assert set(services) == {"/wander", "/fail", "/slow"}
    assert services["/wander"].type == "std_srvs/srv/SetBool"
    assert [each.type for each in services["/wander"].fields] == ["boolean"]
    (action,) = found.actions
    assert (action.action, action.type) == ("/count", "actionlib/action/Test")
    assert [each.path for each in action.fields] == ["goal"]
    nodes = {each.node: each for each in found.nodes}
    own = {each.parameter: each.type for each in nodes["/robot_peer"].parameters}
    assert own == {
        "cloud/keyframes": "integer",
        "costmap/width": "integer",
        "enabled": "boolean",
        "frame": "text",
        "gain": "number",
        "gains": "numbers",
        "rooms": "texts",
    }
    assert "/odom" in nodes["/robot_peer"].publishes
    assert nodes["/robot_peer"].left_out == (
        "cloud/key: by its name it is a secret",
        "legs: it is no number, truth or text, nor a list of one of these",
        "nobody: it is no number, truth or text, nor a list of one of these",
        "wifi_password: by its name it is a secret",
    )
    assert [each.parameter for each in nodes["/base"].parameters] == ["track"]
    assert nodes["/"].left_out == (
        "gain: it stands in no node's name space",
        "robot_description: a text of 800 characters",
    )
    assert nodes.keys() == {"/robot_peer", "/base", "/"}
    assert b"hush" not in msgspec.json.encode(found)


async def test_the_description_made_of_it_runs_as_it_is(tmp_path: Path) -> None:
    found = await seen(tmp_path)
    made = propose_description(found, "old", "Old robot", "UTC")
    site = made.site
    assert check_site(site) == []
    assert load_site(write_description(site)) == site
    old = site.connections["ros1"]
    assert (old.master, old.log, old.use_sim_time) == (found.master, "warning", True)
    ages = {each.source.topic: each.max_age for device in site.devices.values()
            for each in device.signals.values()}  # fmt: skip
    # What is latched holds until another comes.
    assert ages["/mode"] == 0
    assert ages["/odom"] > 0
    assert site.devices["sensors"].signals["speed_1"].source.name == "speed1"
    assert site.devices["camera"].streams.keys() >= {"images"}
    drive = site.devices["base"].drive
    assert drive is not None
    assert drive.topic == "/cmd_vel"
    # Whether true or false stops it, only its owner knows.
    assert (drive.stop.topic, [choice.topics for choice in made.stops]) == ("", [("/stop",)])
    commands = {each.target: each for device in site.devices.values()
                for each in device.commands.values()}  # fmt: skip
    assert commands["/count"].kind == "action"
    assert commands["/wander"].kind == "service"
    read = {each.source.parameter for device in site.devices.values()
            for each in device.signals.values()} - {""}  # fmt: skip
    assert {"/robot_peer/costmap/width", "/robot_peer/gain", "/base/track"} <= read
    assert commands["/base"].kind == "parameter"


def test_no_master_is_told_with_its_address() -> None:
    port = free_port()
    with pytest.raises(AdapterLost, match=f"no ROS master answers at http://127.0.0.1:{port}"):
        probe_graph(f"http://127.0.0.1:{port}", 0.5)


async def test_a_python_without_rospy_is_told(tmp_path: Path) -> None:
    async with robot(tmp_path) as (port, _):
        with pytest.raises(AdapterLost, match="cannot be run"):
            await asyncio.to_thread(probe_graph, f"http://127.0.0.1:{port}", 0.5, "/no/python3")


def test_a_definition_gives_fields_constants_parts_and_units() -> None:
    definition = definition_of(DEFINITION, "own_msgs/Whole")
    kind = definition.kinds["own_msgs/Whole"]
    shape = shape_of(
        kind=kind,
        type_name="own_msgs/Whole",
        find=definition.kinds.get,
        message=None,
        comment_of=definition.comment_of,
    )
    told = {each.path: each for each in shape.fields}
    assert told["mode"].words == ("Idle", "Auto")
    assert told["reach"].unit == "m"
    assert told["parts[1].hot"].unit == "°C"
    assert told["parts[0].flags[2]"].type == "boolean"
    assert not any("when" in each or "waits" in each for each in told)


@given(st.text(max_size=200))
def test_any_text_is_a_definition_or_refused_with_a_sentence(text: str) -> None:
    try:
        definition_of(text, "own_msgs/Any")
    except FieldError:
        return


@given(st.dictionaries(st.from_regex(r"[a-z]{1,8}", fullmatch=True), st.text(max_size=20)))
def test_a_connection_header_is_read_as_it_was_written(fields: dict[str, str]) -> None:
    data = header_of(fields)
    assert struct.unpack_from("<I", data)[0] == len(data) - 4
    assert fields_of(data[4:]) == fields


@given(st.binary(max_size=100))
def test_any_bytes_are_a_header_or_part_of_one(data: bytes) -> None:
    assert isinstance(fields_of(data), dict)
