"""Calls that a rosbridge server has not answered yet. Pure.

A call is told *running* as often as the server says so and one final outcome at most, whatever the
server repeats. When the connection goes, all that are left are told as unknown.
"""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.rosbridge.protocol import outcome_of, progress_of
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.rosbridge.protocol import ServerMessage
    from talaia.model.site import Command

__all__ = ["MAX_PENDING", "PendingCalls"]

MAX_PENDING = 1000
_CUT = "the connection was lost; look at the device to see what it did"


class _Call(NamedTuple):
    """A command that waits for its end."""

    command: Command
    done: Callable[[CommandOutcome], None]


class PendingCalls:
    """All of one connection after the other. On the event loop."""

    def __init__(self) -> None:
        """Start with none."""
        # Never the same twice, also over connections: a late answer must not end another call.
        self._numbers = count(1)
        # By the name under which the server knows it, oldest first.
        self._calls: dict[str, _Call] = {}

    def next_name(self) -> str:
        """Give a name for a command, which no other ever had."""
        return f"call {next(self._numbers)}"

    def begin_call(
        self, name: str, command: Command, done: Callable[[CommandOutcome], None]
    ) -> None:
        """Await the end of a call of that name."""
        if len(self._calls) >= MAX_PENDING:
            # Calls that were never answered; their callers have long given up.
            self._calls.pop(next(iter(self._calls)))
        self._calls[name] = _Call(command, done)

    def end_call(self, answer: ServerMessage) -> None:
        """Take in an answer, or the result of an action."""
        call = self._calls.pop(answer.id, None)
        if call is not None:
            call.done(outcome_of(answer))

    def report_progress(self, feedback: ServerMessage) -> None:
        """Take in an action's feedback."""
        call = self._calls.get(feedback.id)
        if call is not None:
            call.done(progress_of(feedback, call.command))

    def fail_call(self, name: str, words: str) -> bool:
        """Take in that the server cannot do it; tell whether there was such a call."""
        call = self._calls.pop(name, None)
        if call is not None:
            call.done(CommandOutcome(CommandPhase.FAILED, words[:2000]))
        return call is not None

    def lose_all(self) -> None:
        """Tell of all that are left that nobody knows how they ended."""
        # Emptied first: whoever is told may begin another.
        calls, self._calls = self._calls, {}
        for call in calls.values():
            call.done(CommandOutcome(CommandPhase.UNKNOWN, _CUT))
