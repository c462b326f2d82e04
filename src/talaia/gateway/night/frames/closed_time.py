"""What is taken under a closed roof: what requests want, then the own darks. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.frames.dark_frames import DarkFrames
from talaia.gateway.night.roof.roof_steps import first_asks, steps_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightAction, NightView, StepAnswer
    from talaia.gateway.night.observing_run import ObservingRun
    from talaia.gateway.night.request_chooser import RequestChooser
    from talaia.model.night_section import NightSection

__all__ = ["ClosedTime"]


class ClosedTime:
    """See the module.

    Attributes:
        begun: `NightSection.start` was asked for, and its end not yet.

    """

    def __init__(
        self, night: NightSection, chooser: RequestChooser, observing: ObservingRun, *, begun: bool
    ) -> None:
        """Begin a night; requests are served by ``observing``; an earlier run may have begun it."""
        self._night, self._chooser, self._observing = night, chooser, observing
        self._darks = DarkFrames(night)
        self.begun = begun
        # Since then the Sun has been as low as it has to be for an open roof.
        self._was_dark = False

    @property
    def words(self) -> str:
        """Which of the description's darks is taken, for people; empty: none."""
        return self._darks.words

    @property
    def is_busy(self) -> bool:
        """Whether a frame is being taken."""
        return bool(self._darks.words) or self._observing.block is not None

    def pass_time(self, view: NightView) -> None:
        """Take in where the Sun stands."""
        low = view.sun <= self._night.sun.opening
        self._was_dark = self.begun and (self._was_dark or low)

    def is_over(self, view: NightView) -> bool:
        """Tell whether what cools may warm: by day, or in the morning's twilight."""
        sun = self._night.sun
        morning = view.sun > sun.closing and self._was_dark
        return self.begun and (morning or view.sun > sun.calibrating)

    def end_night(self, view: NightView, next_id: Callable[[], str]) -> list[NightAction]:
        """Let warm what cools; the description's darks are taken anew in the next night."""
        self.begun = self._was_dark = False
        self._darks = DarkFrames(self._night)
        return first_asks(steps_of(self._night.end, "ending the night"), view, next_id)

    def end_dark(self) -> None:
        """Leave the dark under way: what comes next aborts it, or needs nothing of the camera."""
        self._darks.end_frame()

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command ended."""
        self._darks.take_answer(answer)

    def has_requests(self, view: NightView) -> bool:
        """Tell whether a request waits for frames that need no sky, or they are being taken."""
        if self._observing.block is not None:
            return True
        return self._chooser.calibration(view, flats=False) is not None

    def update_frames(self, view: NightView, next_id: Callable[[], str]) -> list[NightAction]:
        """Go on; give what is to be asked and told now."""
        asked = not self._darks.words and self.has_requests(view)
        if not asked and (self._night.darks is None or self._chooser.thinks):
            # One that is under way has its end all the same.
            return list(self._darks.update_darks(view, next_id)) if self._darks.words else []
        actions: list[NightAction] = []
        if not self.begun:
            # Darks of a warm chip are worth nothing.
            self.begun = True
            actions += first_asks(steps_of(self._night.start, "getting ready"), view, next_id)
        if asked:
            return actions + self._observing.update_indoors(view, next_id)
        return [*actions, *self._darks.update_darks(view, next_id)]
