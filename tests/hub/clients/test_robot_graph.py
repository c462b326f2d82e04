"""The robot's nodes for npm's Foxglove client and PyPI's roslibpy: while wanted, by rights."""

from __future__ import annotations

import asyncio

import pytest

from talaia.wire import frames

from .foxglove.foxglove_peer import NodeClient, client_of
from .robot_commands import SITE
from .rosbridge.rosbridge_peer import RawClient, RoslibpyClient, address_of
from .tokens import open_protocol, token_of

TOPICS = """
topics:
  - {pattern: /scan, right: view, device: base}
  - {pattern: /secret, right: admin}
"""
LISTED = [
    frames.TopicEntry(number=1, topic="/scan", type="sensor_msgs/msg/LaserScan"),
    frames.TopicEntry(number=2, topic="/secret", type="std_msgs/msg/String"),
]
GRAPH = frames.RobotGraph(
    nodes=[
        frames.RobotNode(name="/lidar", publishes=["/scan", "/secret"]),
        frames.RobotNode(
            name="/planner", subscribes=["/scan", "/secret"], serves=["/add_two_ints"]
        ),
        frames.RobotNode(name="/safe", publishes=["/secret"], serves=["/cut", "/hidden"]),
    ],
    distro="jazzy",
)


async def begin_robot(world):
    """Put a robot with nodes in the place of the world's."""
    await world.gateways["agv"].close()
    gateway = await world.connect("agv", SITE + TOPICS)
    world.hub.hub.core.taps.receive("agv", frames.TopicList(topics=LISTED))
    return gateway


async def tell_graph(world, gateway, graph=GRAPH) -> None:
    """Say what the robot has, as soon as somebody wants it."""
    await gateway.hear(frames.TapSubscription, lambda asked: asked.graph)
    world.hub.hub.core.taps.receive("agv", graph)


async def rosapi_client(world, name):
    await open_protocol(world.hub, "rosbridge")
    return await RawClient().connect(address_of(world.hub, "agv", await token_of(world.hub, name)))


async def answers(client) -> dict:
    asked = {
        "/rosapi/publishers": {"topic": "/scan"},
        "/rosapi/subscribers": {"topic": "/scan"},
        "/rosapi/service_node": {"service": "/add_two_ints"},
        "/rosapi/node_details": {"node": "/planner"},
        "/rosapi/get_ros_version": {},
    }
    return {
        service.removeprefix("/rosapi/"): (await client.call(service, args))["values"]
        for service, args in asked.items()
    }


@pytest.mark.parametrize(
    ("name", "seen"),
    [("driver", {"/lidar", "/planner"}), ("admin", {"/lidar", "/planner", "/safe"})],
)
async def test_roslibpy_is_told_the_nodes_of_what_its_person_may_see(world, name, seen) -> None:
    gateway = await begin_robot(world)
    await open_protocol(world.hub, "rosbridge")
    token = await token_of(world.hub, name)
    async with await RoslibpyClient().connect(world.hub, "agv", token) as client:
        # Nobody has asked, and nobody at the robot is asked.
        assert not any(
            isinstance(said, frames.TapSubscription) and said.graph for said in gateway.heard
        )
        await client.say("get_nodes")
        await tell_graph(world, gateway)
        found = set(await client.hear("found"))
        assert {node for node in found if not node.startswith("/talaia")} == seen


async def test_rosapi_names_the_robots_nodes_as_far_as_one_may_see_them(world) -> None:
    gateway = await begin_robot(world)
    driver = await rosapi_client(world, "driver")
    asking = asyncio.create_task(answers(driver))
    await tell_graph(world, gateway)
    found = await asking
    assert found["publishers"] == {"publishers": ["/lidar"]}
    assert found["subscribers"] == {"subscribers": ["/planner"]}
    assert found["service_node"] == {"node": "/planner"}
    assert found["node_details"] == {
        "subscribing": ["/scan"],
        "publishing": [],
        "services": ["/add_two_ints"],
    }
    assert found["get_ros_version"] == {"version": 2, "distro": "jazzy"}
    # What is kept from it is as if it were not there.
    safe = (await driver.call("/rosapi/node_details", {"node": "/safe"}))["values"]
    assert safe == {"subscribing": [], "publishing": [], "services": []}
    await driver.close()
    guest = await rosapi_client(world, "guest")
    nodes = (await guest.call("/rosapi/nodes"))["values"]["nodes"]
    # The base is public, and with it what it publishes by the rule of the description.
    assert {"/safe"} & set(nodes) == set()
    text = repr(await answers(guest))
    assert "/secret" not in text
    assert "/add_two_ints" not in text
    await guest.close()


async def test_npm_client_sees_nodes_come_and_go_and_the_robot_rests_after_it(world) -> None:
    gateway = await begin_robot(world)
    taps = world.hub.hub.core.taps
    async with await client_of(world, "driver", kind=NodeClient) as client:
        wanted = await gateway.hear(frames.TapSubscription, lambda asked: asked.types)
        assert not wanted.graph
        for kind in ("sensor_msgs/msg/LaserScan",):
            schema = {"encoding": "ros2msg", "definition": "float32 x", "message_encoding": "cdr"}
            taps.receive("agv", frames.TapSchema(type=kind, **schema))
        await client.hear("advertise", lambda said: any(one["topic"] == "/scan" for one in said))
        await client.call("subscribeConnectionGraph")
        first = await client.hear("connectionGraphUpdate")
        # Which node it is the robot has not said yet.
        assert publishers_of(first)["/scan"] == ["robot"]
        await tell_graph(world, gateway)
        graph = await client.hear("connectionGraphUpdate")
        assert publishers_of(graph)["/scan"] == ["/lidar"]
        subscribed = {one["name"]: one["subscriberIds"] for one in graph["subscribedTopics"]}
        assert subscribed["/scan"] == ["/planner"]
        served = {one["name"]: one["providerIds"] for one in graph["advertisedServices"]}
        assert served["/add_two_ints"] == ["/planner"]
        assert "/secret" not in repr(graph)
        # The planner has left; its service is named by the device that the command is of.
        taps.receive("agv", frames.RobotGraph(nodes=GRAPH.nodes[:1]))
        graph = await client.hear("connectionGraphUpdate")
        assert "/scan" not in {one["name"] for one in graph["subscribedTopics"]}
        served = {one["name"]: one["providerIds"] for one in graph["advertisedServices"]}
        assert served["/add_two_ints"] == ["base"]
        await client.call("unsubscribeConnectionGraph")
        await gateway.hear(frames.TapSubscription, lambda asked: not asked.graph)


def publishers_of(graph) -> dict[str, list[str]]:
    return {one["name"]: one["publisherIds"] for one in graph["publishedTopics"]}
