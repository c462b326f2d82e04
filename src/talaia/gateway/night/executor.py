"""Runs a night: opens when it may, observes what is chosen, closes and parks. Pure.

It knows no clock and no socket: `update_night` takes how things stand, and gives what to ask.
What keeps the roof safe is not here. Interlocks and the roof's guard decide and act without it; the
executor asks for its commands as a person does, and what refuses a person refuses it.

Long, because every phase of a night and what leads from one to another stands in one place.
"""

from __future__ import annotations

import itertools
from functools import partial
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.gateway.night.arming import NightArming
from talaia.gateway.night.frames.closed_time import ClosedTime
from talaia.gateway.night.night_summary import NightReport
from talaia.gateway.night.night_values import NightAction, NightEvent
from talaia.gateway.night.observing_run import ObservingRun
from talaia.gateway.night.request_chooser import RequestChooser
from talaia.gateway.night.roof.coming_to_rest import NOT_PARKED, ComingToRest
from talaia.gateway.night.roof.opening_run import OpeningRun
from talaia.gateway.night.roof.roof_steps import (
    abort_commands,
    leave_reason,
)
from talaia.gateway.night.roof.unended_commands import GUARD_S, UnendedCommands
from talaia.gateway.night.step_runner import StepsState
from talaia.model.observing.states import SuspensionCause
from talaia.wire.frames import NightPhase, NightState

if TYPE_CHECKING:
    from talaia.gateway.night.block_run import BlockParts
    from talaia.gateway.night.frames.stepwise_block import StepwiseBlock
    from talaia.gateway.night.night_values import NightView, StepAnswer
    from talaia.gateway.night.simple_dispatch import AskedRequest
    from talaia.model.interlocks.enclosure import Enclosure, Place
    from talaia.model.night_section import NightSection

__all__ = ["NightExecutor"]

# Nothing is to be observed for so long: the roof closes until then (s).
IDLE_CLOSE_S = 1800.0
_P = NightPhase


