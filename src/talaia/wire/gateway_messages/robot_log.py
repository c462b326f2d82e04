"""Lines of a robot's log (``/rosout``) on their way from a gateway to its hub, where they are kept.

The gateway keeps them until the hub has them: nothing is lost with a link, and none comes twice.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import Count, Micros, Name, Word
from talaia.wire.message import Message

__all__ = ["MAX_LOG_LINES", "MAX_LOG_TEXT", "LogLine", "RobotLogAck", "RobotLogBatch"]

# Characters of a line; a gateway cuts longer ones.
MAX_LOG_TEXT = 5000
MAX_LOG_LINES = 200

_Text = Annotated[str, Meta(max_length=MAX_LOG_TEXT)]
_Level = Annotated[int, Meta(ge=0, le=255)]


class LogLine(Message, frozen=True, kw_only=True, tag="log_line", omit_defaults=True):
    """One line, or what stands for those that were left out.

    Attributes:
        time_us: when it was said (µs since the epoch, UTC).
        level: as ROS 2 counts: 10 debug, 20 info, 30 warning, 40 error, 50 fatal.
        node: who said it, as ROS 2 writes names: ``front.lidar``.
        text: in its words.
        function: in which it was said.
        file: of the source.
        line: of that file; 0: unknown.
        left_out: so many lines were not kept, and ``text`` says why; 0: it is a line of the robot.

    """

    time_us: Micros
    level: _Level
    node: Word = ""
    text: _Text = ""
    function: Word = ""
    file: Word = ""
    line: Count = 0
    left_out: Count = 0


class RobotLogBatch(Message, frozen=True, kw_only=True, tag="robot_log"):
    """Lines, told again on each new link until the hub has acknowledged them.

    Attributes:
        boot: the run of the gateway that heard them.
        first: the number of the first line; they are numbered from 0 in each run.
        lines: in the order in which they came.

    """

    boot: Name
    first: Count
    lines: Annotated[list[LogLine], Meta(min_length=1, max_length=MAX_LOG_LINES)]


class RobotLogAck(Message, frozen=True, kw_only=True, tag="robot_log_ack"):
    """All lines of a run with numbers below ``below`` are in the hub's database."""

    boot: Name
    below: Count
