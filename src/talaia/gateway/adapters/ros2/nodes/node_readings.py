"""What is read of nodes themselves as signals, whatever it is. On the wait-set thread."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.topic_readers import SampleBuffer, TopicPlan
    from talaia.gateway.ports import ChannelReading

__all__ = ["NodeReadings"]

# What is kept of a node that is asked.
Asked = TypeVar("Asked")


class NodeReadings(ABC, Generic[Asked]):
    """The signals that are made of nodes, and what is asked of each.

    Attributes:
        plans: of those signals.

    """

    def __init__(
        self,
        *,
        scope: ConnectionScope,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        clock: Clock,
        gathered: SampleBuffer,
        latest: dict[str, ChannelReading],
        complain: Callable[[str, str], None],
    ) -> None:
        """Ask each node that has any."""
        # Where samples go, with the times of their arrival.
        self._clock, self._gathered = clock, gathered
        self._node, self._thread = node, thread
        self._latest, self._complain = latest, complain
        # By node; a node stays while any signal is of it.
        self._nodes: dict[str, Asked] = {}
        self.plans: list[TopicPlan] = []
        self.redescribe(scope)

    @abstractmethod
    def redescribe(self, scope: ConnectionScope) -> None:
        """Ask for what this scope names; nodes that are asked already stay so."""
