"""Who of a robot publishes, subscribes and serves what: told while somebody wants to know it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import Count, Name, Word
from talaia.wire.message import Message

__all__ = ["MAX_GRAPH_NAMES", "MAX_GRAPH_NODES", "RobotGraph", "RobotNode"]

# Nodes of a site, and names of topics and services that all of them have together.
MAX_GRAPH_NODES, MAX_GRAPH_NAMES = 500, 20_000

_Names = Annotated[list[Name], Meta(max_length=MAX_GRAPH_NAMES)]


class RobotNode(Message, frozen=True, kw_only=True, tag="robot_node"):
    """One node of the robot, and the absolute names that it has.

    Attributes:
        name: absolute, too.
        publishes: topics.
        subscribes: topics.
        serves: services.

    """

    name: Name
    publishes: _Names = []
    subscribes: _Names = []
    serves: _Names = []


class RobotGraph(Message, frozen=True, kw_only=True, tag="robot_graph"):
    """All nodes of the robot now. Sent on every change, to a hub that asks for it.

    Attributes:
        nodes: see above.
        distro: the robot's distribution of ROS, in small letters; empty where nobody says it.
        left_out: so many more are there that have no room.

    """

    nodes: Annotated[list[RobotNode], Meta(max_length=MAX_GRAPH_NODES)] = []
    distro: Word = ""
    left_out: Count = 0
