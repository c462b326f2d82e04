"""Opens an observatory: roof, then telescope, or both at once where the roof clears it. Pure.

Where the description says that the telescope need not be parked before the roof moves (`order` of
the enclosure), it is unparked and sent to its first target while the roof still opens: after rain
that is the time of a slew. Where it does not, nothing moves below a roof that is not open. What the
roof need not wait for (a cooler, and filter, binning and gain of the first frame) gets ready beside
it, and is ready before anything is observed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from talaia.gateway.night.frames.calibration_choice import is_of_flats
from talaia.gateway.night.frames.frame_settings import FrameSettings
from talaia.gateway.night.roof.roof_steps import (
    GETTING_READY,
    OPENING,
    UNPARKING,
    opening_steps,
    steps_beside,
    unparking_step,
)
from talaia.gateway.night.step_runner import NightStep, StepRunner, StepsState
from talaia.gateway.night.target_place import place_of_date
from talaia.model.interlocks.enclosure import ClosingOrder
from talaia.model.observing.targets import FixedTarget

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightCommand, NightView, PartRun, StepAnswer
    from talaia.model.interlocks.enclosure import Enclosure, Place
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import Request

__all__ = ["OpeningRun"]


class OpeningRun:
    """See the module; looked at and answered as one row of steps is."""

    def __init__(
        self,
        night: NightSection,
        enclosure: Enclosure,
        place: Place,
        next_id: Callable[[], str],
        *,
        first: Request,
    ) -> None:
        """Begin with the next `update_steps`.

        Args:
            night: the description's section.
            enclosure: the roof.
            place: where it is.
            next_id: of commands.
            first: what is observed first, as far as is known now.

        """
        self._night, self._place, self._next_id = night, place, next_id
        # Chosen before it opens; the block behind it is chosen anew, and mostly the same.
        self._target = first.target
        at_once = enclosure.order is not ClosingOrder.MOUNT_FIRST
        steps = opening_steps(night)
        beside = [*steps_beside(night), *_settings_ahead(night, first)]
        self._beside = StepRunner(beside, next_id)
        # Unparking is the last of them.
        self._roof = StepRunner(steps[:-1] if at_once else steps, next_id)
        self._mount = StepRunner([unparking_step(night)] if at_once else [], next_id)
        self._ahead: StepRunner | None = None
        # The roof is open, and what was refused before may be let now.
        self._at_once, self._waited = at_once, not at_once

    @property
    def words(self) -> str:
        """What is done now, for people."""
        ahead = self._ahead.words if self._ahead else ""
        return self._roof.words or self._mount.words or ahead or self._beside.words

    @property
    def state(self) -> StepsState:
        """How it stands; what goes ahead of the first block fails nothing."""
        if self._roof.state is not StepsState.DONE:
            return self._roof.state
        if self._mount.state is not StepsState.DONE:
            return self._mount.state if self._waited else StepsState.RUNNING
        ahead = self._ahead
        busy = ahead is not None and ahead.state is StepsState.RUNNING
        # None of it is required: it ends, well or not.
        busy = busy or self._beside.state is StepsState.RUNNING
        return StepsState.RUNNING if busy else StepsState.DONE

    @property
    def why(self) -> str:
        """Why it failed or was refused."""
        return self._roof.why or self._mount.why

    @property
    def roof_is_open(self) -> bool:
        """Whether it has been seen open: what its sensors say from then on counts."""
        # With one row for both, what comes behind the roof is the telescope's last step.
        roof = self._roof
        return roof.state is StepsState.DONE or roof.words == UNPARKING

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command ended."""
        for runner in (self._roof, self._beside, self._mount, self._ahead):
            if runner is not None:
                runner.take_answer(answer)

    def update_steps(self, view: NightView) -> list[NightCommand | PartRun]:
        """Go on; give what is to be asked now."""
        # In the order of the description: not before what the roof waits for.
        begins = self._roof.words != GETTING_READY
        asked = self._beside.update_steps(view) if begins else []
        asked += self._roof.update_steps(view)
        if not self._at_once or self._roof.state in {StepsState.FAILED, StepsState.REFUSED}:
            return asked
        # Not before the roof was asked for: what gets ready first (a cooler) is still under way.
        if self._roof.words != OPENING and self._roof.state is not StepsState.DONE:
            return asked
        if view.opened is None and view.closed is None:
            # Under a roof of which nobody knows anything a telescope stays where it is.
            return asked
        is_open = self._roof.state is StepsState.DONE
        if is_open and not self._waited:
            self._waited = True
            if self._mount.state in {StepsState.FAILED, StepsState.REFUSED}:
                # An interlock may want the roof open first: then as with any other roof.
                self._mount = StepRunner([unparking_step(self._night)], self._next_id)
        asked += self._mount.update_steps(view)
        if self._mount.state is StepsState.DONE:
            if self._ahead is None:
                self._ahead = StepRunner(self._slew_ahead(view), self._next_id)
            asked += self._ahead.update_steps(view)
        return asked

    def _slew_ahead(self, view: NightView) -> list[NightStep]:
        """Give the way to the first target; its block slews again, which then is short."""
        target = self._target
        if target is None or isinstance(target, FixedTarget):
            return []
        # A roof that is open already leaves nothing to be ahead of.
        if self._roof.state is StepsState.DONE:
            return []
        where = place_of_date(target, view.time, self._place)
        if where is None:
            return []
        slew, times = self._night.slew, self._night.times
        return [
            NightStep(
                words="slewing while the roof opens",
                command=slew.command,
                args={slew.ra: where[0], slew.dec: where[1]},
                within=180.0 / times.slew_rate + 120.0,
                required=False,
            )
        ]


def _settings_ahead(night: NightSection, first: Request) -> list[NightStep]:
    """Give what the first frame wants set; its block asks again, which then takes no time."""
    if is_of_flats(first):
        return []
    settings = FrameSettings(night).steps_for(first.configurations[0], night.light)
    return [replace(step, tries=1, required=False) for step in settings]
