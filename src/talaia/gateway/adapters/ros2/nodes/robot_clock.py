"""The robot's own clock (``/clock``), where its nodes go by it. On the wait-set thread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock as ClockMessage

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread

__all__ = ["RobotClock"]


class RobotClock:
    """How far the robot's time lies from ours; outlives a connection that is lost."""

    def __init__(self, clock: Clock) -> None:
        """Know nothing yet."""
        self._clock = clock  # Ours: wall time.
        # What is added to the robot's time to have ours (µs); none before it was heard.
        self._shift_us: int | None = None
        # Kept, because a subscription that nobody holds is destroyed.
        self._subscription: Any = None

    def join(self, node: Any, thread: WaitThread) -> None:  # noqa: ANN401 - rclpy ships no types
        """Begin to hear it."""
        # A simulator says it up to a thousand times a second: only the newest counts.
        quality = QoSProfile(
            history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT
        )
        # Another simulation may run when a connection is back.
        self._shift_us = None
        self._subscription = node.create_subscription(
            ClockMessage, "/clock", _never, quality, raw=True
        )
        thread.add_subscription(self._subscription.handle, ClockMessage, self._read_time)

    def shift_us(self) -> int | None:
        """Give what is added to the robot's time to have ours (µs); none before it was heard."""
        return self._shift_us

    def _read_time(self, raw: bytes, _: Any) -> None:  # noqa: ANN401
        time = deserialize_message(raw, ClockMessage).clock
        now_us = self._clock.wall_ns() // 1000
        self._shift_us = now_us - (time.sec * 1_000_000 + time.nanosec // 1000)


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
