"""From what is true each moment to what counts: delays, and what cannot be judged."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.hub.alarms.conditions import Truth

if TYPE_CHECKING:
    from talaia.hub.alarms.conditions import ConditionVerdict
    from talaia.model.alarms.alarm import Alarm

__all__ = ["ConditionTurn", "ConditionWatch", "Edge"]


class ConditionTurn(StrEnum):
    """Which way it went."""

    RAISE = "raise"
    CLEAR = "clear"


class Edge(NamedTuple):
    """A condition that has begun or ceased to count, and why."""

    turn: ConditionTurn
    why: str


class ConditionWatch:
    """Holds one condition against its delays.

    What it knows is lost with the process, and no harm done: it begins with whether the alarm was
    on, as the database has it, and a delay that was running begins anew.

    Attributes:
        on: the condition counts.
        known: it could be judged when last looked at.
        why: what was last said of it.

    """

    def __init__(self, alarm: Alarm, *, on: bool) -> None:
        """Begin with ``on`` as it was last written down."""
        # So long without a break it must be seen true before it counts, and false before it ceases.
        self._delay_ns = round(alarm.delay * SECOND)
        self._clear_ns = round(alarm.clear_delay * SECOND)
        # None: that it cannot be judged never raises the alarm.
        self._unknown_ns = (
            None if alarm.unknown_after is None else round(alarm.unknown_after * SECOND)
        )
        self.on = on
        self.known = True
        self.why = ""
        # When it was first seen so (monotonic ns); None: not so. That it was true outlasts a while
        # in which it cannot be judged; that it was false does not.
        self._true_since: int | None = None
        self._false_since: int | None = None
        self._unknown_since: int | None = None

    @property
    def running(self) -> bool:
        """Whether time alone may turn it: a delay runs."""
        return any(
            since is not None
            for since in (self._true_since, self._false_since, self._unknown_since)
        )

    def update_verdict(self, verdict: ConditionVerdict, now_ns: int) -> Edge | None:
        """Take what is true at ``now_ns`` (monotonic); give the edge, if this makes one."""
        self.why = verdict.why
        self.known = verdict.truth is not Truth.UNKNOWN
        match verdict.truth:
            case Truth.HOLDS:
                return self._handle_true(verdict.why, now_ns)
            case Truth.FALSE:
                return self._handle_false(verdict.why, now_ns)
            case Truth.UNKNOWN:
                return self._handle_unknown(verdict.why, now_ns)

    def _handle_true(self, why: str, now_ns: int) -> Edge | None:
        # Seen true once is enough: the delay to clear begins anew.
        self._false_since = self._unknown_since = None
        if self.on:
            return None
        if self._true_since is None:
            self._true_since = now_ns
        if now_ns - self._true_since < self._delay_ns:
            return None
        return self._make_edge(ConditionTurn.RAISE, why)

    def _handle_false(self, why: str, now_ns: int) -> Edge | None:
        # Seen false once is enough: the delay to raise begins anew.
        self._true_since = self._unknown_since = None
        if not self.on:
            return None
        if self._false_since is None:
            self._false_since = now_ns
        if now_ns - self._false_since < self._clear_ns:
            return None
        return self._make_edge(ConditionTurn.CLEAR, why)

    def _handle_unknown(self, why: str, now_ns: int) -> Edge | None:
        # Not seen to be false: what was true goes on counting towards its delay once it is seen
        # again, and what was false has to be seen so anew.
        self._false_since = None
        if self._unknown_since is None:
            self._unknown_since = now_ns
        # One that is on stays on: what is not known is never taken for well.
        if self.on or self._unknown_ns is None:
            return None
        if now_ns - self._unknown_since < self._unknown_ns:
            return None
        return self._make_edge(ConditionTurn.RAISE, f"it cannot be judged: {why}")

    def _make_edge(self, turn: ConditionTurn, why: str) -> Edge:
        self.on = turn is ConditionTurn.RAISE
        self._true_since = self._false_since = None
        return Edge(turn, why)
