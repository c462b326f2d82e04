"""Devices that are being connected anew: is all of it there again? Pure but for the clock."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock

__all__ = ["WAIT_S", "ReconnectionAttempts", "reconnection_outcome"]

# A robot's parts are found within a second or two; who is not there by then is named.
WAIT_S = 5.0
_WAIT_NS = round(WAIT_S * SECOND)


class _Begun(NamedTuple):
    due_ns: int  # When it ends with whatever is there (monotonic).
    parts: int  # Topics and services in all, for the words.
    absent: Callable[[], list[str]]  # Asked at each look.
    done: Callable[[CommandOutcome], None]  # Told once.


class ReconnectionAttempts:
    """Asks at each look what is still absent, and tells the outcome once. One thread."""

    def __init__(self, clock: Clock) -> None:
        """Begin with nothing under way."""
        self._clock = clock
        # Those without an outcome yet, in the order they were begun.
        self._begun: list[_Begun] = []

    def begin_attempt(
        self, parts: int, absent: Callable[[], list[str]], done: Callable[[CommandOutcome], None]
    ) -> None:
        """Watch over ``parts`` topics and services until none is ``absent`` or time is up."""
        due = self._clock.monotonic_ns() + _WAIT_NS
        self._begun.append(_Begun(due, parts, absent, done))

    def report_finished(self) -> None:
        """Tell the outcome of what is finished."""
        now = self._clock.monotonic_ns()
        # A copy: `done` may begin another.
        for begun in list(self._begun):
            absent = begun.absent()
            if absent and now < begun.due_ns:
                continue
            # Before it is told, so that no outcome is told twice.
            self._begun.remove(begun)
            begun.done(reconnection_outcome(begun.parts, absent))

    def end_attempts(self) -> None:
        """Tell all that wait that the robot went away meanwhile."""
        for begun in self._begun:
            begun.done(CommandOutcome(CommandPhase.FAILED, "the robot's side was lost meanwhile"))
        self._begun.clear()


def reconnection_outcome(parts: int, absent: list[str]) -> CommandOutcome:
    """Say how connecting anew to ``parts`` topics and services went."""
    if not parts:
        return CommandOutcome(CommandPhase.SUCCEEDED, "it has nothing on the robot to connect to")
    there = f"{parts - len(absent)} of {parts} topics and services are there"
    if absent:
        return CommandOutcome(CommandPhase.FAILED, f"{there}; not {', '.join(absent)}"[:2000])
    return CommandOutcome(CommandPhase.SUCCEEDED, there)
