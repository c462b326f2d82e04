"""Up to where a run's samples are stored without a hole, as batches come in any order. Pure."""

from __future__ import annotations

__all__ = ["StoredRun"]


class StoredRun:
    """Sequence numbers that are on disk, of one boot of one gateway.

    Live batches overtake the old ones that follow an outage, so what is stored has holes for a
    while; an acknowledgement may only speak of what lies below the first hole.
    """

    def __init__(self, below: int) -> None:
        """Every sequence number under ``below`` is stored."""
        self.below = below
        # What is stored beyond the first hole: first number to one past the last.
        self._above: dict[int, int] = {}

    def add_stored(self, first: int, end: int) -> None:
        """Count ``first`` up to, not including, ``end`` as stored (or as a recorded gap)."""
        if end <= self.below:
            return
        if first > self.below:
            # Of two that begin alike the longer counts.
            self._above[first] = max(end, self._above.get(first, 0))
            return
        self.below = end
        # What is now without a hole before it moves `below` on.
        while self._above:
            start = min(self._above)
            if start > self.below:
                break
            self.below = max(self.below, self._above.pop(start))
