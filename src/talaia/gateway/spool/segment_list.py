"""Which segments there are, how old they are, and where a sample is in them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.gateway.spool.files import Segment
from talaia.gateway.spool.segment_reader import SpoolPosition

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from talaia.gateway.spool.files import SegmentHead

__all__ = ["SegmentList"]


class SegmentList:
    """Segments with rising numbers, the oldest first; a number is never given twice.

    A reader's place names a segment by its number: one that came again would be read from its
    middle.
    """

    def __init__(self, folder: Path, taken_up: list[Segment], now: Callable[[], float]) -> None:
        """Begin with what former runs left, ``taken_up``; ``now`` is a clock that never jumps."""
        self._folder = folder  # Where segments are; used for names only.
        self._now = now  # Monotonic (s).
        self._segments = taken_up  # Oldest first; the last is the one that is written.
        # Above all that were found, for the order of names is the order of samples.
        self._next_number = 1 + max((segment.number for segment in taken_up), default=0)
        # For how long gateways ran before this one (s), less the clock's first reading: the age
        # of what waits counts only time in which it could have been sent.
        self._ran_s = max((segment.head.ran_s for segment in taken_up), default=0.0) - now()

    def __len__(self) -> int:
        """Count the segments."""
        return len(self._segments)

    def __iter__(self) -> Iterator[Segment]:
        """Give those that are there now, however many of them go meanwhile."""
        return iter([*self._segments])

    def __contains__(self, segment: Segment) -> bool:
        """Tell whether a segment is still there."""
        return segment in self._segments

    @property
    def bytes(self) -> int:
        """How much they take on disk."""
        return sum(segment.size for segment in self._segments)

    @property
    def oldest(self) -> Segment:
        """The one that goes first when there is too much."""
        return self._segments[0]

    @property
    def newest_number(self) -> int:
        """The number of the one that is being written."""
        return self._segments[-1].number

    def add_new(self, head: SegmentHead) -> Segment:
        """Add an empty segment behind the others; there is no file of it yet."""
        number = self._next_number
        self._next_number += 1
        # Of its begin: all in it is at most this old.
        head = replace(head, ran_s=self._ran_s + self._now())
        segment = Segment(number, self._folder / f"{number:010d}.seg", head, 0, 0)
        self._segments.append(segment)
        return segment

    def remove_segment(self, segment: Segment) -> None:
        """Let a segment go; its file is for others to remove."""
        self._segments.remove(segment)

    def waited_s(self, segment: Segment) -> float:
        """Give a segment's age (s); time in which no gateway ran is not in it."""
        # By running time alone: a wall clock that jumps makes nothing old.
        return self._ran_s + self._now() - segment.head.ran_s

    def former_numbers(self, boot: str) -> list[int]:
        """Give the numbers of the segments of other runs than ``boot``, the newest first."""
        return [segment.number for segment in reversed(self._segments) if segment.head.boot != boot]

    def by_number(self, number: int) -> Segment | None:
        """Give a segment, or none when it is gone."""
        for segment in self._segments:
            if segment.number == number:
                return segment
        return None

    def position_of(self, boot: str, first: int) -> SpoolPosition:
        """Give where to read from to be given sample ``first`` of ``boot`` early on."""
        for segment in self._segments:
            if segment.head.boot == boot and segment.end > first:
                # Turn -1 is no segment's: it is read from its begin, wherever in it the sample is.
                return SpoolPosition(segment.number, -1)
        # Not on disk any more: from the oldest on.
        return SpoolPosition()
