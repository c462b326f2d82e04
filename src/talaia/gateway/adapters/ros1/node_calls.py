"""One-shot commands that the ROS 1 node has been told to do. Pure.

A call is told *running* as often as the node says so and one final outcome at most. When the
connection goes, all that are left are told as unknown.
"""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, Any

from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["MAX_PENDING", "NodeCalls"]

MAX_PENDING = 1000
_MAX_TEXT = 2000
_CUT = "the connection was lost; look at the device to see what it did"


class NodeCalls:
    """All of one adapter, over all lives of its node. On the event loop."""

    def __init__(self) -> None:
        """Start with none."""
        # Never the same twice: an answer of a node that is gone must not end another's call.
        self._numbers = count()
        # By number, oldest first.
        self._pending: dict[int, Callable[[CommandOutcome], None]] = {}

    def begin_call(self, done: Callable[[CommandOutcome], None]) -> int:
        """Await a call's end; give its number."""
        if len(self._pending) >= MAX_PENDING:
            # Calls that were never answered; their callers have long given up.
            self._pending.pop(next(iter(self._pending)))
        call = next(self._numbers)
        self._pending[call] = done
        return call

    def report_outcome(self, frame: Mapping[str, Any]) -> None:
        """Take in what the node says of a call."""
        phase, call = CommandPhase(frame["phase"]), frame["call"]
        running = phase is CommandPhase.RUNNING
        done = self._pending.get(call) if running else self._pending.pop(call, None)
        if done is not None:
            done(CommandOutcome(phase, frame["message"][:_MAX_TEXT], frame["progress"]))

    def lose_all(self) -> None:
        """Tell of all that are left that nobody knows how they ended."""
        # Emptied first: whoever is told may begin another.
        pending, self._pending = self._pending, {}
        for done in pending.values():
            done(CommandOutcome(CommandPhase.UNKNOWN, _CUT))