class NightExecutor:
    """See the module.

    Attributes:
        phase: what it does.
        why: why it waits, is closed or failed.
        arming: who has armed it.
        chooser: chooses what is observed next; takes what is asked, and what the planner answers.

    """

    def __init__(
        self,
        *,
        night: NightSection,
        enclosure: Enclosure,
        place: Place,
        parts: BlockParts,
        id_prefix: str = "night",
        arming: NightArming | None = None,
    ) -> None:
        """Begin disarmed, or armed as an earlier run was; then everything is brought to rest first.

        Args:
            night: the description's section.
            enclosure: the roof.
            place: where it is.
            parts: what looks at stars.
            id_prefix: of the commands' ids, which are never used twice.
            arming: of an earlier run.

        """
        self._night, self._roof = night, enclosure
        self.arming = arming if arming is not None else NightArming()
        self.phase, self.why = _phase_at_rest(self.arming), ""
        # When this phase began; unknown until the first step tells the time.
        self._since: float | None = None
        self._next_id = map(f"{id_prefix}-{{}}".format, itertools.count(1)).__next__
        # Into which phase parking leads.
        self._after_parking = _phase_at_rest(self.arming)
        if self.arming.armed_by or self.arming.opened:
            # What an earlier run left open is closed before anything else.
            self.phase, self.why = _P.PARKING, "the gateway has just been started"
        self.why = self.arming.fault or self.why
        # Of opening, while it goes on.
        self._steps: OpeningRun | None = None
        # The way back to a parked telescope under a closed roof, from wherever it is.
        self._rest = ComingToRest(night, enclosure, self._next_id)
        self.chooser = RequestChooser(night, place)
        self._observing = ObservingRun(
            night=night, enclosure=enclosure, place=place, parts=parts, chooser=self.chooser
        )
        # Darks and bias frames, while the roof is closed.
        self._indoors = ClosedTime(
            night, self.chooser, self._observing, begun=bool(self.arming.armed_by)
        )
        # Since when the roof should be closed and is not certainly so (monotonic, s).
        self._closed_since: float | None = None
        self._make_opening = partial(OpeningRun, night, enclosure, place, self._next_id)
        # An opening or an unparking whose end nobody heard may still be under way.
        self._undoing = UnendedCommands({night.open.command, night.unpark.command})
        # Of the present step; whoever steps takes them all.
        self._actions: list[NightAction] = []
        self._report = NightReport(night)

    # ── what comes from outside ──

    def arm_night(self, who: str, until: float, view: NightView) -> str:
        """Let it run by itself; gives why not, if so."""
        if until and until <= view.time:
            return "that time is over"
        self._change_arming(NightArming(armed_by=who, until=until))
        self._observing.forget_failures()
        if self.phase in {_P.DISARMED, _P.FAULT}:
            self._move(view, _P.WAITING, "")
        elif self.phase is _P.PARKING:
            self._after_parking = _P.WAITING
        return ""

    def disarm_night(self, why: str, view: NightView) -> None:
        """End it: what is under way is interrupted, telescope and roof come to rest."""
        self._change_arming(NightArming())
        if self.phase in {_P.DISARMED, _P.FAULT}:
            self._move(view, _P.DISARMED, why)
            return
        self._suspend(view, SuspensionCause.PERSON, why)
        self._park(view, _P.DISARMED, why)

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command or a part ended."""
        if self._steps is not None:
            self._steps.take_answer(answer)
        self._rest.take_answer(answer)
        self._undoing.take_answer(answer)
        self._observing.take_answer(answer)
        self._indoors.take_answer(answer)

    def night_state(self) -> NightState:
        """Give how it stands, as the hub is told."""
        step = self._steps.words if self._steps is not None else self._rest.words
        step = step or self._indoors.words
        state = NightState(phase=self.phase, why=self.why[:2000], step=step)
        return _with_block(state, self._since or 0.0, self.arming, self._observing.block)

    # ── time goes on ──

    def update_night(self, view: NightView) -> list[NightAction]:
        """Go on; give what is to be asked and told now."""
        self._since = view.time if self._since is None else self._since
        phase, before = self.phase, self._observing.block
        self._act(view)
        block = self._observing.block or before
        self._actions += self._report.pass_time(
            view,
            self._actions,
            request=block.request if block is not None else None,
            is_armed=bool(self.arming.armed_by),
            phases=(phase, self.phase),
        )
        actions, self._actions = self._actions, []
        self._undoing.add_asked(actions, view.now)
        return actions

    def _act(self, view: NightView) -> None:
        if self.arming.armed_by and not self.arming.holds_at(view.time):
            why = "the time that it was armed for is over"
            self._actions.append(NightEvent("night_disarmed", why))
            self.disarm_night(why, view)
        self._indoors.pass_time(view)
        match self.phase:
            case _P.DISARMED | _P.FAULT:
                self._stay_at_rest(view)
            case _P.PARKING:
                self._go_on_parking(view)
            case _P.WAITING | _P.CLOSED | _P.CALIBRATING:
                self._stay_closed(view)
            case _P.OPENING | _P.OBSERVING:
                if not self._must_close(view):
                    self._go_on_open(view)

    def _must_close(self, view: NightView) -> bool:
        """Leave an open roof where anything forbids it; tell whether that is so."""
        leave = leave_reason(view, self._night.sun.closing, opening=self._steps)
        if leave is None:
            return False
        self._suspend(view, leave.cause, leave.why)
        if leave.disarms:
            self._change_arming(NightArming())
            self._actions.append(NightEvent("night_disarmed", leave.why, good=False))
        if leave.after is None:
            self._move(view, _P.CLOSED, leave.why)
            self._closed_since = view.now
        else:
            self._park(view, leave.after, leave.why)
        return True

    # ── closed ──

    def _stay_closed(self, view: NightView) -> None:
        if view.closed is not True or view.parked is not True:
            self._come_to_rest(view)
            return
        self._closed_since = None
        if view.sun > self._night.sun.opening:
            self._pass_twilight(view, f"the Sun stands at {view.sun:.0f}°")
        elif why := view.closing or view.barred:
            self._calibrate(view, _P.CLOSED, why)
        elif view.person:
            self._leave_calibrations(view, f"{view.person} is at work")
            self._move(view, _P.WAITING, f"{view.person} is at work")
        elif (first := self._next_request(view)) is None:
            self._calibrate(view, _P.WAITING, "nothing may be observed now")
        else:
            # Re-planned first: there is something to open for.
            if self._indoors.words:
                self._indoors.end_dark()
                self._actions += abort_commands(self._roof, view, self._next_id)
            self._suspend(view, SuspensionCause.WEATHER, "the roof opens: the sky comes first")
            self._indoors.begun = True
            self.arming = replace(self.arming, opened=True)
            self._move(view, _P.OPENING, "")
            self._steps = self._make_opening(first=first.request)

    def _pass_twilight(self, view: NightView, why: str) -> None:
        """Let the day pass; while it is not quite day, requests that need no sky are served."""
        sun = self._night.sun
        if view.sun <= sun.calibrating and not view.person and self._indoors.has_requests(view):
            self._indoors.end_dark()
            self._calibrate(view, _P.WAITING, why)
            return
        self._leave_calibrations(view, why)
        if self._indoors.is_over(view):
            self._actions += self._indoors.end_night(view, self._next_id)
        self._move(view, _P.WAITING, why)

    def _come_to_rest(self, view: NightView) -> None:
        """The roof is not certainly closed: its guard closes it, and the night after a while."""
        self._leave_calibrations(view, "the roof is not closed")
        barred = view.closing or view.barred
        if view.person and not barred and view.sun <= self._night.sun.closing:
            self._move(view, _P.WAITING, f"{view.person} is at work")
            return
        if self._closed_since is None:
            self._closed_since = view.now
        closing_s = self._roof.move_within * (1 + self._roof.retries)
        patience = GUARD_S + self._roof.mount_within + closing_s
        if not view.closing or view.now - self._closed_since > patience:
            self._park(view, self.phase, self.why or "the roof is not closed")

    def _leave_calibrations(self, view: NightView, why: str) -> None:
        """End what is taken under the closed roof; what was read out is kept."""
        self._indoors.end_dark()
        self._suspend(view, SuspensionCause.PERSON if view.person else SuspensionCause.WEATHER, why)

    def _calibrate(self, view: NightView, phase: NightPhase, why: str) -> None:
        """Fill the time with frames that need no sky; without any it is spent in ``phase``."""
        if view.person:
            self._leave_calibrations(view, f"{view.person} is at work")
        else:
            self._actions += self._indoors.update_frames(view, self._next_id)
        if self._observing.fault:
            self._fault(view, self._observing.fault)
        else:
            self._move(view, _P.CALIBRATING if self._indoors.is_busy else phase, why)

    def _next_request(self, view: NightView) -> AskedRequest | None:
        """Give what there is to open for: a target, or a sky for flats."""
        if view.sun > self._night.sun.observing:
            return self.chooser.flats_now(view)
        asked, actions = self.chooser.choose_request(view)
        self._actions += actions
        return asked

    # ── open ──

    def _go_on_open(self, view: NightView) -> None:
        if self._steps is not None:
            self._go_on_opening(view, self._steps)
            return
        self.why = f"{view.person} is at work" if view.person else ""
        if view.person:
            self._suspend(view, SuspensionCause.PERSON, self.why)
            return
        self._actions += self._observing.update_observing(view, self._next_id)
        if self._observing.fault:
            self._fault(view, self._observing.fault)
        elif self._observing.idle_s(view) > IDLE_CLOSE_S:
            self._park(view, _P.WAITING, "nothing may be observed for a while")

    def _go_on_opening(self, view: NightView, steps: OpeningRun) -> None:
        if view.person:
            self._park(view, _P.WAITING, f"{view.person} is at work")
            return
        self._actions += steps.update_steps(view)
        if steps.state is StepsState.DONE:
            self._steps = None
            # What is best now is asked at once: what it opened for was chosen a while ago.
            self.chooser.look_again()
            self._move(view, _P.OBSERVING, "")
            self._go_on_open(view)
        elif steps.state is StepsState.REFUSED:
            # An interlock or somebody: no fault. It is tried again when it may be.
            self._park(view, _P.CLOSED, steps.why)
        elif steps.state is StepsState.FAILED:
            self._fault(view, steps.why)

    def _suspend(self, view: NightView, cause: SuspensionCause, why: str) -> None:
        self._steps = None
        self._actions += self._observing.suspend_block(view, self._next_id, cause=cause, why=why)

    # ── rest ──

    def _stay_at_rest(self, view: NightView) -> None:
        """Do nothing but park a telescope that the night itself has left standing."""
        if self.arming.opened:
            at_rest, actions = self._rest.keep_parking(view)
            self.arming = replace(self.arming, opened=not at_rest)
            self._actions += actions

    def _park(self, view: NightView, after: NightPhase, why: str) -> None:
        self._after_parking, self._steps = after, None
        self._rest.begin_rest()
        self._move(view, _P.PARKING, why)

    def _go_on_parking(self, view: NightView) -> None:
        is_closed, actions = self._rest.update_rest(view, self._undoing.under_way(view.now))
        self._actions += actions
        if is_closed:
            self._finish_parking(view)

    def _finish_parking(self, view: NightView) -> None:
        self._undoing.forget_all()
        if view.parked is True:
            self.arming = replace(self.arming, opened=False)
        elif self._after_parking not in {_P.DISARMED, _P.FAULT}:
            self._after_parking, self.why = _P.FAULT, NOT_PARKED
            self._change_arming(NightArming(fault=NOT_PARKED))
        self._closed_since = None
        if self._after_parking in {_P.DISARMED, _P.FAULT} or view.sun > self._night.sun.closing:
            self._actions += self._indoors.end_night(view, self._next_id)
        self._move(view, self._after_parking, self.why)

    def _fault(self, view: NightView, why: str) -> None:
        """A device failed: it parks, closes, and calls somebody; nothing goes on by itself."""
        self._suspend(view, SuspensionCause.FAULT, why)
        self._change_arming(NightArming(fault=why))
        self._actions.append(NightEvent("night_fault", why, good=False))
        self._park(view, _P.FAULT, why)

    def _change_arming(self, arming: NightArming) -> None:
        """Have it armed otherwise; what is open stays so until it is at rest."""
        self.arming = replace(arming, opened=self.arming.opened)

    def _move(self, view: NightView, phase: NightPhase, why: str) -> None:
        if phase is not self.phase:
            self._since = view.time
        self.phase, self.why = phase, why


def _phase_at_rest(arming: NightArming) -> NightPhase:
    """Give what a night is while nothing of it is open."""
    if arming.fault:
        return _P.FAULT
    return _P.WAITING if arming.armed_by else _P.DISARMED


def _with_block(
    state: NightState, since: float, arming: NightArming, block: StepwiseBlock | None
) -> NightState:
    """Give a state with since when, who has armed it, and what is observed where something is."""
    state = replace(state, since=since, armed_by=arming.armed_by, armed_until=arming.until)
    if block is None:
        return state
    return replace(
        state,
        request=block.request.id,
        step=block.words,
        frames_done=sum(block.frames_done),
        frames=sum(part.count for part in block.request.configurations),
    )
