"""All that is heard of a robot's nodes themselves: parameters, life cycles, log and clock."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from talaia.gateway.adapters.ros2.nodes.kept_lines import readers_of
from talaia.gateway.adapters.ros2.nodes.lifecycle import LifecycleStates
from talaia.gateway.adapters.ros2.nodes.parameters import Ros2Parameters
from talaia.gateway.adapters.ros2.nodes.robot_log import RobotLog

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros2.nodes.robot_clock import RobotClock
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.topic_readers import SampleBuffer, TopicPlan
    from talaia.gateway.adapters.unreadable_reports import UnreadableReports
    from talaia.gateway.ports import ChannelReading, EventSink, LogSink
    from talaia.model.connection import Ros2Connection

__all__ = ["RobotNodes"]


class RobotNodes:
    """What one connection hears of nodes. On the wait-set thread."""

    def __init__(
        self,
        *,
        scope: ConnectionScope,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        clock: Clock,
        gathered: SampleBuffer,
        latest: dict[str, ChannelReading],
        unreadable: UnreadableReports,
        events: EventSink,
        kept_log: LogSink | None,
        robot_clock: RobotClock | None,
    ) -> None:
        """Ask and hear what the scope's signals are made of, and what its connection names."""
        settings: Ros2Connection = scope.connection  # type: ignore[assignment]
        # Told once for each signal that cannot be read.
        complain = unreadable.report_unreadable
        self._parameters = Ros2Parameters(
            scope=scope,
            node=node,
            thread=thread,
            clock=clock,
            gathered=gathered,
            latest=latest,
            complain=complain,
        )
        self._lifecycles = LifecycleStates(
            scope=scope,
            node=node,
            thread=thread,
            clock=clock,
            gathered=gathered,
            latest=latest,
            complain=complain,
        )
        # None where the description does not ask for it: then nothing is subscribed.
        self._log: RobotLog | None = None
        if readers := readers_of(settings, clock, events, kept_log):
            self._log = RobotLog(node, thread, readers)
        if robot_clock is not None:
            robot_clock.join(node, thread)

    @property
    def plans(self) -> list[TopicPlan]:
        """The plans of what nodes are asked for."""
        return [*self._parameters.plans, *self._lifecycles.plans]

    def redescribe(self, scope: ConnectionScope) -> None:
        """Bring what is asked in line with another scope."""
        self._parameters.redescribe(scope)
        self._lifecycles.redescribe(scope)

    def ask(self) -> None:
        """Ask all; called once a second."""
        self._parameters.ask()
        self._lifecycles.ask()
        if self._log is not None:
            self._log.tell_left_out()
