"""JSON bodies about rules and the sky; the browser's types are made from these.

Angles are degrees, right ascension is hours, azimuth counts from north through east, times are
seconds.
"""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from talaia.model.interlocks.capabilities import Capabilities  # noqa: TC001 - pydantic reads it

__all__ = [
    "ConditionShape",
    "EnclosurePartShape",
    "EnclosureShape",
    "LimitShape",
    "PlaceShape",
    "PointingShape",
    "RuleShape",
    "SightingShape",
    "SkyFieldShape",
    "SkyList",
    "SkyObject",
    "SkyOutline",
    "SkyStar",
    "SlewShape",
    "StateNeed",
]


class _Shape(BaseModel):
    """A key that is not described is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class PlaceShape(_Shape):
    """Where a site is on Earth: degrees north, degrees east, metres."""

    latitude: float
    longitude: float
    elevation: float


class SlewShape(_Shape):
    """A command that points a telescope, and its arguments that say where to; empty for none."""

    command: str
    ra: str
    dec: str
    alt: str
    az: str


class PointingShape(_Shape):
    """Where a telescope may not point: lower than ``horizon``, or within ``sun`` of the Sun."""

    commands: list[SlewShape]
    horizon: float
    sun: float


class LimitShape(_Shape):
    """When a signal is unsafe: out of these limits, in or out of these states, or unknown.

    With ``minus`` the limits are for ``signal`` less that one; with ``humidity`` for ``signal``,
    a temperature, less the dew point at that humidity.
    """

    signal: str
    minus: str
    humidity: str
    above: float | None
    until_below: float | None
    below: float | None
    until_above: float | None
    states: list[str]
    safe_states: list[str]


class ConditionShape(_Shape):
    """Unsafe while all of these limits say so. ``link_lost``: without the hub for so long.

    With ``sun`` (``altitude``) the one limit is for the Sun (°), and its ``signal`` is empty.
    """

    limits: list[LimitShape]
    lasting: float
    link_lost: float | None
    sun: str


class RuleShape(_Shape):
    """An interlock as far as you may see it; ``hidden`` of its conditions you may not.

    ``targets`` are what it refuses: ``device/command``, ``device/drive`` or ``device/*``.
    """

    id: str
    name: str
    conditions: list[ConditionShape]
    hidden: int
    targets: list[str]
    dwell: float


class SightingShape(_Shape):
    """What a sensor says when something is so: in these states, or within these limits."""

    signal: str
    states: list[str]
    above: float | None
    below: float | None


class EnclosurePartShape(_Shape):
    """A segment or flap; ``position`` is the address of how far it is open (%), or empty."""

    id: str
    name: str
    closed: list[SightingShape]
    position: str


class EnclosureShape(_Shape):
    """A roof: closed only when all of ``closed`` say so; kept closed by the rules of ``unsafe``.

    It is closed only when each of its ``segments`` and its ``flap`` is, too.
    """

    id: str
    name: str
    closed: list[SightingShape]
    moving: list[SightingShape]
    close: str
    stop: str
    unsafe: list[str]
    position: str
    segments: list[EnclosurePartShape]
    flap: EnclosurePartShape | None
    can: Capabilities


class SkyObject(_Shape):
    """Something of a catalogue; coordinates are degrees of J2000, ``magnitude`` is visual."""

    name: str
    also: list[str]
    kind: str
    constellation: str
    ra_deg: float
    dec_deg: float
    magnitude: float | None


class SkyList(_Shape):
    """What goes by a name. ``available`` is false where the hub has no catalogue."""

    available: bool
    objects: list[SkyObject]


class SkyStar(_Shape):
    """A star of Hipparcos; degrees of J2000, where it stands in 2027."""

    ra_deg: float
    dec_deg: float
    magnitude: float


class SkyOutline(_Shape):
    """Something of a catalogue as it lies on the sky; coordinates are degrees of J2000.

    ``major`` and ``minor`` are its diameters (°), none where nobody has measured them; ``angle`` is
    where the longer one points, from north through east (°).
    """

    name: str
    also: list[str]
    kind: str
    ra_deg: float
    dec_deg: float
    major: float | None
    minor: float | None
    angle: float


class SkyFieldShape(_Shape):
    """What is there of a piece of the sky, the brightest stars and the largest objects first.

    ``available`` is false where the hub has no catalogue of objects.
    """

    available: bool
    stars: list[SkyStar]
    objects: list[SkyOutline]


class StateNeed(_Shape):
    """The state that a command leads on from: the signal's channel has to be ``among`` these.

    ``states``: all of the signal's, in the order of its numbers; ``max_age`` (s) is its.
    """

    channel: str
    max_age: float
    states: list[str]
    among: list[str]
