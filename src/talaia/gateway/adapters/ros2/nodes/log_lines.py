"""Which lines of a robot's log go on, so that a node that talks much costs little.

Of ROS 1 and ROS 2 alike. Knows no ROS and no socket.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from talaia.clock import SECOND
from talaia.model.closed_lists import LogLevel

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink

__all__ = [
    "LogBounds",
    "LogHead",
    "LogLines",
    "LogRates",
    "head_of_ros1",
    "level_word",
    "read_head",
]

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")
# The same line of a node within so long is one.
_SAME_NS = 60 * SECOND
# What was left out is told at most so often.
_TOLD_NS = 60 * SECOND
# Letters of a line: some nodes write whole messages.
_MAX_TEXT = 500
# What is no trouble.
_GOOD = (LogLevel.DEBUG, LogLevel.INFO)
# Nodes and lines that are remembered; the oldest go.
_MOST = 500
# rcl_interfaces/msg/Log: its levels.
_LEVELS = {
    LogLevel.DEBUG: 10,
    LogLevel.INFO: 20,
    LogLevel.WARNING: 30,
    LogLevel.ERROR: 40,
    LogLevel.FATAL: 50,
}
# rosgraph_msgs/Log: its levels as ROS 2 counts them; what is none of them is an *info*.
_OLD_LEVELS, _INFO = {1: 10, 2: 20, 4: 30, 8: 40, 16: 50}, 20
# Of a Log's bytes: the header of CDR, its stamp, the level, then the length of the node's name.
_LEVEL_AT, _NAME_AT = 12, 16


class LogRates(NamedTuple):
    """Lines of one node, and of all: so many at once, and then one in so long (ns)."""

    node_burst: int
    node_every_ns: int
    all_burst: int
    all_every_ns: int


# What a person reads in the logbook.
_BOOK_RATES = LogRates(
    node_burst=5, node_every_ns=10 * SECOND, all_burst=20, all_every_ns=3 * SECOND
)


class LogHead(NamedTuple):
    """What is read of a line before anything else: who says it, and how bad (as ROS 2 counts)."""

    level: int
    node: str


def read_head(raw: bytes) -> LogHead | None:
    """Read the head of a serialized ``rcl_interfaces/msg/Log``; none of what is no such message."""
    # The second byte of CDR says which end comes first.
    order = "<" if len(raw) > 1 and raw[1] & 1 else ">"
    try:
        (length,) = struct.unpack_from(f"{order}I", raw, _NAME_AT)
    except struct.error:
        return None
    name = raw[_NAME_AT + 4 : _NAME_AT + 4 + length]
    # Cut short, or something else.
    if len(name) < length:
        return None
    return LogHead(raw[_LEVEL_AT], name.rstrip(b"\0").decode("utf-8", "replace"))


def head_of_ros1(level: int, name: str) -> LogHead:
    """Give the head of a line of ROS 1 as of one of ROS 2: its names are absolute there."""
    return LogHead(_OLD_LEVELS.get(level, _INFO), name.lstrip("/").replace("/", "."))


def level_word(level: int) -> LogLevel:
    """Name a level of ROS; what lies between two is the lower one."""
    reached = [word for word, number in _LEVELS.items() if number <= level]
    return reached[-1] if reached else LogLevel.DEBUG


class _Allowance:
    """So many at once, and then one in so long."""

    __slots__ = ("_at_ns", "_left")

    def __init__(self, burst: int, now_ns: int) -> None:
        self._left, self._at_ns = float(burst), now_ns  # Fractions grow with time.

    def use(self, now_ns: int, burst: int, every_ns: int) -> bool:
        """Take one, if there is one."""
        grown = (now_ns - self._at_ns) / every_ns
        self._left, self._at_ns = min(float(burst), self._left + grown), now_ns
        # Nothing is owed: what came without room does not make the next one wait longer.
        if self._left < 1:
            return False
        self._left -= 1
        return True


class LogBounds:
    """Judges each line; times are monotonic (ns)."""

    def __init__(self, least: LogLevel, now_ns: int, rates: LogRates = _BOOK_RATES) -> None:
        """Let lines through from the level ``least`` on."""
        self._least = _LEVELS[least]  # As ROS counts levels.
        self._rates = rates
        self._all = _Allowance(rates.all_burst, now_ns)
        # By node; and when a line came last, by node and text.
        self._nodes: dict[str, _Allowance] = {}
        self._said_ns: dict[tuple[str, str], int] = {}
        # What was left out since it was told last: lines by node.
        self._left_out: dict[str, int] = {}
        self._told_ns = now_ns

    def is_wanted(self, level: int) -> bool:
        """Tell whether lines of this level go on at all; those that do not are no loss."""
        return level >= self._least

    def has_room(self, node: str, now_ns: int) -> bool:
        """Tell whether a line of this node goes on; counts it if not."""
        rates, allowance = self._rates, self._nodes.get(node)
        if allowance is None:
            allowance = self._nodes[node] = _Allowance(rates.node_burst, now_ns)
            _forget_oldest(self._nodes)
        # Its own first: who talks much takes nothing from the others.
        if allowance.use(now_ns, rates.node_burst, rates.node_every_ns) and self._all.use(
            now_ns, rates.all_burst, rates.all_every_ns
        ):
            return True
        self._left_out[node] = self._left_out.get(node, 0) + 1
        return False

    def is_new(self, node: str, text: str, now_ns: int) -> bool:
        """Tell whether a node has not said just this within the last minute."""
        # Taken out, so that what is said now is the youngest.
        before_ns = self._said_ns.pop((node, text), None)
        self._said_ns[node, text] = now_ns
        _forget_oldest(self._said_ns)
        if before_ns is None or now_ns - before_ns > _SAME_NS:
            return True
        self._left_out[node] = self._left_out.get(node, 0) + 1
        return False

    def left_out(self, now_ns: int) -> str:
        """Say what was left out, at most once a minute; empty for nothing, or not yet."""
        return self.collect_left_out(now_ns)[1]

    def collect_left_out(self, now_ns: int) -> tuple[int, str]:
        """Do as `left_out`; give how many lines it is about, too."""
        if not self._left_out or now_ns - self._told_ns < _TOLD_NS:
            return 0, ""
        self._told_ns = now_ns
        # Who said most comes first.
        counts = sorted(self._left_out.items(), key=lambda item: -item[1])
        # Begins anew; the allowances go on as they are.
        total = sum(self._left_out.values())
        self._left_out = {}
        most = ", ".join(f"{count} of {node}" for node, count in counts[:3])
        return total, f"{total} more lines of the robot's log were left out: {most}"


class LogLines:
    """Hears all nodes of a robot; what has room goes on, and what has not is counted."""

    def __init__(self, least: LogLevel, clock: Clock, events: EventSink) -> None:
        """Let lines through from the level ``least`` on, into the logbook."""
        self._clock, self._events = clock, events
        self._bounds = LogBounds(least, clock.monotonic_ns())

    def read_line(self, head: LogHead, decode: Callable[[], Any]) -> None:
        """Judge a line by its head; only for one with room ``decode`` gives the message."""
        # Before anything is decoded: a node may say thousands of lines a second.
        if not self._bounds.is_wanted(head.level):
            return
        # Then by who says it: what has no room is counted, and never decoded.
        now_ns = self._clock.monotonic_ns()
        if not self._bounds.has_room(head.node, now_ns):
            return
        text = str(decode().msg)[:_MAX_TEXT]
        if self._bounds.is_new(head.node, text, now_ns):
            level = level_word(head.level)
            # `[WARNING]` and `[ERROR]` mark a line on the pages.
            mark = LogLevel.ERROR if level is LogLevel.FATAL else level
            said = f"[{mark.upper()}] {head.node}: {text}"
            self._events.report_event("robot_log", said, good=level in _GOOD)

    def tell_left_out(self) -> None:
        """Say what was left out; called now and then."""
        if said := self._bounds.left_out(self._clock.monotonic_ns()):
            self._events.report_event("robot_log", said, good=True)


def _forget_oldest(known: dict[_Key, _Value]) -> None:
    while len(known) > _MOST:
        del known[next(iter(known))]
