"""Brings telescope and roof to rest, and goes on until both are. Pure.

What is told to park while nothing has power does not park, and the roof may close all the same:
then it parks as soon as it can.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.night_values import NightEvent
from talaia.gateway.night.roof.roof_steps import closing_steps, parking_steps
from talaia.gateway.night.step_runner import StepRunner, StepsState

if TYPE_CHECKING:
    from collections.abc import Callable, Set

    from talaia.gateway.night.night_values import NightAction, NightView, StepAnswer
    from talaia.model.interlocks.enclosure import Enclosure
    from talaia.model.night_section import NightSection

__all__ = ["NOT_PARKED", "ComingToRest"]

NOT_PARKED = "the roof is closed, but the telescope is not parked"
# Behind that it is asked to park so often (s), and people have been told.
PARK_AGAIN_S = 60.0


class ComingToRest:
    """See the module."""

    def __init__(self, night: NightSection, roof: Enclosure, next_id: Callable[[], str]) -> None:
        """Have nothing to do yet."""
        self._night, self._roof, self._next_id = night, roof, next_id
        self._steps: StepRunner | None = None
        # All was gone through once more, since the roof closed without a parked telescope.
        self._again = False
        # When a telescope that stands under a closed roof is asked to park next (monotonic, s).
        self._park_at = 0.0

    def begin_rest(self) -> None:
        """Begin anew."""
        self._steps, self._again = None, False

    @property
    def words(self) -> str:
        """What is done now, for people."""
        return self._steps.words if self._steps is not None else ""

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command ended."""
        if self._steps is not None:
            self._steps.take_answer(answer)

    def update_rest(self, view: NightView, under_way: Set[str]) -> tuple[bool, list[NightAction]]:
        """Go on; tell whether the roof is closed now, and give what is to be asked and told.

        While a command ``under_way`` may still open or unpark, no sensor says that all is at rest.
        """
        if self._steps is None:
            opens = self._night.open.command in under_way
            unparks = self._night.unpark.command in under_way
            steps = closing_steps(self._roof, opens=opens, unparks=unparks)
            self._steps = StepRunner(steps, self._next_id)
        actions: list[NightAction] = [*self._steps.update_steps(view)]
        if self._steps.state is StepsState.RUNNING:
            return False, actions
        state, why, self._steps = self._steps.state, self._steps.why, None
        if state is not StepsState.DONE or view.closed is not True:
            # It goes on until the sensors say closed; the event calls somebody meanwhile.
            return False, [
                *actions,
                NightEvent("night_not_closed", why or "not closed", good=False),
            ]
        if view.parked is True:
            return True, actions
        if not self._again:
            # Whatever kept it from parking may be over since it was asked.
            self._again = True
            return False, actions
        self._park_at = view.now + PARK_AGAIN_S
        return True, [*actions, NightEvent("night_not_parked", NOT_PARKED, good=False)]

    def keep_parking(self, view: NightView) -> tuple[bool, list[NightAction]]:
        """Ask a telescope under a closed roof to park, as long as it does not and nobody acts.

        Gives whether it is at rest, or in the hands of whoever opened the roof; and what to ask.
        """
        if view.parked is True or (view.person and view.closed is False):
            return True, []
        if view.person or view.closed is not True:
            self._steps = None
            return False, []
        if self._steps is None:
            if view.now < self._park_at:
                return False, []
            self._steps = StepRunner(parking_steps(self._roof, asks_first=False), self._next_id)
        actions: list[NightAction] = [*self._steps.update_steps(view)]
        if self._steps.state is not StepsState.RUNNING:
            self._steps, self._park_at = None, view.now + PARK_AGAIN_S
        return False, actions
