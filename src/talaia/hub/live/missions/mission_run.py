"""One run of a mission: a step, its end, the next one, until something is not as it must be.

The hub begins each step by itself, so without the hub nothing new begins. What is under way at the
robot then is its gateway's matter, by its interlocks and link-loss policies.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.hub.alarms.conditions import Truth
from talaia.hub.live.missions.start_check import judge_condition, latched_stop
from talaia.model.interlocks.safe_commands import never_asks
from talaia.model.missions.mission import StepKind
from talaia.model.missions.mission_checks import site_findings
from talaia.wire.browser import PageCommand
from talaia.wire.frames import CommandCancel, CommandPhase

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.clock import Clock
    from talaia.hub.live.missions.mission_line import MissionLine
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.missions.mission_store import RunRecord, StepRecord
    from talaia.model.missions.mission import Mission, MissionStep

__all__ = ["MissionRun", "RunEnd", "step_name"]

# It is looked so often at STOP, the link, the rights and the condition that is waited for (s).
_TICK_S = 0.1
# A step without a limit of its own (s).
_USUAL_S = 3600.0
# After it was cancelled a command has so long to say how it ended (s).
_LAST_WORD_S = 5.0
_GOOD = frozenset({"succeeded"})
# After one of these the next step may be begun, where the step says so. Never after *unknown*.
_PASSABLE = frozenset({"failed", "refused"})
_FINAL = frozenset(
    {
        CommandPhase.SUCCEEDED,
        CommandPhase.FAILED,
        CommandPhase.REFUSED,
        CommandPhase.CANCELLED,
        CommandPhase.UNKNOWN,
    }
)


class RunEnd(NamedTuple):
    """How a run ended, and why in words."""

    state: str
    why: str


class _Ended(Exception):
    """The run is over in the middle of a step."""

    def __init__(self, end: RunEnd) -> None:
        super().__init__(end.why)
        self.end = end


class MissionRun:
    """Does the steps of one mission once.

    Attributes:
        record: how it stands; changed here alone.

    """

    def __init__(
        self,
        live: LiveSite,
        mission: Mission,
        *,
        record: RunRecord,
        line: MissionLine,
        save: Callable[[RunRecord], Awaitable[None]],
        clock: Clock,
    ) -> None:
        """Ask over ``line``; ``save`` writes the record down at each change."""
        self.record = record
        self._live = live
        self._mission = mission
        self._line = line
        self._save = save
        self._clock = clock
        # The very link: a gateway that is back at once is another one, and may have begun anew.
        self._link = live.link
        self._cancelled = ""
        self._paused = False

    def pause_steps(self) -> None:
        """Begin no further step; a command that is under way goes on."""
        self._paused = True
        self.record.state = "paused"

    def resume_steps(self) -> None:
        """Go on with the next step."""
        self._paused = False
        self.record.state = "running"

    def cancel_steps(self, why: str) -> None:
        """End it, and what is under way."""
        self._cancelled = self._cancelled or why

    async def do_steps(self, first: int) -> RunEnd:
        """Do the steps from ``first`` on (counted from 0); give how it ended."""
        for at, step in enumerate(self._mission.steps):
            noted = self.record.steps[at]
            if at < first:
                noted.state = "skipped"
                continue
            try:
                await self._hold_while_paused()
                await self._do_step(at, step, noted)
            except _Ended as ended:
                self._end_step(noted, "cancelled" if noted.state == "running" else noted.state, "")
                return ended.end
            if noted.state not in _GOOD and not (step.goes_on and noted.state in _PASSABLE):
                said = f": {noted.message}" if noted.message else ""
                # Nobody knows what the robot does: that is no failure of the step.
                state = "interrupted" if noted.state == "unknown" else "failed"
                return RunEnd(state, f"step {at + 1}, {noted.name}, {noted.state}{said}")
        return RunEnd("succeeded", "")

    async def _do_step(self, at: int, step: MissionStep, noted: StepRecord) -> None:
        noted.state, noted.began_us = "running", self._now_us()
        noted.command = f"mission-{self.record.id}.{at + 1}" if step.command else ""
        # Written down before anything is asked: a hub that ends now knows how far it had got.
        await self._save(self.record)
        self._look_for_obstacles()
        if step.kind is StepKind.COMMAND:
            await self._do_command(step, noted)
        elif step.kind is StepKind.UNTIL:
            await self._wait_until(step, noted)
        else:
            await self._tick_for(step.seconds, lambda: False)
            self._end_step(noted, "succeeded", "")
        await self._save(self.record)

    async def _do_command(self, step: MissionStep, noted: StepRecord) -> None:
        # The description may have changed since the run began.
        for finding in site_findings(self._mission, self._live.description):
            self._end_step(noted, "refused", str(finding))
            return
        asked = PageCommand(
            site=self._live.name,
            device=step.device,
            command=step.command,
            id=noted.command,
            args=step.args,
            units=step.units,
        )
        if problem := self._line.request_command(asked):
            self._end_step(noted, "refused", problem)
            return
        try:
            ended = await self._tick_for(step.seconds or _USUAL_S, self._command_ended, wall=True)
        except _Ended:
            if not self._note_end(noted):
                await self._cancel_command(step, noted)
            raise
        if not ended:
            await self._cancel_command(step, noted)
            self._end_step(noted, "failed", f"not over after {step.seconds or _USUAL_S:g} s")
            return
        self._note_end(noted)

    def _note_end(self, noted: StepRecord) -> bool:
        """Take the robot's word of how its command ended; tell whether there is one."""
        newest = self._line.newest
        if newest is None or newest.phase not in _FINAL:
            return False
        self._end_step(noted, newest.phase.value, newest.message)
        return True

    def _command_ended(self) -> bool:
        return self._line.newest is not None and self._line.newest.phase in _FINAL

    async def _cancel_command(self, step: MissionStep, noted: StepRecord) -> None:
        """Have what is under way ended, and hear how it ended; what makes safe is let be."""
        link = self._live.link
        if link is None or link is not self._link:
            self._end_step(noted, "unknown", "the connection was lost; look at the device")
            return
        if never_asks(self._live.description, step.device, step.command):
            self._end_step(noted, "unknown", "it makes safe, and goes on")
            return
        # To the gateway itself: the account may have lost its rights, and to end needs none.
        link.send(CommandCancel(id=noted.command, device=step.device, who=self._line.signature))
        until_ns = self._clock.monotonic_ns() + round(_LAST_WORD_S * SECOND)
        while not self._command_ended() and self._clock.monotonic_ns() < until_ns:
            # The line may be over already, and then nothing is heard any more.
            if self._line.over:
                break
            await asyncio.sleep(_TICK_S)
        if not self._note_end(noted):
            self._end_step(noted, "unknown", "it was to be cancelled; look at the device")

    async def _wait_until(self, step: MissionStep, noted: StepRecord) -> None:
        said = ""

        def holds() -> bool:
            nonlocal said
            if any(True for _ in site_findings(self._mission, self._live.description)):
                return False
            truth, said = judge_condition(self._live, step.condition, self._clock.monotonic_ns())
            return truth is Truth.HOLDS

        met = await self._tick_for(step.seconds or _USUAL_S, holds)
        why = said if met else f"not so after {step.seconds or _USUAL_S:g} s: {said}"
        self._end_step(noted, "succeeded" if met else "failed", why)

    async def _hold_while_paused(self) -> None:
        while self._paused:
            self._look_for_obstacles()
            await asyncio.sleep(_TICK_S)

    async def _tick_for(
        self, seconds: float, done: Callable[[], bool], *, wall: bool = False
    ) -> bool:
        """Wait until ``done`` or the time is over; tell whether it was done.

        While the run is paused its time stands still, except with ``wall``.

        Raises:
            _Ended: something ended the run meanwhile.

        """
        left_ns = round(seconds * SECOND)
        before = self._clock.monotonic_ns()
        while True:
            self._look_for_obstacles()
            now = self._clock.monotonic_ns()
            if wall or not self._paused:
                if done():
                    return True
                left_ns -= now - before
                if left_ns <= 0:
                    return False
            before = now
            await asyncio.sleep(_TICK_S)

    def _look_for_obstacles(self) -> None:
        """Raise `_Ended` where the run may not go on."""
        if self._cancelled:
            raise _Ended(RunEnd("cancelled", self._cancelled))
        # First of what is not asked for: whoever reads why shall see STOP, not what came of it.
        if stopped := latched_stop(self._live):
            raise _Ended(RunEnd("stopped", stopped))
        if self._live.link is None or self._live.link is not self._link:
            raise _Ended(RunEnd("interrupted", "the connection to its gateway was lost"))
        if self._line.over:
            raise _Ended(RunEnd("interrupted", f"{self.record.who}: {self._line.over}"))

    def _end_step(self, noted: StepRecord, state: str, message: str) -> None:
        if noted.ended_us or not noted.began_us:
            return
        noted.state, noted.message, noted.ended_us = state, message[:500], self._now_us()

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def step_name(step: MissionStep, live: LiveSite) -> str:
    """Give what people call a step."""
    if step.name:
        return step.name
    if step.kind is StepKind.COMMAND:
        device = live.description.devices.get(step.device)
        command = None if device is None else device.commands.get(step.command)
        if device is None or command is None:
            return f"{step.device}/{step.command}"
        return f"{device.name}: {command.name}"
    if step.kind is StepKind.UNTIL:
        return f"until {step.condition}"[:200]
    return f"wait {step.seconds:g} s"
