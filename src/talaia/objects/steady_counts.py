"""Counts for interlocks: steady while somebody is in view, though the detector wavers. Pure.

A small detector sees a person in one picture and misses them in the next. Judged picture by
picture an interlock would lock and let go every few seconds. So it keeps what it has seen in two
ways, as a comparator with hysteresis does: a box is believed at a lower score where a sure one has
just been, and a count falls only after it has been lower for a while. What rises counts at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.objects.camera_objects import counts_as

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.model.detection import Detect, DetectionSource
    from talaia.objects.detection import Detection

__all__ = ["SteadyCounts"]

# A box that is this share as sure as must be, and lies where a counted one lay, counts on.
KEPT_AT = 0.7
# Without a sure box for so long, a weak one is a coat on a chair, and not a person.
WEAK_US = 10_000_000
# Area that both share, of the area that either covers.
SAME_PLACE = 0.2


class SteadyCounts:
    """What interlocks are told of one camera."""

    def __init__(self, detect: Detect) -> None:
        """Have seen nothing yet."""
        # Its zones.
        self._detect = detect
        # As sure as a box must be by itself (0 to 1).
        self._confidence = detect.confidence
        # How long a count stays after it was lower (µs); the description has it in seconds.
        self._hold_us = round(detect.hold * 1e6)
        # What counted within the hold time, with when (µs).
        self._counted: list[tuple[int, Detection]] = []
        # By class: when a box was last sure enough by itself (µs).
        self._sure_us: dict[str, int] = {}
        # By signal: counts of the pictures within the hold time, with when (µs).
        self._past: dict[str, list[tuple[int, int]]] = {}

    def count_things(
        self, things: Sequence[Detection], sources: Mapping[str, DetectionSource], at_us: int
    ) -> dict[str, int]:
        """Give the count for each signal after one more picture.

        Args:
            things: what the detector told of it.
            sources: by signal, of those that count; see `CameraObjects.count_things`.
            at_us: when it was taken; a time before the last one begins anew.

        """
        if self._counted and at_us < self._counted[-1][0]:
            # A clock set back would keep old counts until time has caught up with them.
            self._counted, self._past, self._sure_us = [], {}, {}
        for thing in things:
            if thing.score >= self._confidence:
                self._sure_us[thing.label] = at_us
        since_us = at_us - self._hold_us
        before = [(when, name) for when, name in self._counted if when >= since_us]
        believed = [thing for thing in things if self._is_believed(thing, before, at_us)]
        # Weak boxes that are believed are kept, too: a person who moves slowly is followed so.
        self._counted = [*before, *((at_us, thing) for thing in believed)]
        counts = {}
        for name, source in sources.items():
            now = sum(counts_as(source, thing, self._detect) for thing in believed)
            past = [entry for entry in self._past.get(name, []) if entry[0] >= since_us]
            # Only what could still be the greatest is kept.
            kept = [count for count in past if count[1] > now]
            self._past[name] = [*kept, (at_us, now)]
            # The greatest within the hold time: a miss in one picture must not open an interlock.
            counts[name] = max(many for _, many in self._past[name])
        return counts

    def _is_believed(
        self, thing: Detection, before: Sequence[tuple[int, Detection]], at_us: int
    ) -> bool:
        if thing.score >= self._confidence:
            return True
        if at_us - self._sure_us.get(thing.label, at_us) > WEAK_US:
            return False
        return thing.score >= self._confidence * KEPT_AT and any(
            earlier.label == thing.label and _overlap_of(earlier, thing) >= SAME_PLACE
            for _, earlier in before
        )


def _overlap_of(one: Detection, other: Detection) -> float:
    """Give the intersection over the union of two boxes, 0 to 1."""
    width = min(one.right, other.right) - max(one.left, other.left)
    height = min(one.bottom, other.bottom) - max(one.top, other.top)
    if width <= 0 or height <= 0:
        return 0.0
    shared = width * height
    both = sum((box.right - box.left) * (box.bottom - box.top) for box in (one, other))
    return shared / (both - shared)
