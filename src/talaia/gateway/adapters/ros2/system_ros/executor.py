"""What stands for rclpy's executor: calls back for one node, in the thread that spins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.ros2.system_ros.entities import (
    JoinedContext,
    ServiceClient,
    Subscription,
)
from talaia.gateway.adapters.ros2.system_ros.process import BridgeLost

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros2.system_ros.stand_in_rclpy import Node

__all__ = ["SingleThreadedExecutor"]


class SingleThreadedExecutor:
    """Calls back for one node, in the thread that spins."""

    def __init__(self, *, context: JoinedContext) -> None:
        """Take the context."""
        self._context = context
        self._node: Node | None = None

    def add_node(self, node: Node) -> None:
        """Take the node."""
        self._node = node

    def spin_once(self, *, timeout_sec: float) -> None:
        """Wait for something, and call back for all that is there."""
        if self._node is None:
            return
        entities = self._node.entities
        with self._context.changed:
            self._context.changed.wait_for(
                lambda: any(entity.queue for entity in entities), max(0.0, timeout_sec)
            )
        if lost := self._context.joined().lost:
            raise BridgeLost(lost)
        # Callbacks may make more of them.
        for entity in list(entities):
            while entity.queue:
                if isinstance(entity, Subscription):
                    entity.callback(entity.queue.popleft()[0])
                elif isinstance(entity, ServiceClient):
                    header, answer = entity.take_response(None)
                    future = entity.futures.pop(header.request_id.sequence_number, None)
                    if future is not None:
                        future.finish(answer)

    def shutdown(self, **_: object) -> None:
        """Call nobody back any more."""
        self._node = None
