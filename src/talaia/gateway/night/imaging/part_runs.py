"""Runs the parts of a block that look at stars, each within its bound. Event loop only."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.night.block_run import BlockParts
from talaia.gateway.night.imaging.star_parts import AbsentPart, FieldCentre, PartOutcome
from talaia.gateway.night.night_values import StepAnswer
from talaia.gateway.night.planning.planner_question import FocusNews
from talaia.model.observing.states import ObservationState
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.night.imaging.frame_reckoner import FrameReckoner
    from talaia.gateway.night.imaging.star_parts import (
        AutoFocuser,
        AutoGuider,
        PlateSolver,
    )
    from talaia.gateway.night.night_values import ObservationChange, PartRun
    from talaia.gateway.ports import EventSink

__all__ = ["PartRuns"]

log = logging.getLogger(__name__)
_ABSENT = AbsentPart()
# Of a part's bound, so that its own words come before the executor's.
_OF_BOUND = 0.95
_END_GUIDING_S = 30.0
_MEASURE_S = 60.0
# What the air was like longer ago says nothing of now (s). Then nobody knows, and what was held
# back by it is tried, and measured, again.
_SEEING_KEPT_S = 3600.0


class PartRuns:
    """See the module. One part at a time: a new one ends the one before.

    Attributes:
        reckoner: where pictures are reckoned.

    """

    def __init__(
        self,
        *,
        clock: Clock,
        events: EventSink,
        reckoner: FrameReckoner,
        guider: AutoGuider | None = None,
    ) -> None:
        """Take what there is; ``reckoner`` is ended where a part hangs."""
        self._clock, self._events, self.reckoner = clock, events, reckoner
        self._focuser: AutoFocuser = _ABSENT
        self._solver: PlateSolver = _ABSENT
        self._guider: AutoGuider = guider if guider is not None else _ABSENT
        self._temperature: Callable[[], float | None] = lambda: None
        self._meter: Callable[[bytes], float | None] | None = None
        self._task: asyncio.Task[None] | None = None
        self._ending: asyncio.Task[None] | None = None
        self._guides = False
        # FWHM (″) of the last field that was centred, and when (s, monotonic).
        self._seeing: tuple[float, float] | None = None
        # What was last wrong with each part: said once.
        self._problems: dict[str, str] = {}

    def add_focuser(self, focuser: AutoFocuser, temperature: Callable[[], float | None]) -> None:
        """Focus by this; ``temperature`` of the tube (°C) says when, too."""
        self._focuser, self._temperature = focuser, temperature

    def add_solver(self, solver: PlateSolver) -> None:
        """Centre by this."""
        self._solver = solver

    def add_level_meter(self, meter: Callable[[bytes], float | None]) -> None:
        """Measure flats by this, which gives a file's median (counts); in the reckoner."""
        self._meter = meter

    async def measure_level(self, data: bytes) -> float | None:
        """Give a flat's median (counts); none where its file tells none in time."""
        if self._meter is None:
            return None
        loop = asyncio.get_running_loop()
        try:
            async with asyncio.timeout(_MEASURE_S):
                return await loop.run_in_executor(self.reckoner, self._meter, data)
        except (TimeoutError, OSError, RuntimeError, ValueError, ArithmeticError) as error:
            self.reckoner.end_process()
            self._report_outcome("flat", PartOutcome(good=False, message=f"not measured: {error}"))
            return None

    def block_parts(self) -> BlockParts:
        """Tell which parts blocks have."""

        def focus_due(name: str, _time: float) -> bool:
            now = self._clock.monotonic_ns() / SECOND
            return self._focuser.is_due(name, self._temperature(), now)

        return BlockParts(
            solves=self._solver.present,
            guides=self._guider.present,
            focus_due=focus_due if self._focuser.present else None,
            guide_lost=self._guider.lost_reason,
        )

    def focus_news(self, now: float) -> FocusNews | None:
        """Tell the planner of the last focus run and of the next; none: there was none yet.

        ``now`` is in s since the epoch (UTC).
        """
        seen = self._focuser.outlook(self._temperature(), self._clock.monotonic_ns() / SECOND)
        if seen is None:
            return None
        # To the minute: the same question is answered in the same way.
        at = round((now - seen.ago) / 60.0) * 60.0
        return FocusNews(filter=seen.filter_name, at=at, every=seen.every, again=seen.again)

    def latest_seeing(self) -> float | None:
        """Give the FWHM of the last field that was centred (″); none: not within the hour."""
        if self._seeing is None:
            return None
        fwhm, measured_at = self._seeing
        old = self._clock.monotonic_ns() / SECOND - measured_at
        return fwhm if old <= _SEEING_KEPT_S else None

    def begin_part(self, run: PartRun, answered: Callable[[StepAnswer], None]) -> None:
        """Begin a part; ``answered`` is told how it ended, unless it is broken off."""
        self.break_off()
        self._task = asyncio.create_task(self._run_part(run, answered), name=f"night {run.part}")

    def break_off(self) -> None:
        """End what runs, without an answer: the night has gone on to something else."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def follow_change(self, change: ObservationChange) -> None:
        """End what a block began, where it is over or interrupted."""
        if change.state is not ObservationState.IN_PROGRESS:
            self.end_block()

    def end_block(self) -> None:
        """End all that a block began; a star is held no longer."""
        self.break_off()
        if self._guides:
            self._guides = False
            self._ending = asyncio.create_task(self._end_guiding(), name="night unguide")

    async def _run_part(self, run: PartRun, answered: Callable[[StepAnswer], None]) -> None:
        try:
            async with asyncio.timeout(run.within * _OF_BOUND):
                outcome = await self._perform(run)
        except TimeoutError:
            # What is reckoned may hang as well: the next run is not to wait behind it.
            self.reckoner.end_process()
            outcome = PartOutcome(good=False, message=f"no end after {run.within:g} s")
        except (OSError, RuntimeError, ValueError, ArithmeticError) as error:
            # Among them a process that died.
            self.reckoner.end_process()
            log.warning("night: %s failed", run.part, exc_info=error)
            outcome = PartOutcome(good=False, message=str(error) or type(error).__name__)
        if outcome.seeing is not None:
            self._seeing = outcome.seeing, self._clock.monotonic_ns() / SECOND
        self._report_outcome(run.part, outcome)
        phase = CommandPhase.SUCCEEDED if outcome.good else CommandPhase.FAILED
        answered(StepAnswer(run.id, phase, outcome.message, outcome.place))

    async def _perform(self, run: PartRun) -> PartOutcome:
        match run.part:
            case "focus":
                return await self._focuser.run_focus(run.filter)
            case "centre":
                return await self._solver.centre_field(
                    FieldCentre(run.ra, run.dec, filter=run.filter)
                )
            case "guide":
                self._guides = self._guider.present
                return await self._guider.begin_guiding()
            case "dither":
                return await self._guider.dither_star(run.dither)
            case "unguide":
                self._guides = False
                return await self._guider.end_guiding()
            case _:
                return PartOutcome(good=False, message=f"there is no {run.part}")

    def _report_outcome(self, part: str, outcome: PartOutcome) -> None:
        if outcome.good:
            self._problems.pop(part, None)
            log.info("night: %s: %s", part, outcome.message or "done")
        elif self._problems.get(part) != outcome.message:
            self._problems[part] = outcome.message
            self._events.report_event("night_part_failed", f"{part}: {outcome.message}", good=False)

    async def _end_guiding(self) -> None:
        try:
            async with asyncio.timeout(_END_GUIDING_S):
                self._report_outcome("unguide", await self._guider.end_guiding())
        except (OSError, TimeoutError) as error:
            self._report_outcome("unguide", PartOutcome(good=False, message=str(error)))

    async def close(self) -> None:
        """End all of it."""
        running = [task for task in (self._task, self._ending) if task is not None]
        self.end_block()
        if self._ending is not None:
            running.append(self._ending)
        await asyncio.gather(*running, return_exceptions=True)
        self.reckoner.end_process()
