"""The robot's log (``/rosout``) in the site's logbook. On the wait-set thread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from talaia.gateway.adapters.ros2.nodes.log_lines import LogBounds, level_word, read_head
from talaia.model.closed_lists import LogLevel

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.ports import EventSink

__all__ = ["RobotLog"]

# Between two turns of the wait set; of what is more the oldest is lost.
_DEPTH = 1_000
# Letters of a line: some nodes write whole messages.
_MAX_TEXT = 500
# What is no trouble.
_GOOD = (LogLevel.DEBUG, LogLevel.INFO)


class RobotLog:
    """Hears all nodes; what has room goes on, and what has not is counted."""

    def __init__(
        self,
        *,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        clock: Clock,
        events: EventSink,
        least: LogLevel,
    ) -> None:
        """Begin to hear; what was said before is the robot's own."""
        self._clock, self._events = clock, events  # Monotonic times; the logbook.
        self._bounds = LogBounds(least, clock.monotonic_ns())
        quality = QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.VOLATILE,
        )
        # Kept, because a subscription that nobody holds is destroyed.
        self._subscription = node.create_subscription(Log, "/rosout", _never, quality, raw=True)
        thread.add_subscription(self._subscription.handle, Log, self._read_line)

    def tell_left_out(self) -> None:
        """Say what was left out; called now and then."""
        if said := self._bounds.left_out(self._clock.monotonic_ns()):
            self._events.report_event("robot_log", said, good=True)

    def _read_line(self, raw: bytes, _: Any) -> None:  # noqa: ANN401
        head = read_head(raw)
        # Before anything is decoded: a node may say thousands of lines a second.
        if head is None or not self._bounds.is_wanted(head.level):
            return
        # Then by who says it: what has no room is counted, and never decoded.
        now_ns = self._clock.monotonic_ns()
        if not self._bounds.has_room(head.node, now_ns):
            return
        text = deserialize_message(raw, Log).msg[:_MAX_TEXT]
        if self._bounds.is_new(head.node, text, now_ns):
            level = level_word(head.level)
            # `[WARNING]` and `[ERROR]` mark a line on the pages.
            mark = LogLevel.ERROR if level is LogLevel.FATAL else level
            said = f"[{mark.upper()}] {head.node}: {text}"
            self._events.report_event("robot_log", said, good=level in _GOOD)


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
