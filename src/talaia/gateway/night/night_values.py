"""What the executor of a night goes by, and what it asks for. Pure values."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.night.target_place import EquatorialPlace
    from talaia.model.observing.states import ObservationState, SuspensionCause
    from talaia.wire.frames import CommandPhase, Scalar

__all__ = [
    "NightAction",
    "NightChoice",
    "NightCommand",
    "NightEvent",
    "NightView",
    "ObservationChange",
    "PartRun",
    "PlanQuestion",
    "StepAnswer",
]


class NightView(NamedTuple):
    """How things stand at one moment; what nobody knows is none.

    Attributes:
        now: monotonic (s).
        time: s since the epoch (UTC).
        sun: its altitude (°).
        closing: why the roof's guard wants it closed; empty: it does not.
        barred: why the roof may not be opened, or the telescope unparked, now; empty: they may.
        opened: the roof is open.
        closed: it is closed.
        parked: the telescope is parked.
        pointing: where it points: altitude, azimuth (°).
        person: who acts on a device of the night, or did a moment ago; empty: nobody.
        clouds: cloud cover (%).
        seeing: FWHM (″).
        unread: of ``clouds`` and ``seeing``, what should be measured and says nothing now: what is
            held to a limit of it waits. The seeing that is measured as a field is centred is not
            among them.
        binning: of the camera, as it says; none: it does not, or nobody asks.
        gain: of the camera, as it says; none: as for ``binning``.
        tracking: the telescope follows the sky; none: nobody knows, or nobody asks.
        rotator: the angle at which it stands (°); none: as for ``binning``.

    """

    now: float
    time: float
    sun: float
    closing: str = ""
    barred: str = ""
    opened: bool | None = None
    closed: bool | None = None
    parked: bool | None = None
    pointing: tuple[float, float] | None = None
    person: str = ""
    clouds: float | None = None
    seeing: float | None = None
    unread: frozenset[str] = frozenset()
    binning: float | None = None
    gain: float | None = None
    tracking: bool | None = None
    rotator: float | None = None


class NightCommand(NamedTuple):
    """A command that is asked for as a person asks; its end comes as a `StepAnswer`.

    Attributes:
        id: never used twice.
        command: ``<device>/<command>``.
        args: by name.
        within: its end is waited for so long (s).
        is_frame: it takes a frame of a request, whose file is waited for and named.
        wants_level: that file is measured, too; see `StepAnswer`.

    """

    id: str
    command: str
    args: Mapping[str, Scalar]
    within: float
    is_frame: bool = False
    wants_level: bool = False


class PartRun(NamedTuple):
    """A part of `talaia.gateway.night.imaging.star_parts` that is to run; answered as a command is.

    Attributes:
        id: never used twice.
        part: ``focus``, ``centre``, ``guide``, ``dither`` or ``unguide``.
        within: its end is waited for so long (s).
        filter: that is in.
        ra: of the field (ICRS, °).
        dec: of the field (ICRS, °).
        dither: so far at the most (″).

    """

    id: str
    part: str
    within: float
    filter: str = ""
    ra: float = 0.0
    dec: float = 0.0
    dither: float = 0.0


class StepAnswer(NamedTuple):
    """How a command or a part ended; ``unknown`` where nobody can tell.

    Attributes:
        id: of the command or part.
        phase: how it ended.
        message: in words.
        place: of a field that is centred: where the mount was sent for it; none: as it was.
        level: of a flat: its median (counts); none: nobody has measured it.

    """

    id: str
    phase: CommandPhase
    message: str = ""
    place: EquatorialPlace | None = None
    level: float | None = None


class PlanQuestion(NamedTuple):
    """What to observe next is to be asked of the planner.

    Attributes:
        number: rises; the answer has the same.
        time: s since the epoch (UTC).
        current: the request under way; empty: none.

    """

    number: int
    time: float
    current: str = ""


class NightChoice(NamedTuple):
    """What a planner answers.

    Attributes:
        number: of the question.
        request: to be observed now; empty: wait.
        wait_until: ask again then, or at the next event (s since the epoch, UTC).
        reason: in words.

    """

    number: int
    request: str = ""
    wait_until: float = 0.0
    reason: str = ""


class NightEvent(NamedTuple):
    """Something worth writing down; ``good`` is false where somebody should look."""

    kind: str
    message: str
    good: bool = True


class ObservationChange(NamedTuple):
    """What became of the try at a request; see `talaia.wire.frames.ObservationUpdate`."""

    request: str
    state: ObservationState
    frames_done: tuple[int, ...]
    cause: SuspensionCause | None = None
    why: str = ""
    block_s: float = 0.0


NightAction = NightCommand | PartRun | PlanQuestion | NightEvent | ObservationChange
