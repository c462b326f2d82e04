"""Whether the sensors of a roof agree that it is closed; one that lies is not believed. Pure.

A closed switch that says *yes* beside a position of 100 % proves nothing: sensors that disagree
count as sensors that say nothing, and nothing is closed by them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.safety.enclosure_guard import Said

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.model.enclosure import Enclosure

__all__ = ["Agreement", "Closed", "Sensor", "closed_by"]


class Sensor(NamedTuple):
    """One sensor of a roof.

    Attributes:
        closed: none when it says nothing.
        word: its name and what it says, for people.

    """

    closed: bool | None
    word: str


class Closed(NamedTuple):
    """What all sensors of a roof say together.

    Attributes:
        closed: none when they say nothing, or disagree.
        disagree: what each says, where they disagree; else empty.
        open_parts: segments and flap that are not certainly closed, by name.

    """

    closed: bool | None
    disagree: str = ""
    open_parts: tuple[str, ...] = ()


def closed_by(
    whole: Sequence[Sensor],
    segments: Mapping[str, Sequence[Sensor]],
    others: Mapping[str, Sequence[Sensor]],
) -> Closed:
    """Judge the sensors of a roof.

    Args:
        whole: those that are about all of it.
        segments: those of each segment. The whole is closed exactly when all segments are.
        others: those of parts that move by themselves, such as a flap.

    """
    parts = {**segments, **others}
    words = [_contradiction(each) for each in (whole, *parts.values())]
    together = _together(whole)
    each = [_together(one) for one in segments.values()]
    if segments and together is not None and None not in each and together != all(each):
        words.append(", ".join(one.word for one in (*whole, *_flat(segments))))
    disagree = "; ".join(word for word in words if word)
    open_parts = tuple(name for name, one in parts.items() if _together(one) is not True)
    said = [together, *(_together(one) for one in parts.values())]
    if disagree or None in said:
        return Closed(None, disagree, open_parts)
    return Closed(all(said), "", open_parts)


def _flat(parts: Mapping[str, Sequence[Sensor]]) -> list[Sensor]:
    return [sensor for one in parts.values() for sensor in one]


def _together(sensors: Sequence[Sensor]) -> bool | None:
    """Give what these sensors say; none when one says nothing, or they disagree."""
    said = {each.closed for each in sensors}
    return said.pop() if len(said) == 1 else None


def _contradiction(sensors: Sequence[Sensor]) -> str:
    said = {each.closed for each in sensors}
    if not {True, False} <= said:
        return ""
    return ", ".join(each.word for each in sensors)


class Agreement:
    """Whether the sensors of one enclosure disagree, over time; said once, and its end once."""

    def __init__(self, rule: Enclosure) -> None:
        """Start in agreement."""
        self._rule = rule
        self._since_ns: int | None = None
        self._said = False
        self._problem = ""

    @property
    def problem(self) -> str:
        """What each sensor said when they were said to disagree; empty while they agree."""
        return self._problem

    def look(self, seen: Closed, now_ns: int) -> list[Said]:
        """Say what is to be written down now (monotonic, ns)."""
        name = self._rule.name
        if not seen.disagree:
            if seen.closed is None:
                # A sensor that is silent has not come to agree.
                return []
            said, self._said, self._since_ns = self._said, False, None
            self._problem = ""
            return [Said("enclosure_agrees", f"{name}: its sensors agree again", good=True)] * said
        if self._since_ns is None:
            self._since_ns = now_ns
        if self._said or now_ns - self._since_ns < round(self._rule.disagree_after * SECOND):
            return []
        self._said = True
        why = f"its sensors disagree, so it counts as not closed: {seen.disagree}"
        self._problem = f"{name}: {why}"
        return [Said("enclosure_disagrees", self._problem, good=False)]
