"""A robot's nodes are asked of its gateway while somebody looks, under everyone's rights."""

from __future__ import annotations

import asyncio
import os

import pytest
from playwright.async_api import expect

from talaia.wire import frames

from ..chromium import sign_in
from ..conftest import DESCRIPTION

TOPICS = """
topics:
  - {pattern: /scan, right: view}
  - {pattern: /secret, right: admin}
"""
GRAPH = frames.RobotGraph(
    nodes=[
        frames.RobotNode(name="/planner", subscribes=["/scan", "/secret"]),
        frames.RobotNode(name="/lidar", publishes=["/scan"]),
        frames.RobotNode(name="/safe", publishes=["/secret"]),
    ]
)
AT = "/api/sites/agv/graph"


async def test_people_see_nodes_with_the_topics_that_they_may_have(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + TOPICS)
    media = await hub.camera()
    entries = [
        frames.TopicEntry(number=number, topic=topic, type="std_msgs/msg/String")
        for number, topic in enumerate(("/scan", "/secret"), 1)
    ]
    await media.say(frames.TopicList(topics=entries))
    operator, admin = await hub.client("operator"), await hub.client("admin")
    async with asyncio.timeout(20):
        while not (await operator.get("/api/sites/agv/topics")).json()["topics"]:
            pass
    asked = asyncio.create_task(operator.get(AT))
    # Only now is the robot asked for it.
    await gateway.hear(frames.TapSubscription, lambda said: said.graph)
    await media.say(GRAPH)
    assert (await asked).json() == {
        "online": True,
        "nodes": [
            {"name": "/lidar", "publishes": ["/scan"], "subscribes": []},
            {"name": "/planner", "publishes": [], "subscribes": ["/scan"]},
        ],
    }
    names = [node["name"] for node in (await admin.get(AT)).json()["nodes"]]
    assert names == ["/lidar", "/planner", "/safe"]


async def test_while_no_gateway_is_there_no_node_is_shown_as_there(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + TOPICS)
    await gateway.close()
    operator = await hub.client("operator")
    async with asyncio.timeout(20):
        while (answer := (await operator.get(AT)).json())["online"]:
            pass
    assert answer == {"online": False, "nodes": []}


NAV = frames.RobotGraph(
    nodes=[
        frames.RobotNode(name="/lidar", publishes=["/scan", "/rosout"]),
        frames.RobotNode(name="/slam_toolbox", publishes=["/map"], subscribes=["/scan", "/odom"]),
        frames.RobotNode(name="/planner_server", publishes=["/plan"], subscribes=["/map"]),
        frames.RobotNode(
            name="/controller_server", publishes=["/cmd_vel"], subscribes=["/plan", "/scan"]
        ),
        frames.RobotNode(name="/base", publishes=["/odom"], subscribes=["/cmd_vel"]),
    ]
)
PICTURES = os.environ.get("TALAIA_PICTURES", "")


@pytest.mark.browser
@pytest.mark.timeout(600)
async def test_graph_is_drawn_searched_and_walked_by_keys(chromium, hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + '\ntopics:\n  - {pattern: "/**", right: view}\n')
    media = await hub.camera()
    names = sorted({name for node in NAV.nodes for name in (*node.publishes, *node.subscribes)})
    entries = [
        frames.TopicEntry(number=number, topic=topic, type="std_msgs/msg/String")
        for number, topic in enumerate(names, 1)
    ]
    await media.say(frames.TopicList(topics=entries))
    operator = await hub.client("operator")
    tile = {
        "id": "t1",
        "type": "graph",
        "title": "",
        "settings": {},
        "desktop": None,
        "phone": None,
    }
    board = {"name": "Graph", "note": "", "site": "agv", "kind": "", "device": "", "tiles": [tile]}
    key = (await operator.post("/api/boards", json={"board": board})).json()["key"]
    page = await sign_in(chromium, hub, "operator", to=f"/boards/{key}")
    await gateway.hear(frames.TapSubscription, lambda said: said.graph)
    await media.say(NAV)
    graph = page.locator("t-node-graph")
    slam = graph.get_by_role("button", name="Node /slam_toolbox", exact=False)
    await expect(slam).to_have_attribute(
        "aria-label", "Node /slam_toolbox. Publishes /map. Hears /scan, /odom."
    )
    await expect(graph).to_contain_text("5 nodes")
    for width in (1440, 390) if PICTURES else ():
        await page.set_viewport_size({"width": width, "height": 900})
        for theme in ("light", "dark"):
            await page.evaluate("t => (document.documentElement.dataset.theme = t)", theme)
            await page.screenshot(path=f"{PICTURES}/graph-{width}-{theme}.png", full_page=True)
    # By keys: around one of them, then found by words, then all again.
    await slam.focus()
    await page.keyboard.press("Enter")
    await expect(graph).to_contain_text("Around /slam_toolbox")
    await expect(graph.get_by_role("button", name="Topic /cmd_vel", exact=False)).to_have_count(0)
    await graph.get_by_label("Search nodes and topics").fill("contr")
    await graph.get_by_role("button", name="/controller_server node", exact=True).click()
    await expect(graph).to_contain_text("Around /controller_server")
    await graph.get_by_role("button", name="Show all", exact=True).click()
    await expect(graph).to_contain_text("5 nodes")
    assert page.errors == []
