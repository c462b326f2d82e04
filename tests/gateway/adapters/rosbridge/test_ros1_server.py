"""ROS 1 behind a rosbridge server: what Debian's rospy and the real server said, recorded.

Recorded with rosbridge_suite 0.11 (branch ros1) beside Debian's rosmaster, and the robot of
`ros1_peer`. To record it anew, start the three (``rosbridge_websocket``, ``rosapi_node``), then::

    export TALAIA_ROSBRIDGE_ROS1=ws://127.0.0.1:9090 TALAIA_ROS1_MASTER_PORT=11311
    pytest tests/gateway/adapters/rosbridge/test_ros1_server.py
"""

from __future__ import annotations

import asyncio
import os
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import simplejpeg
from fake_hub import fake_hub
from gateway_bench import addresses_of, command, drive, filled, running, take_lease
from patience import PATIENCE_S
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from tapped_hub import newest_list, pieces, whole

from talaia.gateway.adapters.rosbridge.probe import probe_bridge
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import FORMAT, Found
from talaia.wire.frames import (
    CommandPhase,
    StreamSubscription,
    TapError,
    TapSchema,
    TapSubscription,
)

from ..ros1.ros1_bench import robot as ros1_robot
from .rosbridge_bench import recording, replaying

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

RECORDED = Path(__file__).parent / "recorded"
REAL = os.environ.get("TALAIA_ROSBRIDGE_ROS1", "")
MASTER = int(os.environ.get("TALAIA_ROS1_MASTER_PORT", "11311"))

SITE = filled("""
talaia: 1
site: far
name: Far robot
connections:
  far: {kind: rosbridge, url: "%s", ros: 1, keep_log: none}
devices:
  base:
    name: Base
    signals:
      <number, speed>
      <pose, mode, speed1>
    streams:
      <front>
    commands:
      <wander, fail, absent, horn>
    drive: {topic: /cmd_vel, max_speed: 0.2, max_turn: 2, stop: {topic: /stop}}
""")


class NoRobot:
    """Stands where the robot stood when it was recorded."""

    async def do(self, what: str, **more: object) -> None:
        """Do nothing: what the robot did then is in the recording."""


@asynccontextmanager
async def far_robot(
    name: str, home: Path, *, raw: bool = False, both: bool = False
) -> AsyncIterator[tuple]:
    """Give the address of the server, real or recorded, the robot behind it, and the replay."""
    path = RECORDED / f"{name}.jsonl"
    if not REAL:
        async with replaying(path) as (replay, url):
            yield url, NoRobot(), replay
        return
    async with (
        ros1_robot(MASTER, home) as robot,
        recording(REAL, path, raw=raw, both=both) as url,
    ):
        yield url, robot, None


