"""Raw topics of a robot behind a rosbridge server, through a gateway to a hub.

The story ran against RobotWebTools' rosbridge_suite (ros2, October 2024); see `test_adapter` for
how it is recorded anew. What `rosbags` reads by the schema that came along is the judge.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from fake_hub import FakeHub, fake_hub
from gateway_bench import addresses_of, running
from patience import PATIENCE_S
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from tapped_hub import newest_list, pieces, whole
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed

from talaia.wire.frames import RobotGraph, TapError, TapSchema, TapSubscription

from .rosbridge_bench import recording, replaying

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from gateway_bench import Peer
    from websockets.asyncio.server import ServerConnection

RECORDED = Path(__file__).parent / "recorded" / "rosbridge-taps.jsonl"
REAL = os.environ.get("TALAIA_ROSBRIDGE", "")
SITE = """
talaia: 1
site: far
name: Far robot
connections:
  far: {kind: rosbridge, url: "%s", keep_log: none}
devices:
  base: {name: Base}
"""
ODOMETRY, IMAGE = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Image"


@asynccontextmanager
async def real_or_recorded() -> AsyncIterator[str]:
    if REAL:
        async with recording(REAL, RECORDED, raw=True) as url:
            yield url
    else:
        async with replaying(RECORDED) as (_, url):
            yield url


@asynccontextmanager
async def bench(url: str, data: Path) -> AsyncIterator[FakeHub]:
    async with fake_hub(addresses_of) as hub:
        hub.takes = ["topic_list"]
        async with running(hub.url, data, SITE % url):
            await hub.until(lambda: hub.links and hub.media, "both connections")
            yield hub


def read_all(hub: FakeHub, topic: str) -> list:
    """Read a topic's messages by nothing but the schema that came along."""
    type_name = newest_list(hub)[topic][1]
    (schema,) = [
        said for said in hub.taps if isinstance(said, TapSchema) and said.type == type_name
    ]
    assert (schema.encoding, schema.message_encoding) == ("ros2msg", "cdr")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.definition, type_name))
    return [store.deserialize_cdr(data, type_name) for data in whole(hub, topic)]


@pytest.fixture
def robot(request: pytest.FixtureRequest) -> Peer | None:
    """The robot behind the real server; where it was recorded, what it did is in the recording."""
    return request.getfixturevalue("peer") if REAL else None


async def test_the_raw_topics_of_a_robot_behind_a_real_server(
    tmp_path: Path, robot: Peer | None
) -> None:
    async with real_or_recorded() as url, bench(url, tmp_path) as hub:
        await hub.until(lambda: "/images" in newest_list(hub), "the list")
        listed = newest_list(hub)
        assert (listed["/odom"][1], listed["/images"][1]) == (ODOMETRY, IMAGE)
        await hub.send(TapSubscription(types=[ODOMETRY, IMAGE, "std_msgs/msg/String"]))
        await hub.until(
            lambda: len([said for said in hub.taps if isinstance(said, TapSchema)]) == 3, "schemas"
        )
        await hub.send(TapSubscription(topics={"/odom": 0, "/images": 0, "/mode": 0}))
        async with asyncio.timeout(PATIENCE_S):
            while not all(pieces(hub, topic) for topic in ("/odom", "/images", "/mode")):
                if robot is not None:
                    await robot.do("mode", text="auto ✓")
                    await robot.do("odom", speed=0.25)
                    await robot.do("image", encoding="rgb8")
                await asyncio.sleep(0.1)
        odometry, image = read_all(hub, "/odom")[0], read_all(hub, "/images")[0]
        # Its covariance is a list of fixed length, which such a server writes only as JSON.
        assert odometry.twist.twist.linear.x == 0.25
        assert odometry.pose.pose.position.x == 1.5
        assert len(odometry.pose.covariance) == 36
        assert (image.encoding, image.width * image.height * 3) == ("rgb8", len(image.data))
        assert read_all(hub, "/mode")[0].data == "auto ✓"
        assert not [said for said in hub.taps if isinstance(said, TapError)]


