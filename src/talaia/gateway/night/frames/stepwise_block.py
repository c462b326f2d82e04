"""What every try at a request has: steps that are made one by one, and frames that count. Pure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from talaia.gateway.night.step_runner import StepRunner, StepsState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightCommand, NightView, PartRun, StepAnswer
    from talaia.gateway.night.step_runner import NightStep
    from talaia.model.observing.requests import Request

__all__ = ["StepwiseBlock"]


class StepwiseBlock(ABC):
    """The base of what is observed or taken for a request.

    Attributes:
        request: what is observed.
        state: how it stands.
        why: why it failed or was refused.
        frames_done: of each configuration, read out.
        began: when it began (monotonic, s).
        spoiled: why it was left before its end, by the sky's own light; empty: it was not.

    """

    def __init__(
        self,
        request: Request,
        frames_done: tuple[int, ...],
        *,
        next_id: Callable[[], str],
        now: float,
    ) -> None:
        """Begin a try; of ``frames_done`` no frame is taken again."""
        self.request, self.began = request, now
        self.state, self.why, self.spoiled = StepsState.RUNNING, "", ""
        count = len(request.configurations)
        self.frames_done = [*frames_done[:count], *([0] * (count - len(frames_done)))]
        self._next_id = next_id
        self._runner = StepRunner([], next_id)

    @property
    def words(self) -> str:
        """What is done now, for people."""
        return self._runner.words

    @property
    def exposes(self) -> bool:
        """Whether a frame is under way."""
        return self._runner.takes_frame

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command or part ended."""
        self._runner.take_answer(answer)

    def lost_frame(self, view: NightView) -> str:
        """Say why the frame under way is worth nothing; empty: nothing is wrong with it."""
        return ""

    def retake_frame(self, why: str) -> None:
        """Give a lost frame up, and begin it again if it may be; the camera is told elsewhere."""
        self.state, self.why = StepsState.FAILED, why

    def update_block(self, view: NightView) -> list[NightCommand | PartRun]:
        """Go on; give what is to be asked now."""
        if self.state is not StepsState.RUNNING:
            return []
        asked = self._runner.update_steps(view)
        # One turn may end a step without asking for anything: then the next one is made at once.
        while not asked and self._runner.state is StepsState.DONE:
            steps = self._next_steps(view)
            if not steps:
                if self.state is StepsState.RUNNING:
                    self.state = StepsState.DONE
                return []
            self._runner = StepRunner(steps, self._next_id)
            asked = self._runner.update_steps(view)
        if self._runner.state in {StepsState.FAILED, StepsState.REFUSED}:
            self.state, self.why = self._runner.state, self._runner.why
        return asked

    @abstractmethod
    def _next_steps(self, view: NightView) -> list[NightStep]:
        """Give what comes next; nothing: it is at its end, or its state says otherwise."""
