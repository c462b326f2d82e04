"""Which node of ROS 1 publishes, subscribes and serves what. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.tap_ports import GraphNode

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros1.master import GraphState

__all__ = ["nodes_of"]


def nodes_of(graph: GraphState) -> list[GraphNode]:
    """Turn what the master says, by topic and service, into what each node has."""
    found: dict[str, tuple[list[str], list[str], list[str]]] = {}
    for at, names in enumerate((graph.published, graph.heard, graph.services)):
        for name, nodes in sorted(names.items()):
            for node in nodes:
                found.setdefault(node, ([], [], []))[at].append(name)
    return [
        GraphNode(node, tuple(published), tuple(heard), tuple(served))
        for node, (published, heard, served) in sorted(found.items())
    ]
