"""The nodes of all connections of a site, as the hub is told of them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire.frames import MAX_GRAPH_NAMES, MAX_GRAPH_NODES, RobotGraph, RobotNode

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.gateway.tap_ports import GraphNode

__all__ = ["SiteGraph"]

# What a name may have on the wire (letters).
_LONGEST = 200


class SiteGraph:
    """What is known while somebody wants to know it.

    Attributes:
        known: some connection has said which nodes it has.

    """

    def __init__(self) -> None:
        """Know nothing."""
        self._nodes: dict[str, tuple[GraphNode, ...]] = {}
        self._distro = ""

    @property
    def known(self) -> bool:
        """See above."""
        return bool(self._nodes)

    def clear(self) -> None:
        """Know nothing any more."""
        self._nodes.clear()

    def replace_nodes(self, connection: str, nodes: Sequence[GraphNode], distro: str) -> bool:
        """Take all nodes of a connection; tell whether that is news."""
        new = tuple(nodes)
        if self._nodes.get(connection) == new and self._distro == (distro or self._distro):
            return False
        self._nodes[connection] = new
        self._distro = distro or self._distro
        return True

    def message(self) -> RobotGraph:
        """Give all of them; the last ones, where they are too many, are left out."""
        # Of one name in two connections the names of both count.
        merged: dict[str, list[set[str]]] = {}
        for nodes in self._nodes.values():
            for node in nodes:
                sets = merged.setdefault(node.name, [set(), set(), set()])
                for kept, names in zip(sets, node[1:], strict=True):
                    kept.update(name for name in names if 0 < len(name) <= _LONGEST)
        told: list[RobotNode] = []
        room = MAX_GRAPH_NAMES
        for name, sets in sorted(merged.items()):
            room -= sum(map(len, sets))
            if room < 0 or len(told) == MAX_GRAPH_NODES or not 0 < len(name) <= _LONGEST:
                continue
            publishes, subscribes, serves = map(sorted, sets)
            told.append(
                RobotNode(name=name, publishes=publishes, subscribes=subscribes, serves=serves)
            )
        return RobotGraph(nodes=told, distro=self._distro[:50], left_out=len(merged) - len(told))
