"""Steps one after the other, each in bounded time and tried a bounded number of times. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

from talaia.gateway.night.night_values import NightCommand, PartRun
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from talaia.gateway.night.night_values import NightView, StepAnswer
    from talaia.wire.frames import Scalar

__all__ = ["NightStep", "StepRunner", "StepsState"]

# Between two tries of one step (s).
AGAIN_S = 2.0


class StepsState(StrEnum):
    """How a row of steps stands."""

    RUNNING = "running"
    DONE = "done"
    # A device did not do it.
    FAILED = "failed"
    # It was not let: an interlock, or somebody who acts. No failure.
    REFUSED = "refused"


@dataclass(frozen=True, kw_only=True)
class NightStep:
    """One thing to do.

    Attributes:
        words: what is done, for people.
        command: ``<device>/<command>``; empty: nothing is asked, only waited for.
        args: of the command.
        is_frame: the command takes a frame of a request.
        wants_level: that frame is measured; see `NightCommand`.
        part: runs instead of a command; its id is filled in.
        within: one try takes at most so long (s).
        tries: so often in all.
        required: without it the steps behind are not done.
        insists: what refuses it is asked again, too: what makes safe.
        reached: sensors show that it is done; then nothing is asked. None: the answer says it.
        asks_first: it is asked whatever sensors show, and done when its answer says so, too: an
            earlier command may be about to undo what they show.
        wait: so long it takes at least (s), after its answer.
        on_done: called once, when it is done.

    """

    words: str
    command: str = ""
    args: Mapping[str, Scalar] = field(default_factory=dict)
    is_frame: bool = False
    wants_level: bool = False
    part: PartRun | None = None
    within: float = 60.0
    tries: int = 1
    required: bool = True
    insists: bool = False
    reached: Callable[[NightView], bool] | None = None
    asks_first: bool = False
    wait: float = 0.0
    on_done: Callable[[], None] | None = None


class StepRunner:
    """Does steps in order.

    Attributes:
        state: how it stands.
        why: why it failed or was refused.

    """

    def __init__(self, steps: Sequence[NightStep], next_id: Callable[[], str]) -> None:
        """Begin with the first at the next `update_steps`."""
        self.state = StepsState.RUNNING if steps else StepsState.DONE
        self.why = ""
        self._steps, self._next_id = list(steps), next_id
        self._index, self._tried = 0, 0
        # Of the try that is under way; empty: none.
        self._asked = ""
        self._deadline = 0.0
        # When the next try may begin, and until when the step only waits.
        self._again_at = 0.0
        self._rests_until: float | None = None
        self._answered: StepAnswer | None = None

    @property
    def words(self) -> str:
        """What is done now, for people."""
        return self._steps[self._index].words if self.state is StepsState.RUNNING else ""

    @property
    def takes_frame(self) -> bool:
        """Whether a frame of a request is being taken now."""
        running = self.state is StepsState.RUNNING and self._asked != ""
        return running and self._steps[self._index].is_frame

    def is_waiting_for(self, step_id: str) -> bool:
        """Tell whether an answer would be one to this."""
        return step_id != "" and step_id == self._asked

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command or part ended; one to an earlier try is passed over."""
        if self.is_waiting_for(answer.id) and self._answered is None:
            self._answered = answer

    def update_steps(self, view: NightView) -> list[NightCommand | PartRun]:
        """Go on; give what is to be asked now."""
        # Bounded: two turns end a step, or one nothing.
        for _ in range(2 * len(self._steps) + 1):
            if self.state is not StepsState.RUNNING:
                return []
            step = self._steps[self._index]
            if self._rests_until is not None:
                if view.now < self._rests_until:
                    return []
                self._finish_step(step)
                continue
            if self._has_reached(step, view):
                self._rests_until = view.now + step.wait
                continue
            if not self._asked:
                return self._begin_try(step, view)
            if not self._judge_try(step, view):
                return []
        return []

    def _has_reached(self, step: NightStep, view: NightView) -> bool:
        if step.reached is None or not step.reached(view):
            return False
        answer = self._answered
        done = answer is not None and answer.phase is CommandPhase.SUCCEEDED
        return done or not step.asks_first

    def _begin_try(self, step: NightStep, view: NightView) -> list[NightCommand | PartRun]:
        if view.now < self._again_at:
            return []
        self._tried += 1
        self._asked = self._next_id()
        self._deadline = view.now + step.within
        self._answered = None
        if step.part is not None:
            return [step.part._replace(id=self._asked)]
        if step.command:
            return [
                NightCommand(
                    self._asked,
                    step.command,
                    step.args,
                    step.within,
                    is_frame=step.is_frame,
                    wants_level=step.wants_level,
                )
            ]
        # Nothing is asked: what is waited for is its time, or a sensor.
        if step.reached is None:
            self._rests_until = view.now + step.wait
        return []

    def _judge_try(self, step: NightStep, view: NightView) -> bool:
        """Look at the try under way; tell whether the step may be looked at again at once."""
        answer = self._answered
        if answer is not None and answer.phase is CommandPhase.SUCCEEDED:
            if step.reached is None:
                self._rests_until = view.now + step.wait
                return True
            why = f"{step.words}: done by its own word, but its sensors do not show it"
        elif answer is not None and answer.phase is CommandPhase.REFUSED:
            self._end_try(step, view, StepsState.REFUSED, answer.message)
            return True
        elif answer is not None and not (answer.phase is CommandPhase.UNKNOWN and step.reached):
            self._end_try(step, view, StepsState.FAILED, answer.message or str(answer.phase))
            return True
        else:
            why = f"{step.words} took longer than {step.within:g} s"
        # Sensors may still show it.
        if view.now < self._deadline:
            return False
        self._end_try(step, view, StepsState.FAILED, why)
        return True

    def _end_try(self, step: NightStep, view: NightView, state: StepsState, why: str) -> None:
        unknown = self._answered is not None and self._answered.phase is CommandPhase.UNKNOWN
        self._asked, self._answered = "", None
        again = self._tried < step.tries and (state is StepsState.FAILED or step.insists)
        # What nobody knows the end of is not simply done once more, but where sensors tell.
        if again and not (unknown and step.reached is None and not step.insists):
            self._again_at = view.now + AGAIN_S
            return
        if not step.required:
            self._finish_step(step, done=False)
            return
        self.state, self.why = state, f"{step.words}: {why}" if step.words not in why else why

    def _finish_step(self, step: NightStep, *, done: bool = True) -> None:
        if done and step.on_done is not None:
            step.on_done()
        self._asked, self._answered, self._rests_until = "", None, None
        self._tried, self._again_at = 0, 0.0
        self._index += 1
        if self._index == len(self._steps):
            self.state = StepsState.DONE
