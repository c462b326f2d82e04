"""Alarms as values: what is watched, and when it reaches a person.

Conditions are data. The one that is written as text (``expression``) is read by a parser of our
own, see `expression`; nothing is ever evaluated as code.
"""

from __future__ import annotations

from enum import StrEnum

import msgspec

from talaia.model.base import Shape

__all__ = ["Alarm", "AlarmKind", "Escalation", "Severity"]


class AlarmKind(StrEnum):
    """What an alarm watches for."""

    LIMIT = "limit"
    STATE = "state"
    STALE = "stale"
    ANOMALY = "anomaly"
    DETECTION = "detection"
    EXPRESSION = "expression"
    # A position is inside or outside a zone of the map.
    ZONE = "zone"
    # An enclosure should be closed and cannot be shown to be, or its sensors disagree.
    ENCLOSURE = "enclosure"
    # The site's gateway has no link to the hub.
    GATEWAY = "gateway"


class Severity(StrEnum):
    """How bad it is, the least first."""

    INFO = "info"
    WARNING = "warning"
    CRITICAL = "critical"

    @property
    def rank(self) -> int:
        """Give 0 for the least."""
        return list(Severity).index(self)


class Escalation(Shape, frozen=True, kw_only=True):
    """Who is told of an alarm that nobody has acknowledged, and when.

    Attributes:
        who: the account's name; told by the ways that this person has chosen.
        after: this long after it was raised (s); 0: at once.

    """

    who: str
    after: float = 0.0


class Alarm(Shape, frozen=True, kw_only=True):
    """One thing that people are told of. Which keys stand here goes by the kind.

    A value that is unknown, not a number or too old makes no condition true and none false: the
    alarm is then shown as one that cannot be judged, it is never shown as well, and one that is
    active stays so.

    Attributes:
        name: what people call it.
        kind: what it watches for.
        signal: limit, state, stale, anomaly, zone: the channel, ``<device>/<signal>`` or, of a
            position, ``<device>/<signal>.x``.
        device: anomaly, in place of a signal: all that detectors look at on this device, and on
            those that a group of signals joins with it; what becomes unusual together is one alarm.
        inside: zone: true while the position ``signal`` (``<device>/<signal>``) is in this polygon
            of the map's zones.
        outside: zone: true while it is not in this one.
        margin: zone: true already so near to the zone's edge (m).
        above: limit: true when greater, in the signal's unit.
        below: limit: true when less, in the signal's unit.
        hysteresis: limit: once true it lets go only so far on the safe side of the limit.
        is_one_of: state: true in these states or at these texts; written ``is``.
        is_not: state: true in every state but these.
        max_age: a value older than this is unknown, or stale (s); none takes the signal's own.
        score: anomaly: only those with at least this score.
        stream: detection: the camera, ``<device>/<stream>``.
        label: detection: what is seen, by the detector's name for it.
        count: detection: at least so many at once.
        confidence: detection: only those of which the detector is at least so sure, 0 to 1.
        expression: expression: what is compared; see the how-to page on alarms.
        enclosure: enclosure: which, by its short name; empty for any.
        severity: how bad it is.
        delay: raised only after it was true for so long (s).
        clear_delay: cleared only after it was false for so long (s).
        unknown_after: raised also when it could not be judged for so long (s); none: never.
        repeat: told again so often (s) while it is active and nobody has acknowledged it; none:
            once.
        remind: told again so often (s) while it is active though acknowledged; none: never.
        escalate: who is told, one after the other, until it is acknowledged; with none, everybody
            whose rules want it is told at once.
        record: the gateway records its topics around it, as far as `Recording` has it.
        advice: what to do, for whoever reads the message.

    """

    name: str
    kind: AlarmKind
    signal: str = ""
    device: str = ""
    inside: str = ""
    outside: str = ""
    margin: float = 0.0
    above: float | None = None
    below: float | None = None
    hysteresis: float = 0.0
    is_one_of: tuple[str, ...] = msgspec.field(default=(), name="is")
    is_not: tuple[str, ...] = ()
    max_age: float | None = None
    score: float = 0.0
    stream: str = ""
    label: str = ""
    count: int = 1
    confidence: float = 0.5
    expression: str = ""
    enclosure: str = ""
    severity: Severity = Severity.WARNING
    delay: float = 0.0
    clear_delay: float = 0.0
    unknown_after: float | None = None
    repeat: float | None = None
    remind: float | None = None
    escalate: tuple[Escalation, ...] = ()
    record: bool = False
    advice: str = ""
