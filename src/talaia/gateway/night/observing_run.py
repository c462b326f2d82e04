"""Observes under an open roof: one request after the other, as they are chosen. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.block_run import BlockParts, BlockRun
from talaia.gateway.night.frames.calibration_choice import is_of_flats, needs_no_sky
from talaia.gateway.night.frames.closed_block import ClosedBlock
from talaia.gateway.night.frames.flat_block import FlatBlock
from talaia.gateway.night.night_values import NightAction, ObservationChange
from talaia.gateway.night.request_chooser import LOOK_S
from talaia.gateway.night.roof.roof_steps import abort_commands
from talaia.gateway.night.simple_dispatch import conditions_veto
from talaia.gateway.night.step_runner import StepsState
from talaia.model.observing.requests import Urgency
from talaia.model.observing.states import ObservationState, SuspensionCause

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.frames.stepwise_block import StepwiseBlock
    from talaia.gateway.night.night_values import NightView, StepAnswer
    from talaia.gateway.night.request_chooser import RequestChooser
    from talaia.gateway.night.simple_dispatch import AskedRequest
    from talaia.model.interlocks.enclosure import Enclosure, Place
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import Request

__all__ = ["ObservingRun"]

# What failed is left alone for so long (s).
HOLD_S = 300.0
# Longer than any twilight in which flats are taken (s).
TWILIGHT_S = 3 * 3600.0
_O = ObservationState


class ObservingRun:
    """See the module.

    Attributes:
        block: what is observed; none: nothing.
        fault: why no more is to be tried: several targets failed one after the other.

    """

    def __init__(
        self,
        *,
        night: NightSection,
        enclosure: Enclosure,
        place: Place,
        parts: BlockParts,
        chooser: RequestChooser,
    ) -> None:
        """Begin with nothing under way."""
        self._night, self._roof, self._place, self._parts = night, enclosure, place, parts
        self._chooser = chooser
        self.block: StepwiseBlock | None = None
        self.fault = ""
        self._asked: AskedRequest | None = None
        # A frame was begun in this try.
        self._exposed = False
        # Targets that failed one after the other, with why.
        self._failed: dict[str, str] = {}

    def forget_failures(self) -> None:
        """Begin anew: a person has looked."""
        self._failed.clear()
        self.fault = ""

    def idle_s(self, view: NightView) -> float:
        """Give for how long there will be nothing to observe (s)."""
        return self._chooser.wait_until - view.time if self.block is None else 0.0

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command or a part ended."""
        if self.block is not None:
            self.block.take_answer(answer)

    def update_observing(self, view: NightView, next_id: Callable[[], str]) -> list[NightAction]:
        """Go on; give what is to be asked and told now."""
        actions: list[NightAction] = []
        if self.block is not None:
            rapid, actions = self._rapid_instead(view, self.block)
            if rapid:
                cause = SuspensionCause.RAPID
                return actions + self.suspend_block(view, next_id, cause=cause, why=rapid)
            if why := self._sky_too_bad(view, self.block):
                self._chooser.hold_request(self.block.request.id, view.time + LOOK_S)
                cause = SuspensionCause.WEATHER
                return actions + self.suspend_block(view, next_id, cause=cause, why=why)
        if self.block is None:
            asked, actions = self._chooser.choose_request(view)
            if asked is None:
                return actions
            actions.append(self._begin_block(asked, view, next_id))
        return actions + self._go_on(view, next_id)

    def update_indoors(self, view: NightView, next_id: Callable[[], str]) -> list[NightAction]:
        """Take what requests want of darks and biases; the roof is closed."""
        actions: list[NightAction] = []
        if self.block is None:
            asked = self._chooser.calibration(view, flats=False)
            if asked is None:
                return actions
            actions.append(self._begin_block(asked, view, next_id))
        return actions + self._go_on(view, next_id)

    def _go_on(self, view: NightView, next_id: Callable[[], str]) -> list[NightAction]:
        if self.block is None:
            return []
        if why := self.block.lost_frame(view):
            self.block.retake_frame(why)
            # What is exposed goes on for nothing.
            aborts = abort_commands(self._roof, view, next_id)
            return [*aborts, *self._judge_block(view, self.block)]
        return [*self.block.update_block(view), *self._judge_block(view, self.block)]

    def suspend_block(
        self, view: NightView, next_id: Callable[[], str], *, cause: SuspensionCause, why: str
    ) -> list[NightAction]:
        """Interrupt what is observed: what was read out is kept, and nothing counts as failed."""
        block, self.block, self._asked = self.block, None, None
        if block is None:
            return []
        self._chooser.keep_frames(block.request.id, tuple(block.frames_done))
        self._chooser.look_again()
        actions: list[NightAction] = [_change(block, view, _O.SUSPENDED, cause=cause, why=why)]
        # The exposure under way is worth nothing any more; what parks and closes comes behind it.
        return actions + abort_commands(self._roof, view, next_id)

    def _begin_block(
        self, asked: AskedRequest, view: NightView, next_id: Callable[[], str]
    ) -> NightAction:
        self._asked, self._exposed = asked, False
        self.block = self._make_block(asked.request, view, next_id)
        return _change(self.block, view, _O.IN_PROGRESS)

    def _make_block(
        self, request: Request, view: NightView, next_id: Callable[[], str]
    ) -> StepwiseBlock:
        done, night = self._chooser.frames_done(request.id), self._night
        if needs_no_sky(request):
            return ClosedBlock(request, done, night=night, next_id=next_id, now=view.now)
        if night.flats is not None and is_of_flats(request):
            return FlatBlock(
                request,
                done,
                night=night,
                flats=night.flats,
                place=self._place,
                next_id=next_id,
                now=view.now,
            )
        return BlockRun(
            request=request,
            frames_done=done,
            night=night,
            place=self._place,
            parts=self._parts,
            next_id=next_id,
            now=view.now,
        )

    def _rapid_instead(
        self, view: NightView, block: StepwiseBlock
    ) -> tuple[str, list[NightAction]]:
        """Say what is to be observed at once instead, and what to ask; empty: nothing."""
        if self._asked is None or self._asked.urgency is Urgency.RAPID_RESPONSE:
            return "", []
        rapid, actions = self._chooser.rapid_request(view, block.request.id)
        return f"{rapid.request.id} is urgent" if rapid is not None else "", actions

    def _sky_too_bad(self, view: NightView, block: StepwiseBlock) -> str:
        """Say why its first frame is not worth beginning; empty: it is, or has begun.

        As its field is centred the seeing is known, perhaps for the first time in an hour.
        """
        if self._exposed or not isinstance(block, BlockRun):
            return ""
        self._exposed = block.exposes
        return "" if self._exposed else conditions_veto(block.request.constraints, view)

    def _judge_block(self, view: NightView, block: StepwiseBlock) -> list[NightAction]:
        name, why = block.request.id, block.why
        more = self._chooser.keep_frames(name, tuple(block.frames_done))
        if block.state is StepsState.RUNNING:
            return [_change(block, view, _O.IN_PROGRESS)] if more else []
        self.block = self._asked = None
        self._chooser.look_again()
        if block.state is StepsState.DONE:
            self._failed.clear()
            self._chooser.end_request(name)
            return [_change(block, view, _O.COMPLETED)]
        if block.spoiled:
            # By the sky itself: no fault, and not in this twilight again.
            self._chooser.hold_request(name, view.time + TWILIGHT_S)
            return [_change(block, view, _O.SUSPENDED, cause=SuspensionCause.WEATHER, why=why)]
        if block.state is StepsState.REFUSED:
            # Whoever acts or whatever locks: what is left is planned again.
            self._chooser.hold_request(name, view.time + LOOK_S)
            return [_change(block, view, _O.SUSPENDED, cause=SuspensionCause.PERSON, why=why)]
        self._chooser.hold_request(name, view.time + HOLD_S)
        self._failed[name] = why
        if len(self._failed) >= self._night.failure_limit:
            told = "; ".join(f"{request}: {reason}" for request, reason in self._failed.items())
            self.fault = f"{len(self._failed)} targets failed one after the other: {told}"
        return [_change(block, view, _O.FAILED, why=why)]


def _change(
    block: StepwiseBlock,
    view: NightView,
    state: ObservationState,
    *,
    cause: SuspensionCause | None = None,
    why: str = "",
) -> ObservationChange:
    spent = view.now - block.began
    frames = tuple(block.frames_done)
    return ObservationChange(block.request.id, state, frames, cause, why[:2000], spent)
