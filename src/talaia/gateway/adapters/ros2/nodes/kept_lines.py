"""Which lines of a robot's log are kept at the hub, and what is kept of each.

Of ROS 1 and ROS 2 alike. Knows no ROS and no socket.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from talaia.clock import SECOND
from talaia.gateway.adapters.ros2.nodes.log_lines import LogBounds, LogLines, LogRates
from talaia.model.closed_lists import LogLevel
from talaia.wire.frames import LogLine

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.adapters.ros2.nodes.log_lines import LogHead
    from talaia.gateway.ports import EventSink, LogSink
    from talaia.model.connections.ros1 import Ros1Connection
    from talaia.model.connections.ros2 import Ros2Settings
    from talaia.model.connections.rosbridge import RosbridgeConnection

__all__ = ["KEPT_RATES", "KeptLines", "make_line", "readers_of"]

# 600 lines a minute of all nodes, and 300 of one; as many at once.
KEPT_RATES = LogRates(
    node_burst=300, node_every_ns=SECOND // 5, all_burst=600, all_every_ns=SECOND // 10
)
# Letters of a line that are kept.
_MAX_TEXT = 4000
_MAX_NAME = 200
# A line's own time counts if it was said so shortly before it came (µs); else a clock is wrong.
_LONGEST_WAY_US = 60_000_000
_WARNING = 30


class KeptLines:
    """Hears all nodes of a robot; what has room is kept, and what has not is counted."""

    def __init__(self, least: LogLevel, clock: Clock, sink: LogSink) -> None:
        """Keep lines from the level ``least`` on in ``sink``."""
        self._clock, self._sink = clock, sink
        self._bounds = LogBounds(least, clock.monotonic_ns(), KEPT_RATES)

    def read_line(self, head: LogHead, decode: Callable[[], Any]) -> None:
        """Judge a line by its head; only for one with room ``decode`` is called."""
        if not self._bounds.is_wanted(head.level):
            return
        if self._bounds.has_room(head.node, self._clock.monotonic_ns()):
            self._sink.keep_line(make_line(head, decode(), self._clock.wall_ns() // 1000))

    def tell_left_out(self) -> None:
        """Keep how many lines were left out; called now and then."""
        count, why = self._bounds.collect_left_out(self._clock.monotonic_ns())
        if count:
            now_us = self._clock.wall_ns() // 1000
            self._sink.keep_line(LogLine(time_us=now_us, level=_WARNING, text=why, left_out=count))


def readers_of(
    settings: Ros2Settings | Ros1Connection | RosbridgeConnection,
    clock: Clock,
    events: EventSink,
    sink: LogSink | None,
) -> list[LogLines | KeptLines]:
    """Give who reads a robot's log, as its connection says; nobody: it is not heard."""
    readers: list[LogLines | KeptLines] = []
    if settings.log is not LogLevel.NONE:
        readers.append(LogLines(settings.log, clock, events))
    # Who only asks what a robot has, keeps nothing.
    if settings.keep_log is not LogLevel.NONE and sink is not None:
        readers.append(KeptLines(settings.keep_log, clock, sink))
    return readers


def make_line(head: LogHead, message: Any, now_us: int) -> LogLine:  # noqa: ANN401
    """Give what is kept of a message of either ROS that came at ``now_us`` (µs, UTC)."""
    # ROS 1 has the stamp in a header.
    stamp = getattr(message, "stamp", None) or message.header.stamp
    said_us = int(stamp.sec) * 1_000_000 + int(stamp.nanosec) // 1000
    text = str(message.msg)
    if len(text) > _MAX_TEXT:
        text = f"{text[:_MAX_TEXT]} … (cut: the line has {len(text)} characters)"
    return LogLine(
        # A robot's clock may be wrong, or a simulator's.
        time_us=said_us if 0 <= now_us - said_us <= _LONGEST_WAY_US else now_us,
        level=head.level,
        node=_sendable(head.node)[:_MAX_NAME],
        text=_sendable(text),
        function=_sendable(str(message.function)[:_MAX_NAME]),
        # The end of a path says more than its beginning.
        file=_sendable(str(message.file)[-_MAX_NAME:]),
        line=max(0, int(message.line)),
    )


def _sendable(text: str) -> str:
    """Give what can be written as UTF-8: half a pair of surrogates cannot."""
    return text.encode("utf-8", "replace").decode()
