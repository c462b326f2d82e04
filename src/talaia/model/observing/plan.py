"""What a planner answers: blocks in order, why each, and why not the others."""

from __future__ import annotations

from enum import StrEnum

import msgspec

from talaia.model.base import Shape

__all__ = [
    "Instrument",
    "MountAxes",
    "PauseKind",
    "PauseRules",
    "Plan",
    "PlannedBlock",
    "PlannedPause",
    "VetoCause",
    "WhyNot",
]


class MountAxes(StrEnum):
    """The two axes on which a mount turns."""

    EQUATORIAL = "equatorial"
    ALTAZIMUTH = "altazimuth"


class Instrument(Shape, frozen=True, kw_only=True):
    """How long a telescope takes for what stands between exposures: `times` of a night.

    Attributes:
        slew_rate: of the slower axis (°/s).
        mount: on which axes it turns; the first slew after a park is reckoned by them.
        settle: after a slew (s).
        acquire: to centre on a new field (s).
        filter_change: (s).
        readout: after each frame (s).
        unpark: (s).
        meridian_flip: (s); 0: a mount that needs none.
        focus_run: (s).
        horizon: lowest altitude anywhere (°).
        horizon_mask: points of azimuth and altitude (°), joined by lines, round the compass.
        dome_rate: of a dome that turns (°/s); 0: none, or it does not turn.
        rotator_rate: of what turns the camera (°/s); 0: nothing does, or it takes no time.

    """

    slew_rate: float = 3.0
    mount: MountAxes = MountAxes.EQUATORIAL
    settle: float = 3.0
    acquire: float = 20.0
    filter_change: float = 8.0
    readout: float = 5.0
    unpark: float = 20.0
    meridian_flip: float = 75.0
    focus_run: float = 120.0
    horizon: float = 15.0
    horizon_mask: tuple[tuple[float, float], ...] = ()
    dome_rate: float = 0.0
    rotator_rate: float = 0.0


class PauseRules(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What a night does between exposures beside getting to the next field.

    Attributes:
        flip: a turn over at the meridian takes so long, field and guide star found again with it
            (s); 0: the mount needs none.
        flip_after: so long past the meridian it still tracks (s).
        focus: a focus run takes so long (s); 0: nobody focuses. One comes before the first frame
            through another filter.
        focus_every: and again after so long (s).

    """

    flip: float = 0.0
    flip_after: float = 0.0
    focus: float = 0.0
    focus_every: float = 7200.0


class PauseKind(StrEnum):
    """What the telescope does while it takes no frame of a request."""

    FLIP = "flip"
    FOCUS = "focus"


class PlannedPause(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A pause that a plan counts with (times: s since the epoch, UTC).

    Attributes:
        kind: see `PauseKind`.
        start: from when.
        end: until when.
        reason: why, in words.

    """

    kind: PauseKind
    start: float
    end: float
    reason: str = ""


class VetoCause(StrEnum):
    """What keeps a request from being observed now."""

    STATE = "state"
    WINDOW = "window"
    SEQUENCE = "sequence"
    ALTITUDE = "altitude"
    AIRMASS = "airmass"
    HORIZON = "horizon"
    HOUR_ANGLE = "hour_angle"
    SUN = "sun"
    MOON_DISTANCE = "moon_distance"
    MOON_ILLUMINATION = "moon_illumination"
    PHASE = "phase"
    SEEING = "seeing"
    CLOUDS = "clouds"
    DOES_NOT_FIT = "does_not_fit"
    ALLOCATION = "allocation"
    ROOF = "roof"
    FAILURES = "failures"
    # Nothing forbids it; another is worth more now.
    OUTRANKED = "outranked"


class WhyNot(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Why a request is not observed now.

    Attributes:
        request: its id.
        cause: the first that holds.
        until: when that ends (s since the epoch, UTC); none: not in this night.
        sentence: the same in words.
        outranked_by: the request that is worth more now.
        planned_at: when the plan has it (s since the epoch, UTC); none: not in this plan.

    """

    request: str
    cause: VetoCause
    until: float | None = None
    sentence: str = ""
    outranked_by: str = ""
    planned_at: float | None = None


class PlannedBlock(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One visit of a plan (times: s since the epoch, UTC).

    Attributes:
        request: its id.
        start: of the first exposure; what leads to it (slew, filter, centring) comes before.
        end: of the last readout.
        overhead: before it (s).
        reason: why it stands here, in words.
        pauses: in it, and a focus run before it, in order; their time is counted.

    """

    request: str
    start: float
    end: float
    overhead: float = 0.0
    reason: str = ""
    pauses: tuple[PlannedPause, ...] = ()


class Plan(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A night from now on (times: s since the epoch, UTC).

    Attributes:
        made_at: when.
        night_start: Sun at -6° in the evening.
        night_end: Sun at -6° in the morning.
        blocks: in order.
        method: what found it: ``dispatch``, ``lookahead``, ``search``, ``kept``.
        value: priority times minutes of open shutter.
        bound: no plan is worth more; none: not worked out.

    """

    made_at: float
    night_start: float
    night_end: float
    blocks: tuple[PlannedBlock, ...] = ()
    method: str = ""
    value: float = 0.0
    bound: float | None = None
