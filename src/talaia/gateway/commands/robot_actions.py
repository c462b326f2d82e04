"""What the robot has been asked to do and has not answered for good yet."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Protocol

from talaia.clock import SECOND
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from talaia.clock import Clock
    from talaia.gateway.ports import CommandTarget, Field
    from talaia.model.site import Command
    from talaia.wire.frames import CommandRequest

__all__ = ["OutcomeReceiver", "RobotActions"]

# A fifth of a second: five steps a second are smooth enough for a bar.
PROGRESS_NS = SECOND // 5


class OutcomeReceiver(Protocol):
    """Hears what became of a command."""

    def __call__(self, command_id: str, outcome: CommandOutcome) -> None:
        """Take an outcome; of a phase that is not final there may be many."""
        ...


class RobotActions:
    """Asks the robot, and keeps time: an action without an answer ends as unknown.

    Event loop only; the robot may answer from any thread.
    """

    def __init__(self, *, target: CommandTarget, clock: Clock, report: OutcomeReceiver) -> None:
        """Have asked nothing yet.

        Args:
            target: who acts.
            clock: monotonic.
            report: hears every outcome, until `forget_timer`.

        """
        self._target = target  # Who acts.
        self._clock = clock  # Monotonic; for progress alone, time-outs are the loop's.
        self._report = report  # Hears every outcome.
        # All by the command's id. What ends it as unknown when nothing is heard of it:
        self._timers: dict[str, asyncio.TimerHandle] = {}
        # What asks the robot to end it early, where that can be asked:
        self._cancels: dict[str, Callable[[], None]] = {}
        # When its progress was passed on last (monotonic):
        self._progress_ns: dict[str, int] = {}

    @property
    def ids(self) -> Iterable[str]:
        """Give the commands that are under way."""
        return self._timers.keys()

    def begin_action(self, ask: CommandRequest, command: Command, fields: dict[str, Field]) -> None:
        """Ask the robot now."""
        loop = asyncio.get_running_loop()
        # Before the robot is asked: an adapter that answers at once finds the timer it ends.
        self._restart_timer(ask.id, command.timeout)

        def done(outcome: CommandOutcome) -> None:
            loop.call_soon_threadsafe(self._on_outcome, ask.id, command.timeout, outcome)

        cancel = self._target.act(ask.device, ask.command, fields, done)
        if cancel is not None:
            self._cancels[ask.id] = cancel

    def canceller_of(self, command_id: str) -> Callable[[], None] | None:
        """Give what asks the robot to end a command early; none where that cannot be asked."""
        return self._cancels.get(command_id)

    def forget_timer(self, command_id: str) -> None:
        """Keep no time any more for a command that has ended."""
        timer = self._timers.pop(command_id, None)
        if timer is not None:
            timer.cancel()
        self._cancels.pop(command_id, None)
        self._progress_ns.pop(command_id, None)

    def _restart_timer(self, command_id: str, seconds: float) -> None:
        before = self._timers.get(command_id)
        if before is not None:
            before.cancel()
        # Unknown, not failed: silence does not say that the robot has not done it.
        silent = CommandOutcome(
            CommandPhase.UNKNOWN, f"no answer for {seconds:g} s; look at the device"
        )
        self._timers[command_id] = asyncio.get_running_loop().call_later(
            seconds, partial(self._report, command_id, silent)
        )

    def _on_outcome(self, command_id: str, timeout: float, outcome: CommandOutcome) -> None:
        if outcome.phase is not CommandPhase.RUNNING:
            self._report(command_id, outcome)
            return
        if command_id not in self._timers:
            # It has ended meanwhile: a late word of progress begins no new time.
            return
        self._restart_timer(command_id, timeout)
        # Feedback may come a hundred times a second; a bar on a page does not move that fast.
        now_ns = self._clock.monotonic_ns()
        if outcome.message or now_ns - self._progress_ns.get(command_id, 0) >= PROGRESS_NS:
            self._progress_ns[command_id] = now_ns
            self._report(command_id, outcome)

    def close(self) -> None:
        """Stop the timers; what still runs will read as unknown."""
        for timer in self._timers.values():
            timer.cancel()
