"""Proposals, request groups and requests: what people ask of the nights."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta

from talaia.model.observing.states import RequestState
from talaia.model.observing.targets import Target  # noqa: TC001 - msgspec reads it

__all__ = [
    "Configuration",
    "Constraints",
    "GroupOperator",
    "Guiding",
    "ImageType",
    "PhaseWindow",
    "Proposal",
    "Request",
    "RequestGroup",
    "Urgency",
    "Window",
]

# May stand in an address and a file's name.
RequestId = Annotated[str, Meta(pattern="^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")]
_Title = Annotated[str, Meta(max_length=200)]
_Seconds = Annotated[float, Meta(ge=0, le=86_400)]
_UnixSeconds = Annotated[float, Meta(ge=0, le=2**34)]


class _Value(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The base of these shapes; fields that a reader does not know are passed over."""


class ImageType(StrEnum):
    """What a frame is. All but ``LIGHT`` and ``SKY_FLAT`` may be taken with a closed roof."""

    LIGHT = "LIGHT"
    SKY_FLAT = "SKY_FLAT"
    DARK = "DARK"
    BIAS = "BIAS"


class Guiding(StrEnum):
    """Whether a configuration is guided; ``OPTIONAL``: as well as it goes."""

    OFF = "OFF"
    OPTIONAL = "OPTIONAL"
    ON = "ON"


class Urgency(StrEnum):
    """How a group ranks among others.

    ``TIME_CRITICAL`` yields to a higher priority only; ``RAPID_RESPONSE`` interrupts what is not.
    """

    NORMAL = "NORMAL"
    TIME_CRITICAL = "TIME_CRITICAL"
    RAPID_RESPONSE = "RAPID_RESPONSE"


class GroupOperator(StrEnum):
    """How the requests of a group belong together; ``SEQUENCE``: each after the one before."""

    SINGLE = "SINGLE"
    MANY = "MANY"
    SEQUENCE = "SEQUENCE"


class Window(_Value, frozen=True, kw_only=True):
    """From when to when a request may be observed (s since the epoch, UTC)."""

    start: _UnixSeconds
    end: _UnixSeconds


class PhaseWindow(_Value, frozen=True, kw_only=True):
    """A part of a period, as of a variable star.

    Attributes:
        epoch: when its phase was 0 (s since the epoch, UTC).
        period: (s).
        start: phase from which it may be observed (0 to 1).
        end: phase to which; less than ``start`` where it passes through 0.

    """

    epoch: float
    period: Annotated[float, Meta(gt=0)]
    start: Annotated[float, Meta(ge=0, le=1)]
    end: Annotated[float, Meta(ge=0, le=1)]


class Constraints(_Value, frozen=True, kw_only=True):
    """What must hold all the time that a request is observed.

    Attributes:
        min_altitude: geometric, without refraction (°).
        max_airmass: as the secant of the zenith distance.
        min_moon_distance: while the Moon is up (°).
        max_moon_illumination: lit fraction, while the Moon is up (0 to 1).
        max_sun_altitude: -18 astronomical, -12 nautical, -6 civil twilight (°).
        max_hour_angle: on either side of the meridian (h); none: any.
        max_seeing: FWHM as measured last (″); none: any.
        max_clouds: as measured last (%); none: any.
        phase: none: any.

    """

    min_altitude: Annotated[float, Meta(ge=0, le=90)] = 15.0
    max_airmass: Annotated[float, Meta(ge=1, le=40)] = 10.0
    min_moon_distance: Annotated[float, Meta(ge=0, le=180)] = 0.0
    max_moon_illumination: Annotated[float, Meta(ge=0, le=1)] = 1.0
    max_sun_altitude: Annotated[float, Meta(ge=-90, le=0)] = -12.0
    max_hour_angle: Annotated[float, Meta(gt=0, le=12)] | None = None
    max_seeing: Annotated[float, Meta(gt=0, le=60)] | None = None
    max_clouds: Annotated[float, Meta(ge=0, le=100)] | None = None
    phase: PhaseWindow | None = None


class Configuration(_Value, frozen=True, kw_only=True):
    """Frames of one kind.

    Attributes:
        type: what a frame is.
        filter: by name, as the description has it; empty: whichever is in.
        exposure: of each frame (s).
        count: how many frames.
        binning: in both axes.
        gain: as the camera counts it; none: as it is.
        dither: between frames, in a random direction, so far at the most (″).
        guiding: see `Guiding`.

    """

    type: ImageType = ImageType.LIGHT
    filter: Annotated[str, Meta(max_length=40)] = ""
    exposure: _Seconds
    count: Annotated[int, Meta(ge=1, le=10_000)] = 1
    binning: Annotated[int, Meta(ge=1, le=16)] = 1
    gain: float | None = None
    dither: Annotated[float, Meta(ge=0, le=600)] = 0.0
    guiding: Guiding = Guiding.OFF


class Request(_Value, frozen=True, kw_only=True):
    """One visit: a target, what is taken of it, when and under which conditions.

    Attributes:
        id: unique at its hub.
        target: none for frames that need no sky.
        configurations: taken in this order.
        constraints: hold in all of it.
        windows: the visit lies inside one of them.
        state: where it stands.
        frames_done: of each configuration, read out and kept; shorter: none of the rest.
        failures: how often it failed.

    """

    id: RequestId
    target: Target | None = None
    configurations: Annotated[tuple[Configuration, ...], Meta(min_length=1, max_length=100)]
    constraints: Constraints = Constraints()
    windows: Annotated[tuple[Window, ...], Meta(min_length=1, max_length=1000)]
    state: RequestState = RequestState.PENDING
    frames_done: tuple[int, ...] = ()
    failures: int = 0


class RequestGroup(_Value, frozen=True, kw_only=True):
    """Requests that were handed in together. A cadence stands here as its visits.

    Attributes:
        id: unique at its hub.
        proposal: which pays for it.
        name: as its requester calls it.
        requester: the account that asked.
        operator: see `GroupOperator`.
        urgency: see `Urgency`.
        priority: a minute of open shutter is worth so much, beside others.
        created_at: (s since the epoch, UTC).
        requests: in order.

    """

    id: RequestId
    proposal: RequestId
    name: _Title = ""
    requester: Annotated[str, Meta(max_length=200)] = ""
    operator: GroupOperator = GroupOperator.SINGLE
    urgency: Urgency = Urgency.NORMAL
    priority: Annotated[float, Meta(gt=0, le=1000)] = 10.0
    created_at: _UnixSeconds = 0.0
    requests: Annotated[tuple[Request, ...], Meta(min_length=1, max_length=1000)]


class Proposal(_Value, frozen=True, kw_only=True):
    """What a group of people may use of the observatory.

    Attributes:
        id: short, as on forms.
        title: what it is about.
        share: of the shutter time that it is due (0 to 1).
        hours_allocated: block time in all (h).
        hours_used: of it (h).
        active: an ended one gets no time.

    """

    id: RequestId
    title: _Title = ""
    share: Annotated[float, Meta(ge=0, le=1)] = 0.0
    hours_allocated: Annotated[float, Meta(ge=0, le=100_000)] = 0.0
    hours_used: Annotated[float, Meta(ge=0, le=200_000)] = 0.0
    active: bool = True
