"""A ROS 1 robot's log in the logbook, and its clock, by Debian's rosmaster and rospy."""

from __future__ import annotations

import asyncio
import struct
from typing import TYPE_CHECKING

import pytest
from fake_hub import FakeHub, fake_hub
from gateway_bench import addresses_of, running
from patience import PATIENCE_S
from ports import free_port

from talaia.gateway.adapters.ros1.robot_messages import read_log_head
from talaia.wire.frames import Event

from . import ros1_bench

if TYPE_CHECKING:
    from pathlib import Path

SITE = """
talaia: 1
site: old
name: ROS 1 robot
connections:
  old: {kind: ros1, master: "http://127.0.0.1:%d", log: warning, use_sim_time: true}
devices:
  base:
    name: Base
    signals:
      speed:
        name: Speed
        unit: m/s
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}
"""


def lines_of(hub: FakeHub) -> list[str]:
    return [
        said.message
        for said in hub.messages
        if isinstance(said, Event) and said.kind == "robot_log"
    ]


def distance_s(hub: FakeHub) -> float:
    """By how much the time of the newest 1.0 lies behind that of the newest 2.0."""
    times = {
        value: time_us for samples in hub.samples.values() for _, time_us, value in samples.values()
    }
    return (times.get(1.0, 0) - times.get(2.0, 0)) / 1e6


@pytest.mark.robot
async def test_the_robots_log_stands_in_the_logbook_and_stamps_go_by_its_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ros1_bench.need_ros1()
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    port = free_port()
    with ros1_bench.master(port, tmp_path):
        async with (
            ros1_bench.robot(port, tmp_path) as peer,
            fake_hub(addresses_of) as hub,
            running(hub.url, tmp_path / "data", SITE % port),
        ):
            hub.takes = ["robot_log"]
            await hub.until(lambda: hub.hellos, "a hello")
            async with asyncio.timeout(PATIENCE_S):
                # Until the robot has found who listens.
                while not any("dry" in line for line in lines_of(hub)):
                    await peer.do("log", level="info", text="nobody reads this", count=1)
                    await peer.do("log", level="error", text="the pump is dry", count=1)
                    await asyncio.sleep(0.2)
            # Kept besides, each of them.
            await hub.until(lambda: hub.log_lines(), "a kept line")
            assert {
                (line.level, line.node, line.text, line.function != "") for line in hub.log_lines()
            } == {(40, "robot_peer", "the pump is dry", True)}
            await peer.do("log", level="error", text="line {}", count=3000)
            # There is room for others beside it.
            await peer.do("log", node="/front/lidar", text="no echo", count=1)
            await hub.until(lambda: "[ERROR] front.lidar: no echo" in lines_of(hub), "its line")
            said = [line for line in lines_of(hub) if "lidar" not in line]
            # Five of a node at once: the pump's, however often, and of the flood at most the rest.
            assert said[0] == "[ERROR] robot_peer: the pump is dry"
            assert all("robot_peer: line" in line for line in said[1:])
            assert len(said) <= 6
            async with asyncio.timeout(PATIENCE_S):
                # Before the clock is heard, arrivals count: both come at once.
                while not 1.5 < distance_s(hub) < 2.5:
                    await peer.do("clock", sec=1000)
                    await peer.do("odom", speed=1.0, sec=1000)
                    await peer.do("odom", speed=2.0, sec=998)
                    await asyncio.sleep(0.05)


@pytest.mark.parametrize(("level", "read"), [(1, 10), (2, 20), (4, 30), (8, 40), (16, 50), (3, 20)])
def test_the_head_of_a_line_is_read_as_ros_1_serializes_it(level: int, read: int) -> None:
    """By https://wiki.ros.org/msg and rosgraph_msgs/Log."""
    raw = struct.pack("<III", 7, 1000, 5) + struct.pack("<I3s", 3, b"map") + bytes([level])
    raw += struct.pack("<I", len("/é/lidar".encode())) + "/é/lidar".encode()
    assert read_log_head(raw) == (read, "é.lidar")
    assert [read_log_head(raw[:end]) for end in (0, 14, 20, 25, len(raw) - 1)] == [None] * 5
