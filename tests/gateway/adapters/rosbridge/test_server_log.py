"""The log of a robot behind a rosbridge server is kept at the hub, each line once."""

from __future__ import annotations

import json
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running
from websockets.asyncio.server import serve

from talaia.wire.frames import Event

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from fake_hub import FakeHub
    from websockets.asyncio.server import ServerConnection

SITE = """
talaia: 1
site: far
name: Far robot
connections:
  far: {kind: rosbridge, url: "%s", ros: %d%s}
devices:
  base:
    name: Base
    signals:
      number: {name: N, source: {topic: /number, type: std_msgs/msg/Float64, field: data}}
"""
TYPES = {1: "rosgraph_msgs/Log", 2: "rcl_interfaces/msg/Log"}


class LogServer:
    """A rosbridge server of either ROS: who subscribes to the log hears its lines."""

    def __init__(self, ros: int) -> None:  # noqa: D107
        self.ros = ros
        # Topics, and the types of the log, in the order in which they were asked for.
        self.subscribed: list[str] = []
        self.asked: list[str] = []
        # Said to each who subscribes, as a node of ROS 2 says again what it said last.
        self.latched: list[str] = []
        self.clients: list[ServerConnection] = []

    async def handle(self, client: ServerConnection) -> None:
        async for data in client:
            said = json.loads(data)
            if said["op"] == "subscribe":
                self.subscribed.append(said["topic"])
            if said["op"] == "subscribe" and said["topic"] == "/rosout":
                self.asked.append(said["type"])
                self.clients.append(client)
                for line in self.latched:
                    await client.send(line)

    def line(self, level: int, name: str, text: str, at: float | None = None) -> str:
        """Write a line as the server does; ``at`` is when it was said (s)."""
        said = time.time() if at is None else at
        seconds, rest = int(said), int(said % 1 * 1e9)
        more = {"function": "spin", "file": "/opt/ros/lib/base.cpp", "line": 88}
        msg = {"level": level, "name": name, "msg": text, **more}
        if self.ros == 1:
            stamp = {"secs": seconds, "nsecs": rest}
            msg |= {"header": {"seq": 1, "stamp": stamp, "frame_id": ""}, "topics": []}
        else:
            msg["stamp"] = {"sec": seconds, "nanosec": rest}
        return json.dumps({"op": "publish", "topic": "/rosout", "msg": msg})

    async def tell(self, *lines: str) -> None:
        for line in lines:
            await self.clients[-1].send(line)


@asynccontextmanager
async def linked(ros: int, tmp_path: Path, more: str = "") -> AsyncIterator[tuple]:
    """Run a gateway between such a server and a hub that keeps lines."""
    far = LogServer(ros)
    async with serve(far.handle, "127.0.0.1", 0) as one, fake_hub(addresses_of) as hub:
        hub.takes = ["robot_log"]
        url = f"ws://127.0.0.1:{one.sockets[0].getsockname()[1]}"
        async with running(hub.url, tmp_path, SITE % (url, ros, more)):
            await hub.until(lambda: hub.hellos, "a hello")
            yield far, hub


def kept(hub: FakeHub) -> list[tuple[int, str, str]]:
    return [(line.level, line.node, line.text) for batch in hub.log for line in batch.lines]


@pytest.mark.parametrize(
    ("ros", "warning", "info", "node"), [(2, 30, 20, "arm.wrist"), (1, 4, 2, "/arm/wrist")]
)
async def test_warnings_of_a_robot_behind_a_server_are_kept_as_its_own_ros_says_them(
    ros: int, warning: int, info: int, node: str, tmp_path: Path
) -> None:
    async with linked(ros, tmp_path) as (far, hub):
        await hub.until(lambda: far.asked, "the log")
        assert far.asked == [TYPES[ros]]
        await far.tell(far.line(info, node, "all is well"), far.line(warning, node, "hot: 71 °C"))
        await hub.until(lambda: kept(hub), "a line")
        assert kept(hub) == [(30, "arm.wrist", "hot: 71 °C")]
        line = hub.log[0].lines[0]
        assert (line.function, line.file, line.line) == ("spin", "/opt/ros/lib/base.cpp", 88)


async def test_what_nodes_say_again_to_a_new_subscription_is_kept_once(tmp_path: Path) -> None:
    async with linked(2, tmp_path) as (far, hub):
        await hub.until(lambda: far.asked, "the log")
        now = time.time()
        said = far.line(40, "base", "motor off", now)
        await far.tell(said)
        await hub.until(lambda: kept(hub), "a line")
        # Said before anybody of us was there, too.
        far.latched = [far.line(40, "base", "of last week", now - 7 * 86_400), said]
        await far.clients[-1].close()
        await hub.until(lambda: len(far.asked) == 2, "the next connection")
        await far.tell(far.line(40, "base", "motor off again"))
        await hub.until(lambda: len(kept(hub)) > 1, "the new line")
        assert [text for _, _, text in kept(hub)] == ["motor off", "motor off again"]


async def test_what_is_no_line_is_reported_once_and_stops_nothing(tmp_path: Path) -> None:
    async with linked(2, tmp_path) as (far, hub):
        await hub.until(lambda: far.asked, "the log")
        for msg in ({"level": 40}, "no", {"level": "loud", "name": "x"}):
            await far.tell(json.dumps({"op": "publish", "topic": "/rosout", "msg": msg}))
        await far.tell(far.line(50, "base", "still heard"))
        await hub.until(lambda: kept(hub), "a line")
        event = await hub.next(Event, lambda one: "/rosout" in one.message)
        assert "rcl_interfaces/msg/Log" in event.message


async def test_a_description_that_keeps_nothing_asks_for_no_log(tmp_path: Path) -> None:
    async with linked(2, tmp_path, ", keep_log: none") as (far, hub):
        # Silent topics are asked for anew: all that is asked for was asked for by then.
        await hub.until(lambda: far.subscribed.count("/number") > 1, "the signal's topic")
        assert far.asked == []
