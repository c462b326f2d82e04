"""What opens an observatory and what brings it to rest, as steps. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.night.step_runner import NightStep, StepRunner
from talaia.model.observing.states import SuspensionCause
from talaia.wire.frames import NightPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.gateway.night.night_values import NightAction, NightView
    from talaia.gateway.night.roof.opening_run import OpeningRun
    from talaia.model.interlocks.enclosure import Enclosure
    from talaia.model.interlocks.interlock import Step
    from talaia.model.night_section import NightSection

__all__ = [
    "GETTING_READY",
    "OPENING",
    "UNPARKING",
    "LeaveReason",
    "abort_commands",
    "closing_steps",
    "first_asks",
    "leave_reason",
    "opening_steps",
    "parking_steps",
    "steps_beside",
    "steps_of",
    "unparking_step",
]

# Where the description does not say how long a command may take (s).
STEP_S = 120.0
OPENING = "opening the roof"
"""What is done while the roof opens."""
UNPARKING = "unparking the telescope"
GETTING_READY = "getting ready"
_P, _C = NightPhase, SuspensionCause


class LeaveReason(NamedTuple):
    """Why an open roof is left.

    Attributes:
        cause: of the suspension of what is observed.
        why: in words.
        after: the phase after parking and closing; none: the roof's guard closes by itself.
        disarms: the night is over: a person has ended it.

    """

    cause: SuspensionCause
    why: str
    after: NightPhase | None
    disarms: bool = False


def leave_reason(
    view: NightView, closing_sun: float, *, opening: OpeningRun | None
) -> LeaveReason | None:
    """Give what forbids an open roof; while it is ``opening`` its sensors do not count yet."""
    if why := view.closing or view.barred:
        return LeaveReason(_C.WEATHER, why, None)
    if view.sun > closing_sun:
        return LeaveReason(_C.WEATHER, "the Sun rises", _P.WAITING)
    if opening is not None and not opening.roof_is_open:
        return None
    if view.opened is None and view.closed is None:
        return LeaveReason(_C.FAULT, "the roof's sensors say nothing", _P.CLOSED)
    if view.opened is not True:
        # Nothing of the weather has closed it.
        why = f"{view.person or 'somebody'} has closed the roof"
        return LeaveReason(_C.PERSON, why, _P.DISARMED, disarms=True)
    if opening is None and view.parked is None:
        return LeaveReason(_C.FAULT, "nobody knows how the telescope stands", _P.CLOSED)
    return None


def opening_steps(night: NightSection) -> list[NightStep]:
    """Give what leads to an open roof and a telescope that may point."""

    def is_open(view: NightView) -> bool:
        return view.opened is True

    return [
        *steps_of(_split_start(night)[0], GETTING_READY),
        NightStep(
            words=OPENING,
            command=night.open.command,
            args=night.open.args,
            within=night.open.within or STEP_S,
            tries=night.step_tries,
            reached=is_open,
        ),
        unparking_step(night),
    ]


def steps_beside(night: NightSection) -> list[NightStep]:
    """Give what gets ready while the roof opens: nothing behind it needs it (a cooler)."""
    return steps_of(_split_start(night)[1], GETTING_READY)


def _split_start(night: NightSection) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """Give what the roof waits for, and what stands behind the last of that.

    Order counts: power that is needed comes first, and so does all that was written before it.
    """
    needed = [index for index, step in enumerate(night.start) if step.required]
    cut = needed[-1] + 1 if needed else 0
    return night.start[:cut], night.start[cut:]


def unparking_step(night: NightSection) -> NightStep:
    """Give what gets the telescope ready to point."""

    def is_ready(view: NightView) -> bool:
        return view.parked is False

    return NightStep(
        words=UNPARKING,
        command=night.unpark.command,
        args=night.unpark.args,
        within=night.unpark.within or STEP_S,
        tries=night.step_tries,
        reached=is_ready,
    )


def closing_steps(rule: Enclosure, *, opens: bool, unparks: bool) -> list[NightStep]:
    """Give what brings telescope and roof to rest; a failed park does not end it.

    While a command that ``opens`` the roof or ``unparks`` the telescope may still be under way,
    sensors that say closed or parked say only that it has not got there yet.
    """
    steps = steps_of(rule.abort, "ending what is under way")
    steps += parking_steps(rule, asks_first=unparks)

    def is_closed(view: NightView) -> bool:
        return view.closed is True

    steps.append(
        NightStep(
            words="closing the roof",
            command=rule.close.command,
            args=rule.close.args,
            within=rule.close.within or STEP_S,
            tries=1 + rule.retries,
            insists=True,
            reached=is_closed,
            asks_first=opens,
        )
    )
    return steps


def parking_steps(rule: Enclosure, *, asks_first: bool) -> list[NightStep]:
    """Give what parks the telescope; ``asks_first``: a sensor that says parked counts only then."""
    if rule.park is None:
        return []

    def is_parked(view: NightView) -> bool:
        return view.parked is True

    return [
        NightStep(
            words="parking the telescope",
            command=rule.park.command,
            args=rule.park.args,
            within=rule.mount_within,
            tries=2,
            # Past that the roof closes all the same; `Enclosure.past_deadline` is the guard's.
            required=False,
            insists=True,
            reached=is_parked,
            asks_first=asks_first,
        )
    ]


def abort_commands(
    rule: Enclosure, view: NightView, next_id: Callable[[], str]
) -> list[NightAction]:
    """Give what ends an exposure at once; nobody waits for it."""
    return first_asks(steps_of(rule.abort, "ending the exposure"), view, next_id)


def first_asks(
    steps: Sequence[NightStep], view: NightView, next_id: Callable[[], str]
) -> list[NightAction]:
    """Ask for each of the steps at once; how they end is not waited for."""
    return [ask for step in steps for ask in StepRunner([step], next_id).update_steps(view)]


def steps_of(steps: tuple[Step, ...], words: str) -> list[NightStep]:
    """Give steps of the description as such of the night."""
    return [
        NightStep(
            words=words,
            command=step.command,
            args=step.args,
            within=step.within or STEP_S,
            required=False,
        )
        for step in steps
    ]
