"""Which sequence numbers are there: a set of whole numbers kept as ranges."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

__all__ = ["Ranges"]


class Ranges:
    """A set of whole numbers as half-open ranges that neither touch nor overlap.

    A gateway that loses nothing has one range, so every operation is short.
    """

    def __init__(self, ranges: Iterable[tuple[int, int]] = ()) -> None:
        """Start with the given half-open ranges, which may overlap."""
        # Of each range, rising; two lists, so that bisect finds a place in either.
        self._starts: list[int] = []
        # One past the last number of each range, in the same order.
        self._ends: list[int] = []
        for first, past in ranges:
            self.add_range(first, past)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(zip(self._starts, self._ends, strict=True))

    def add_range(self, first: int, past: int) -> None:
        """Put in the numbers from ``first`` up to but without ``past``."""
        if first >= past:
            return
        # Ranges that touch are merged, hence bisect on "ends at first" and "starts at past".
        left = bisect_left(self._ends, first)
        right = bisect_right(self._starts, past)
        if left < right:
            first = min(first, self._starts[left])
            past = max(past, self._ends[right - 1])
        self._starts[left:right] = [first]
        self._ends[left:right] = [past]

    def missing_ranges(self, first: int, past: int) -> list[tuple[int, int]]:
        """List what of ``first`` up to ``past`` is not here, as half-open ranges."""
        holes = []
        at = bisect_right(self._ends, first)
        while first < past and at < len(self._starts):
            start, end = self._starts[at], self._ends[at]
            if start >= past:
                break
            if first < start:
                holes.append((first, start))
            first = max(first, end)
            at += 1
        if first < past:
            holes.append((first, past))
        return holes

    def contiguous_end(self) -> int:
        """Give the least number from 0 on that is not here."""
        at = bisect_right(self._ends, 0)
        if at < len(self._starts) and self._starts[at] <= 0:
            return self._ends[at]
        return 0
