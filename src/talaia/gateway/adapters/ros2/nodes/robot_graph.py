"""Which node of ROS 2 publishes, subscribes and serves what. On the wait-set thread.

A node takes three questions to the graph; a robot has a hundred nodes. So they are asked in short
turns, and messages are taken between two of them.
"""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, Any

from talaia.gateway.tap_ports import GraphNode

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.tap_ports import TapSink

__all__ = ["GraphReader"]

# Of one turn (ns).
_TURN_NS = 2_000_000
_MAX_NODES = 500
# By ROS's convention hidden: names of one part that begins so, as those of actions.
_HIDDEN, _ACTION = "/_", "/_action/send_goal"


class GraphReader:
    """Reads all nodes when told to, and lists them when they are others than before."""

    def __init__(self, node: Any, thread: WaitThread, sink: TapSink) -> None:  # noqa: ANN401
        """Take the node whose graph is read."""
        self._node = node
        self._thread = thread
        self._sink = sink
        # As they were listed.
        self._listed: list[GraphNode] | None = None
        # Nodes that are still to be read, and those that have been, in this round.
        self._rest: list[tuple[str, str]] = []
        self._found: list[GraphNode] = []

    def begin_anew(self) -> None:
        """Read all and list them, whether or not they have changed."""
        self._listed = None
        self.read_nodes()

    def read_nodes(self) -> None:
        """Begin a round, unless one is under way."""
        if not self._rest:
            known = set(self._node.get_node_names_and_namespaces())
            self._rest = sorted(known)[:_MAX_NODES]
            self._found = []
            self._read_some()

    def _read_some(self) -> None:
        until = time.monotonic_ns() + _TURN_NS
        while self._rest:
            name, space = self._rest.pop()
            try:
                self._found.append(self._read_node(name, space))
            except Exception:  # noqa: BLE001, S112 - rclpy names none: it has left meanwhile
                continue
            if self._rest and time.monotonic_ns() > until:
                self._thread.run_soon(self._read_some)
                return
        found = sorted(self._found)
        if found != self._listed:
            self._listed = found
            self._sink.list_nodes(found, os.environ.get("ROS_DISTRO", ""))

    def _read_node(self, name: str, space: str) -> GraphNode:
        node = self._node
        return GraphNode(
            f"{space.rstrip('/')}/{name}",
            _shown(node.get_publisher_names_and_types_by_node(name, space)),
            _shown(node.get_subscriber_names_and_types_by_node(name, space)),
            _shown(
                # An action goes by its own name.
                (said.removesuffix(_ACTION), kinds)
                for said, kinds in node.get_service_names_and_types_by_node(name, space)
            ),
        )


def _shown(found: Iterable[tuple[str, object]]) -> tuple[str, ...]:
    return tuple(sorted(name for name, _ in found if _HIDDEN not in name))
