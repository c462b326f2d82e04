"""Whether the sensors of a roof agree that it is closed; one that lies is not believed. Pure.

A closed switch that says *yes* beside a position of 100 % proves nothing: sensors that disagree
count as sensors that say nothing, and nothing is closed by them.

What was said before the newest turn is no witness against it: an end switch tells of the end of a
motion at once, a position perhaps half a second later. Until it has spoken again, for `SETTLE_NS`
at most, the roof counts as not closed yet, and not as one whose sensors disagree.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.safety.enclosure_guard import EnclosureEvent

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.model.interlocks.enclosure import Enclosure, Sighting

__all__ = [
    "SETTLE_NS",
    "ClosedVerdict",
    "RoofSensor",
    "SensorAgreement",
    "SensorTurns",
    "closed_by",
]

# How long a sensor that has said nothing since another one's turn is not held against it.
SETTLE_NS = 2 * SECOND


class RoofSensor(NamedTuple):
    """One sensor of a roof.

    Attributes:
        closed: none when it says nothing.
        word: its name and what it says, for people.
        said_ns: when it spoke last (monotonic).
        since_ns: when it spoke first after it had said something else (monotonic).

    """

    closed: bool | None
    word: str
    said_ns: int = 0
    since_ns: int = 0


class ClosedVerdict(NamedTuple):
    """What all sensors of a roof say together.

    Attributes:
        closed: none when they say nothing, or disagree.
        disagree: what each says, where they disagree; else empty.
        open_parts: segments and flap that are not certainly closed, by name.
        settling: one has just turned, and those that say otherwise have not spoken since; then
            ``closed`` is false.

    """

    closed: bool | None
    disagree: str = ""
    open_parts: tuple[str, ...] = ()
    settling: bool = False


def closed_by(
    whole: Sequence[RoofSensor],
    segments: Mapping[str, Sequence[RoofSensor]],
    others: Mapping[str, Sequence[RoofSensor]],
    *,
    now_ns: int,
) -> ClosedVerdict:
    """Judge the sensors of a roof.

    Args:
        whole: those that are about all of it.
        segments: those of each segment. The whole is closed exactly when all segments are.
        others: those of parts that move by themselves, such as a flap.
        now_ns: monotonic.

    """
    parts = {**segments, **others}
    apart = [part for part in (whole, *parts.values()) if {True, False} <= _sensor_words(part)]
    disputes = [(part, part) for part in apart]
    together, shells = _common_reading(whole), _flatten_sensors(segments)
    verdicts = [_common_reading(one) for one in segments.values()]
    # Each agrees in itself, but not the whole with its segments: the whole is closed exactly when
    # all are.
    if segments and together is not None and None not in verdicts and together != all(verdicts):
        apart.append([*whole, *shells])
        disputes.append((whole, shells))
    settling = [_is_settled(one, other, now_ns) for one, other in disputes]
    disagree = "; ".join(
        ", ".join(sensor.word for sensor in some)
        for some, settles in zip(apart, settling, strict=True)
        if not settles
    )
    open_parts = tuple(name for name, one in parts.items() if _common_reading(one) is not True)
    said = _sensor_words([*whole, *_flatten_sensors(parts)])
    # A part without any sensor cannot be shown to be closed; neither can the roof.
    if disagree or None in said or not all((whole, *parts.values())):
        return ClosedVerdict(None, disagree, open_parts)
    # While it settles not everything says closed, so this is False and not None.
    return ClosedVerdict(said == {True}, "", open_parts, settling=bool(settling))


def _flatten_sensors(parts: Mapping[str, Sequence[RoofSensor]]) -> list[RoofSensor]:
    return [sensor for one in parts.values() for sensor in one]


def _sensor_words(sensors: Sequence[RoofSensor]) -> set[bool | None]:
    return {sensor.closed for sensor in sensors}


def _common_reading(sensors: Sequence[RoofSensor]) -> bool | None:
    """Give what these sensors say; none when one says nothing, or they disagree."""
    said = _sensor_words(sensors)
    return said.pop() if len(said) == 1 else None


def _is_settled(one: Sequence[RoofSensor], other: Sequence[RoofSensor], now_ns: int) -> bool:
    """Tell whether whoever contradicts the newest turn has not spoken since.

    Args:
        one: some sensors.
        other: those that contradict them; the same, where they contradict each other.
        now_ns: monotonic.

    """
    turned = max((*one, *other), key=lambda sensor: sensor.since_ns)
    against = [
        sensor
        for sensor in (other if turned in one else one)
        if sensor.closed is not None and sensor.closed != turned.closed
    ]
    recent = now_ns - turned.since_ns <= SETTLE_NS
    # All of them silent since: one that has spoken again and still contradicts is a true
    # disagreement.
    return recent and all(sensor.said_ns < turned.since_ns for sensor in against)


class SensorTurns:
    """Since when each sensor says what it says."""

    def __init__(self) -> None:
        """Have heard nobody."""
        # By sensor: what it says, and when it said so first. A restart begins anew.
        self._turns: dict[Sighting, tuple[bool | None, int]] = {}

    def since_ns(self, sighting: Sighting, closed: bool | None, said_ns: int) -> int:  # noqa: FBT001
        """Take what a sensor says; give when it said so first (monotonic, as ``said_ns``)."""
        before = self._turns.get(sighting)
        if before is None or before[0] is not closed:
            before = self._turns[sighting] = closed, said_ns
        return before[1]


class SensorAgreement:
    """Whether the sensors of one enclosure disagree, over time; said once, and its end once."""

    def __init__(self, rule: Enclosure) -> None:
        """Start in agreement."""
        self._rule = rule  # For the name and `disagree_after`.
        # Since when they disagree (monotonic): for a moment they may, while a roof moves.
        self._since_ns: int | None = None
        # It has been written down.
        self._said = False
        # Empty until the disagreement has lasted; cleared when they agree again.
        self._problem = ""

    @property
    def problem(self) -> str:
        """What each sensor said when they were said to disagree; empty while they agree."""
        return self._problem

    def compare_sensors(self, seen: ClosedVerdict, now_ns: int) -> list[EnclosureEvent]:
        """Say what is to be written down now (monotonic, ns)."""
        name = self._rule.name
        if not seen.disagree:
            if seen.closed is None or seen.settling:
                # A sensor that is silent has not come to agree, nor has one that did not hear yet.
                return []
            said, self._said, self._since_ns = self._said, False, None
            self._problem = ""
            return [
                EnclosureEvent("enclosure_agrees", f"{name}: its sensors agree again", good=True)
            ] * said
        if self._since_ns is None:
            self._since_ns = now_ns
        # Once per disagreement: the text may change while it lasts, and would fill the record.
        if self._said or now_ns - self._since_ns < round(self._rule.disagree_after * SECOND):
            return []
        self._said = True
        why = f"its sensors disagree, so it counts as not closed: {seen.disagree}"
        self._problem = f"{name}: {why}"
        return [EnclosureEvent("enclosure_disagrees", self._problem, good=False)]
