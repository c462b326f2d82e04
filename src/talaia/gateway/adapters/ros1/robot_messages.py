"""The log and the clock of a ROS 1 robot (``/rosout``, ``/clock``). On the node's thread."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros2.nodes.kept_lines import readers_of
from talaia.gateway.adapters.ros2.nodes.log_lines import head_of_ros1

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.nodes.log_lines import LogHead
    from talaia.gateway.ports import AdapterContext
    from talaia.model.connection import Ros1Connection

__all__ = ["RobotMessages", "RobotTopic", "read_log_head"]

# A simulator says its time up to a thousand times a second (Hz).
_CLOCK_RATE = 50.0
# Of a Log's bytes: number and stamp of its header, then the length of the header's frame.
_FRAME_AT = 12
_LENGTH, _TIME = struct.Struct("<I"), struct.Struct("<II")


class RobotTopic(NamedTuple):
    """A topic that is heard for what it says of the robot itself.

    Attributes:
        rate: its messages come no faster (Hz); 0 for all of them.
        read: takes a message's bytes, when it came (µs, UTC), and what decodes it.

    """

    name: str
    type_name: str
    rate: float
    read: Callable[[bytes, int, Callable[[bytes], Any]], None]


def read_log_head(raw: bytes) -> LogHead | None:
    """Read the head of a serialized ``rosgraph_msgs/Log``; none of what is no such message."""
    try:
        (frame,) = _LENGTH.unpack_from(raw, _FRAME_AT)
        level_at = _FRAME_AT + _LENGTH.size + frame
        level = raw[level_at]
        (length,) = _LENGTH.unpack_from(raw, level_at + 1)
    except (struct.error, IndexError):
        return None
    begin = level_at + 1 + _LENGTH.size
    name = raw[begin : begin + length]
    # Cut short, or something else.
    if len(name) < length:
        return None
    return head_of_ros1(level, name.decode("utf-8", "replace"))


class RobotMessages:
    """What one connection hears of the robot itself, as its description asks for it."""

    def __init__(self, settings: Ros1Connection, context: AdapterContext) -> None:
        """Know nothing yet."""
        self._goes_by_clock = settings.use_sim_time
        # What is added to the robot's time to have ours (µs); none before it was heard.
        self._shift_us: int | None = None
        # Nobody where the description does not ask for it.
        self._readers = readers_of(settings, context.clock, context.events, context.kept_log)

    @property
    def topics(self) -> list[RobotTopic]:
        """What is to be heard."""
        found = []
        if self._readers:
            found.append(RobotTopic("/rosout", "rosgraph_msgs/msg/Log", 0.0, self._read_line))
        if self._goes_by_clock:
            found.append(
                RobotTopic("/clock", "rosgraph_msgs/msg/Clock", _CLOCK_RATE, self._read_time)
            )
        return found

    @property
    def shift_us(self) -> Callable[[], int | None] | None:
        """What gives the distance to the robot's time, see `HeaderTimes`; none: it is ours."""
        return (lambda: self._shift_us) if self._goes_by_clock else None

    def forget_time(self) -> None:
        """Begin anew: another simulation may run when a connection is back."""
        self._shift_us = None

    def tell_left_out(self) -> None:
        """Say which lines of the log were left out; called now and then."""
        for reader in self._readers:
            reader.tell_left_out()

    def _read_line(self, raw: bytes, _: int, decode: Callable[[bytes], Any]) -> None:
        head = read_log_head(raw)
        if head is not None:
            for reader in self._readers:
                reader.read_line(head, lambda: decode(raw))

    def _read_time(self, raw: bytes, came_us: int, _: Callable[[bytes], Any]) -> None:
        if len(raw) == _TIME.size:
            seconds, nanoseconds = _TIME.unpack(raw)
            self._shift_us = came_us - (seconds * 1_000_000 + nanoseconds // 1000)
