"""Who of the robot has what, for those at the hub who want it: wanted once, by rights."""

from __future__ import annotations

import asyncio

from talaia.clock import HandClock
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.live.site_state import LinkedGateway
from talaia.hub.live.sites import Sites
from talaia.hub.live.taps.graph_watch import GraphWatch
from talaia.hub.live.taps.tap_fanout import TapFanout
from talaia.hub.live.taps.tapped import GraphChanged
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import RobotGraph, RobotNode, TapSubscription, TopicEntry, TopicList

DESCRIPTION = """
talaia: 1
site: farm
name: Farm
ros2: {}
devices:
  barn: {name: Barn}
topics:
  - {pattern: /scan, right: view, device: barn}
"""
GUEST = Grants()
VIEWER = Grants(frozenset({Permission(Right.VIEW)}))
GRAPH = RobotGraph(
    nodes=[
        RobotNode(name="/lidar", publishes=["/scan"], serves=["/lidar/reset"]),
        RobotNode(name="/planner", subscribes=["/scan", "/secret"]),
        RobotNode(name="/vault", publishes=["/secret"]),
    ]
)


class Gateway:
    """What a gateway would be asked."""

    def __init__(self) -> None:  # noqa: D107
        self.asked: list[TapSubscription] = []

    def send(self, message) -> None:
        self.asked.append(message)

    def dismiss(self, reason: str) -> None: ...


def connected_farm() -> tuple[TapFanout, Gateway, Sites]:
    sites, gateway = Sites(), Gateway()
    sites.describe_site(load_site(DESCRIPTION), "c1")
    fanout = TapFanout(sites, HandClock())
    sites.find_site("farm").attach_link(gateway, LinkedGateway(), 0)
    fanout.link_up("farm")
    fanout.receive("farm", TopicList(topics=[TopicEntry(number=1, topic="/scan", type="a/msg/B")]))
    return fanout, gateway, sites


async def turn() -> None:
    await asyncio.sleep(0)
    await asyncio.sleep(0)


async def test_a_gateway_is_asked_once_for_all_and_rests_after_the_last() -> None:
    fanout, gateway, _ = connected_farm()
    first, second = fanout.taker(VIEWER), fanout.taker(GUEST)
    await turn()
    assert gateway.asked == []
    for taker in (first, second):
        fanout.graphs.follow_graph("farm", taker)
    await turn()
    assert gateway.asked == [TapSubscription(graph=True)]
    fanout.receive("farm", GRAPH)
    assert first.pop_event() == second.pop_event() == GraphChanged("farm")
    seen = fanout.graphs.visible_graph("farm", VIEWER, ())
    assert seen.nodes == [
        RobotNode(name="/lidar", publishes=["/scan"]),
        RobotNode(name="/planner", subscribes=["/scan"]),
    ]
    assert fanout.graphs.visible_graph("farm", GUEST, ()).nodes == []
    assert fanout.graphs.visible_graph("farm", GUEST, {"/lidar/reset"}).nodes == [
        RobotNode(name="/lidar", serves=["/lidar/reset"])
    ]
    fanout.remove_taker(first)
    await turn()
    assert len(gateway.asked) == 1
    fanout.remove_taker(second)
    await turn()
    assert gateway.asked[1:] == [TapSubscription()]
    # What was on its way then is not taken for what is so now.
    fanout.receive("farm", GRAPH)
    assert fanout.graphs.visible_graph("farm", None, ()).nodes == []


async def test_a_question_waits_for_the_first_answer_and_no_more_for_one_who_gives_none() -> None:
    _, _, sites = connected_farm()
    asked: list[str] = []
    watch = GraphWatch(
        sites, ask_soon=asked.append, allows=lambda *_: True, wait_s=0.05, hold_s=3600
    )
    waiting = asyncio.ensure_future(watch.ask_graph("farm", VIEWER, ()))
    await turn()
    assert watch.is_wanted("farm")
    assert not waiting.done()
    watch.receive_graph("farm", GRAPH)
    assert len((await waiting).nodes) == 3
    # An older gateway never says anything: it is waited for once on a link.
    watch.end_link("farm")
    assert (await watch.ask_graph("farm", VIEWER, ())).nodes == []
    again = asyncio.ensure_future(watch.ask_graph("farm", VIEWER, ()))
    await turn()
    assert again.done()


async def test_after_a_question_the_robot_rests_by_itself() -> None:
    _, _, sites = connected_farm()
    rested = asyncio.Event()
    watch = GraphWatch(
        sites,
        ask_soon=lambda _: None if watch.is_wanted("farm") else rested.set(),
        allows=lambda *_: True,
        wait_s=0.01,
        hold_s=0.02,
    )
    await watch.ask_graph("farm", VIEWER, ())
    await rested.wait()
    assert not watch.is_wanted("farm")
