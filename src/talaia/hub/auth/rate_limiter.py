"""How often one may ask: so many at once, and so many a second for long. Pure.

This keeps a program that runs wild (or a person who wants to) from slowing the others down.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Hashable

__all__ = ["RateLimiter"]

# Keys; a flood from many addresses must not take the memory instead.
_MOST_KEPT = 10_000


class RateLimiter:
    """Counts by key (a person, an address). Times are the hub's monotonic nanoseconds."""

    def __init__(self, burst: int, per_s: float) -> None:
        """Allow ``burst`` at once and ``per_s`` a second for long."""
        # The generic cell rate algorithm: one time for each key, instead of a list of tries.
        self._step_ns = round(SECOND / per_s)
        self._slack_ns = burst * self._step_ns
        # When all that was taken so far is worked off, at the pace for long.
        self._due_ns: dict[Hashable, int] = {}

    def request_turn(self, key: Hashable, now_ns: int) -> int:
        """Take one; give 0, or how long (ns) to wait because it was too many."""
        # What was due long ago counts as now: rest is not saved up beyond ``burst``.
        due = max(now_ns, self._due_ns.pop(key, now_ns)) + self._step_ns
        # Above 0 it is one too many, and is not counted: trying on holds nobody back longer.
        wait = due - now_ns - self._slack_ns
        # Put at the end again: the table is in the order of the last try.
        self._due_ns[key] = due if wait <= 0 else due - self._step_ns
        if len(self._due_ns) > _MOST_KEPT:
            del self._due_ns[next(iter(self._due_ns))]
        return max(0, wait)
