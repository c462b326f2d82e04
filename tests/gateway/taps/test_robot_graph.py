"""The nodes of a real ROS 2 robot, told while the hub wants to know them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway.conftest import peer_in
from gateway_bench import addresses_of, running

from talaia.gateway.tap_ports import GraphNode
from talaia.gateway.taps.site_graph import SiteGraph
from talaia.wire.frames import (
    MAX_GRAPH_NODES,
    MEDIA_FROM_GATEWAY,
    RobotGraph,
    TapSubscription,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from fake_hub import FakeHub
    from gateway_bench import Peer

SITE = """
talaia: 1
site: test
name: Test robot
ros2: {node: gateway_under_test}
devices:
  base: {name: Base}
"""


@pytest.fixture
async def robot(ros_domain: int) -> AsyncIterator[Peer]:
    async with peer_in(ros_domain, Path(__file__).with_name("topics_peer.py")) as one:
        yield one


def graphs(hub: FakeHub) -> list[RobotGraph]:
    return [said for said in hub.taps if isinstance(said, RobotGraph)]


def published(hub: FakeHub, node: str) -> set[str]:
    found = graphs(hub)
    return {
        name
        for one in (found[-1].nodes if found else ())
        if one.name == node
        for name in one.publishes
    }


async def test_nodes_are_told_while_they_are_wanted_and_as_they_change(
    robot: Peer, tmp_path: Path
) -> None:
    await robot.do("open", topic="/words")
    async with fake_hub(addresses_of) as hub:
        hub.takes = ["topic_list"]
        async with running(hub.url, tmp_path, SITE):
            await hub.until(lambda: hub.links and hub.media and hub.taps, "both connections")
            await hub.send(TapSubscription(graph=True))
            await hub.until(lambda: "/words" in published(hub, "/topics_peer"), "the node")
            await robot.do("open", topic="/more")
            await hub.until(lambda: "/more" in published(hub, "/topics_peer"), "its second topic")
            names = {node.name for node in graphs(hub)[-1].nodes}
            assert {"/topics_peer", "/gateway_under_test"} <= names
            # Parameters are services of each node; what is hidden by convention is left out.
            assert any(node.serves for node in graphs(hub)[-1].nodes)
            assert not any("/_" in name for node in graphs(hub)[-1].nodes for name in node.serves)
            await hub.send(TapSubscription())
            await robot.do("open", topic="/unasked")
            await hub.until(lambda: any("/unasked" in repr(said) for said in hub.taps), "the list")
            assert not any("/unasked" in repr(graph) for graph in graphs(hub))
            await hub.send(TapSubscription(graph=True))
            await hub.until(lambda: "/unasked" in published(hub, "/topics_peer"), "the node again")


def test_nodes_of_two_connections_are_one_graph_and_too_many_are_counted() -> None:
    graph = SiteGraph()
    assert not graph.known
    assert graph.replace_nodes("a", [GraphNode("/one", ("/x",), ("/y",), ("/s",))], "jazzy")
    assert not graph.replace_nodes("a", [GraphNode("/one", ("/x",), ("/y",), ("/s",))], "jazzy")
    assert graph.replace_nodes("b", [GraphNode("/one", ("/z",)), GraphNode("/two")], "")
    told = graph.message()
    assert [(node.name, node.publishes) for node in told.nodes] == [
        ("/one", ["/x", "/z"]),
        ("/two", []),
    ]
    assert (told.distro, told.left_out) == ("jazzy", 0)
    many = [GraphNode(f"/n{number:04}", ("/t" * 120,)) for number in range(MAX_GRAPH_NODES + 9)]
    graph.replace_nodes("a", many, "")
    told = graph.message()
    assert (len(told.nodes), told.left_out) == (MAX_GRAPH_NODES, 11)
    # A name that the wire does not carry is left out, and what is told is read there.
    assert MEDIA_FROM_GATEWAY.decode(MEDIA_FROM_GATEWAY.encode(told)) == told
    assert not any(node.publishes for node in told.nodes)