class SmallServer:
    """A server with one topic, by the letter of the protocol."""

    def __init__(self) -> None:  # noqa: D107
        self.heard: list[dict] = []
        self.topics = {"/words": "std_msgs/msg/String"}
        self.rosapi = True
        self.takers: set[ServerConnection] = set()

    async def handle(self, client: ServerConnection) -> None:
        with suppress(ConnectionClosed):
            await self.read(client)

    async def read(self, client: ServerConnection) -> None:
        async for data in client:
            said = json.loads(data)
            self.heard.append(said)
            match said["op"]:
                case "call_service":
                    await client.send(json.dumps(self.answer(said)))
                case "subscribe":
                    self.takers.add(client)
                case "unsubscribe":
                    self.takers.discard(client)

    def answer(self, said: dict) -> dict:
        names, types = list(self.topics), list(self.topics.values())
        values: object = {
            "/rosapi/topics": {"topics": names, "types": types},
            "/rosapi/topics_and_raw_types": {
                "topics": names,
                "types": types,
                "typedefs_full_text": ["string data"] * len(names),
            },
            "/rosapi/nodes": {"nodes": ["/talker"]},
            "/rosapi/node_details": {"publishing": names, "subscribing": [], "services": ["/s"]},
        }[said["service"]]
        good = self.rosapi
        if not good:
            values = f"Service {said['service']} does not exist"
        return {"op": "service_response", "id": said["id"], "values": values, "result": good}

    async def publish(self, topic: str, message: object) -> None:
        for taker in self.takers:
            await taker.send(json.dumps({"op": "publish", "topic": topic, "msg": message}))

    def ops(self, op: str) -> list[dict]:
        return [said for said in self.heard if said["op"] == op]


@asynccontextmanager
async def small_server() -> AsyncIterator[tuple[SmallServer, str]]:
    one = SmallServer()
    async with serve(one.handle, "127.0.0.1", 0, compression=None) as server:
        yield one, f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}"


async def test_a_topic_is_subscribed_only_while_it_is_wanted_and_what_does_not_fit_is_told(
    tmp_path: Path,
) -> None:
    async with small_server() as (server, url), bench(url, tmp_path) as hub:
        await hub.until(lambda: "/words" in newest_list(hub), "the list")
        assert not server.ops("subscribe")
        await hub.send(TapSubscription(topics={"/words": 0}, types=["std_msgs/msg/String"]))
        await hub.until(lambda: server.ops("subscribe"), "the subscription")
        (asked, *_) = server.ops("subscribe")
        assert (asked["topic"], asked["compression"]) == ("/words", "cbor")
        await server.publish("/words", {"data": 3})
        await hub.until(lambda: any(isinstance(said, TapError) for said in hub.taps), "why")
        (why,) = [said.why for said in hub.taps if isinstance(said, TapError)]
        assert "'data': expected a text" in why
        await server.publish("/words", {"data": "ok"})
        await hub.until(lambda: whole(hub, "/words"), "a message")
        assert [one.data for one in read_all(hub, "/words")] == ["ok"]
        await hub.send(TapSubscription())
        await hub.until(lambda: server.ops("unsubscribe"), "the end of it")
        assert not server.takers


async def test_nodes_are_asked_of_the_server_while_they_are_wanted(tmp_path: Path) -> None:
    async with small_server() as (server, url), bench(url, tmp_path) as hub:
        await hub.until(lambda: "/words" in newest_list(hub), "the list")
        assert not [said for said in server.ops("call_service") if "nodes" in said["service"]]
        await hub.send(TapSubscription(graph=True))
        await hub.until(lambda: isinstance(hub.taps[-1], RobotGraph), "the graph")
        (node,) = hub.taps[-1].nodes
        assert (node.name, node.publishes, node.serves) == ("/talker", ["/words"], ["/s"])


async def test_a_server_without_rosapi_lists_nothing_and_says_what_to_do(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    async with small_server() as (server, url):
        server.rosapi = False
        async with bench(url, tmp_path) as hub:
            await hub.until(lambda: "Start rosapi beside the server" in caplog.text, "the warning")
            assert "Service /rosapi/topics does not exist" in caplog.text
            assert newest_list(hub) == {}
            server.rosapi = True
            await hub.until(lambda: "/words" in newest_list(hub), "the list, once it is there")
