"""The log of the robot (``/rosout``) behind a rosbridge server, of either ROS."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from talaia.clock import SECOND
from talaia.gateway.adapters.ros2.nodes.kept_lines import readers_of
from talaia.gateway.adapters.ros2.nodes.log_lines import LogHead, head_of_ros1
from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from talaia.gateway.adapters.rosbridge.outgoing_frames import ServerTopics
    from talaia.gateway.ports import AdapterContext
    from talaia.model.connection import RosbridgeConnection

__all__ = ["LOG_TOPIC", "ServerLog"]

LOG_TOPIC = "/rosout"
_TYPES = {1: "rosgraph_msgs/msg/Log", 2: "rcl_interfaces/msg/Log"}
# Behind a subscription so long, nodes of ROS 2 say again what they said last.
_REPEATED_NS = 2 * SECOND
# What was said so long before it came was said before (µs).
_OLD_US = 60_000_000
_MOST_NODES = 500


class ServerLog:
    """Hears the log as the description asks for it; who asks for nothing subscribes to nothing."""

    def __init__(self, settings: RosbridgeConnection, context: AdapterContext) -> None:
        """Know nothing yet."""
        self._ros, self._clock = settings.ros, context.clock
        self._readers = readers_of(settings, context.clock, context.events, context.kept_log)
        self._since_ns = 0
        # By node: when its newest line was said (µs, by its own clock); and what was known when
        # this connection began.
        self._newest_us: dict[str, int] = {}
        self._before_us: dict[str, int] = {}

    def subscribe(self, topics: ServerTopics) -> None:
        """Ask a server that has just come for the log."""
        self._since_ns = self._clock.monotonic_ns()
        self._before_us = dict(self._newest_us)
        if self._readers:
            topics.subscribe_topic("log", LOG_TOPIC, _TYPES[self._ros])

    def read_message(self, body: object) -> None:
        """Take a line.

        Raises:
            FieldError: it is none.

        """
        if not self._readers:
            return
        try:
            head, line = _read_line(body, self._ros)
            said_us = line.stamp.sec * 1_000_000 + line.stamp.nanosec // 1000
        except (TypeError, ValueError, AttributeError) as error:
            why = f"gave what is no {_TYPES[self._ros]} ({type(error).__name__}: {error})"
            raise FieldError(LOG_TOPIC, why) from error
        if self._is_repeated(head.node, said_us):
            return
        self._newest_us[head.node] = max(said_us, self._newest_us.get(head.node, 0))
        if len(self._newest_us) > _MOST_NODES:
            del self._newest_us[next(iter(self._newest_us))]
        for reader in self._readers:
            reader.read_line(head, lambda: line)

    def tell_left_out(self) -> None:
        """Say which lines were left out; called now and then."""
        for reader in self._readers:
            reader.tell_left_out()

    def _is_repeated(self, node: str, said_us: int) -> bool:
        """Tell whether a node says again what was kept in a connection before, or long ago."""
        if self._clock.monotonic_ns() - self._since_ns > _REPEATED_NS:
            return False
        if said_us <= self._before_us.get(node, -1):
            return True
        return self._clock.wall_ns() // 1000 - said_us > _OLD_US


def _read_line(body: Any, ros: int) -> tuple[LogHead, SimpleNamespace]:  # noqa: ANN401
    """Give a line's head, and the line as a decoder of bytes would give it."""
    level, name = int(body.level), str(body.name)
    if ros == 1:
        head, stamp = head_of_ros1(level, name), body.header.stamp
        seconds, rest = stamp.secs, stamp.nsecs
    else:
        head, stamp = LogHead(level, name), body.stamp
        seconds, rest = stamp.sec, stamp.nanosec
    line = SimpleNamespace(
        stamp=SimpleNamespace(sec=int(seconds), nanosec=int(rest)),
        msg=str(body.msg),
        function=str(body.function),
        file=str(body.file),
        line=int(body.line),
    )
    return head, line