async def test_the_story_of_a_ros_1_robot_behind_a_real_server(tmp_path: Path) -> None:
    async with (
        far_robot("rosbridge-ros1", tmp_path, both=True) as (url, robot, replay),
        fake_hub(addresses_of) as hub,
    ):
        hub.takes = ["topic_list"]
        async with running(hub.url, tmp_path, SITE % url):
            await hub.until(lambda: hub.links and hub.media, "both connections")
            await hub.until(lambda: "/odom" in newest_list(hub), "the list")
            await hub.send(TapSubscription(types=["nav_msgs/msg/Odometry"]))
            await hub.until(lambda: any(isinstance(one, TapSchema) for one in hub.taps), "schema")
            await hub.send(TapSubscription(topics={"/odom": 0}))
            async with asyncio.timeout(PATIENCE_S):
                while not (
                    hub.values("base/speed")
                    and hub.values("base/mode")
                    and hub.values("base/speed1")
                    and hub.values("base/number")
                    and pieces(hub, "/odom")
                ):
                    await robot.do("mode", text="auto ✓")
                    await robot.do("metric", text="{'name': 'speed1', 'magnitude': 1.4}")
                    await robot.do("odom", speed=0.25)
                    await robot.do("count", **{"from": 4, "to": 5, "hz": 20})
                    await asyncio.sleep(0.3)
            assert set(hub.values("base/number")) == {4.0}
            assert set(hub.values("base/speed")) == {0.25}
            assert set(hub.values("base/pose.x")) == {1.5}
            assert set(hub.values("base/pose.yaw")) == {0.0}
            assert hub.values("base/mode")[0] == "auto ✓"
            assert set(hub.values("base/speed1")) == {1.4}
            (schema,) = [said for said in hub.taps if isinstance(said, TapSchema)]
            assert (schema.encoding, schema.message_encoding) == ("ros1msg", "ros1")
            store = get_typestore(Stores.EMPTY)
            store.register(get_types_from_msg(schema.definition, schema.type))
            odometry = store.deserialize_ros1(whole(hub, "/odom")[0], schema.type)
            assert odometry.twist.twist.linear.x == 0.25
            assert len(odometry.pose.covariance) == 36
            done = await command(hub, "wander", "wander", active=True)
            assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "wandering")
            failed = await command(hub, "fail", "fail")
            assert (failed.phase, failed.message) == (CommandPhase.FAILED, "the wheel is off")
            absent = await command(hub, "absent", "absent")
            assert absent.phase is CommandPhase.REFUSED
            assert (await command(hub, "horn", "horn", tune="la")).phase is CommandPhase.SUCCEEDED
            await hub.send(StreamSubscription(streams=["base/front"]))
            async with asyncio.timeout(PATIENCE_S):
                while not hub.pictures:
                    await robot.do("image", encoding="rgb8")
                    await asyncio.sleep(0.1)
            red, green, blue = simplejpeg.decode_jpeg(hub.pictures[-1].data)[24, 32]
            assert red > 200 > 60 > max(green, blue)
            await drive(hub, await take_lease(hub))
            if replay is None:
                await robot.until(lambda: any(row[0] > 0 for row in robot.heard("cmd")))
                await robot.until(lambda: robot.heard("cmd")[-1] == [0.0, 0.0])
                assert (robot.heard("wander"), robot.heard("horn")) == ([True], ["la"])
            else:
                await hub.until(lambda: any(speed(one) > 0 for one in replay.driven), "a velocity")
                await hub.until(lambda: speed(replay.driven[-1]) == 0, "a zero")
                assert replay.unexpected == []
            assert not [said for said in hub.taps if isinstance(said, TapError)]


def speed(said: dict) -> float:
    return said["msg"].get("linear", {}).get("x", 0.0)


async def test_a_ros_1_robot_is_probed_by_its_servers_rosapi_and_described(tmp_path: Path) -> None:
    async with far_robot("rosbridge-ros1-probe", tmp_path, raw=True) as (url, robot, _):
        asked = Found(FORMAT, protocol="rosbridge", where="", seconds=2.0 if REAL else 0.1, url=url)
        looking = asyncio.create_task(asyncio.to_thread(probe_bridge, asked, tmp_path))
        while not looking.done():
            await robot.do("odom", speed=0.25)
            await robot.do("mode", text="auto")
            await asyncio.wait([looking], timeout=0.1)
        found = await looking
    assert found.ros == 1
    topics = {topic.topic: topic for topic in found.topics}
    odom = topics["/odom"]
    assert (odom.type, odom.publishers, odom.subscribers) == ("nav_msgs/msg/Odometry", 1, 0)
    assert odom.rate > 0
    assert {field.path: field.unit for field in odom.fields}["twist.twist.linear.x"] == "m/s"
    # Pictures are not listened to, and what carries ROS or the server itself is not the robot's.
    assert (topics["/images"].rate, topics["/images"].publishers) == (0.0, 1)
    assert not topics.keys() & {"/rosout", "/connected_clients", "/count/status", "/count/goal"}
    assert (topics["/cmd_vel"].publishers, topics["/cmd_vel"].subscribers) == (0, 1)
    assert "rosapi tells no definition of it" in topics["/odd"].problem
    services = {one.service: one for one in found.services}
    assert set(services) == {"/fail", "/slow", "/wander"}
    assert services["/wander"].type == "std_srvs/srv/SetBool"
    assert [(field.path, field.type) for field in services["/wander"].fields] == [
        ("data", "boolean")
    ]
    site = propose_description(found, "far", "Far robot", "UTC").site
    assert not check_site(site)
    connection = site.connections["rosbridge"]
    assert (connection.url, connection.ros) == (url, 1)
    assert site.devices["base"].drive.topic == "/cmd_vel"
    assert site.devices["base"].signals["speed"].source.topic == "/odom"
    assert "/diagnostics" in {rule.pattern for rule in site.topics}
