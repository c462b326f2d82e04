"""The robot's log (``/rosout``): in the site's logbook, and kept. On the wait-set thread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from talaia.gateway.adapters.ros2.nodes.log_lines import read_head

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.gateway.adapters.ros2.nodes.kept_lines import KeptLines
    from talaia.gateway.adapters.ros2.nodes.log_lines import LogLines
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread

__all__ = ["RobotLog"]

# Between two turns of the wait set; of what is more the oldest is lost.
_DEPTH = 1_000


class RobotLog:
    """Hears all nodes; what has room goes on, and what has not is counted."""

    def __init__(
        self,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        readers: Sequence[LogLines | KeptLines],
    ) -> None:
        """Begin to hear for ``readers``; what was said before is the robot's own."""
        self._readers = readers
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
        for reader in self._readers:
            reader.tell_left_out()

    def _read_line(self, raw: bytes, _: Any) -> None:  # noqa: ANN401
        head = read_head(raw)
        if head is not None:
            for reader in self._readers:
                reader.read_line(head, lambda: deserialize_message(raw, Log))


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
