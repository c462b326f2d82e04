"""Dark frames that fill the time while the roof is closed. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.frames.frame_arguments import frame_arguments
from talaia.gateway.night.step_runner import NightStep, StepRunner, StepsState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightCommand, NightView, PartRun, StepAnswer
    from talaia.model.night_section import NightSection

__all__ = ["DarkFrames"]

# Beyond its exposure and readout (s).
MARGIN_S = 60.0


class DarkFrames:
    """Those of one night; none where the description asks for none."""

    def __init__(self, night: NightSection) -> None:
        """Begin a night."""
        self._times = night.times
        rule = night.darks
        # Exposures that are still to be taken (s).
        self._left = [s for s in rule.exposures for _ in range(rule.count)] if rule else []
        self._frame = rule.command if rule else None
        self._steps: StepRunner | None = None

    @property
    def words(self) -> str:
        """What is taken now, for people; empty: nothing."""
        return self._steps.words if self._steps is not None else ""

    def end_frame(self) -> None:
        """Leave the one under way: what comes next aborts it, or needs nothing of the camera."""
        self._steps = None

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command ended."""
        if self._steps is not None:
            self._steps.take_answer(answer)

    def update_darks(
        self, view: NightView, next_id: Callable[[], str]
    ) -> list[NightCommand | PartRun]:
        """Go on; give what is to be asked now."""
        if self._steps is None:
            if not self._left or self._frame is None or view.person:
                return []
            seconds = self._left[0]
            step = NightStep(
                words=f"dark of {seconds:g} s",
                command=self._frame.command,
                args=frame_arguments(self._frame, seconds, gain=None),
                within=seconds + self._times.readout + MARGIN_S,
            )
            self._steps = StepRunner([step], next_id)
        asked = self._steps.update_steps(view)
        if self._steps.state is not StepsState.RUNNING:
            # One that fails is no reason to try it again and again in this night.
            done = self._steps.state is StepsState.DONE
            self._left = self._left[1:] if done else []
            self._steps = None
        return asked
