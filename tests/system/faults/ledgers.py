"""The judge: ledgers of what was said, stored and done, held against the invariants. Pure.

All moments are nanoseconds of this machine's monotonic clock unless a name says otherwise.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

MS = 1_000_000
# Commands and what they caused are matched within this.
MATCHING_NS = 50 * MS
TTL_MS = 250.0
STOP_MS = 500.0
# From the gateway's publication to the robot's log, on a machine whose cores others use too.
HOP_MS = 100.0
# A robot that counts 200 times a second and leaves such a hole did not run.
STALL_MS = 50.0
BACK_S = 30.0
# One site alone whose link comes back.
ALONE_S = 3.0
# I7: so much of the memory before may be in use afterwards.
MEMORY = 1.2
# I8: so soon after the fault's end all that shows a value shows the same (s).
AGREE_S = 2.0
# A gap tells when values came; they were said a little before, on a busy machine (µs).
SLACK_US = 250_000


class Said(NamedTuple):
    """A value the robot published: value, moment, subscriptions ever known just before."""

    value: int
    at: int
    known: int


class Told(NamedTuple):
    """A velocity that reached the robot."""

    at: int
    linear: float
    angular: float

    @property
    def moves(self) -> bool:
        """Whether it is not zero."""
        return (self.linear, self.angular) != (0.0, 0.0)


@dataclass
class Findings:
    """What one run of a row found."""

    violations: list[str] = field(default_factory=list)
    stops_ms: list[float] = field(default_factory=list)
    back_s: list[float] = field(default_factory=list)
    counted: Counter[str] = field(default_factory=Counter)
    # Measured, by what it is; of all runs the table shows least, median and most.
    figures: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    # The memory of a process after the run, to the one before it.
    memory: list[float] = field(default_factory=list)
    # How many runs of this row there were before.
    turn: int = 0

    def breach(self, invariant: str, what: str) -> None:
        """Write a violation down."""
        self.violations.append(f"{invariant}: {what}")


def lost(
    said: Iterable[Said],
    stored: Iterable[int],
    gaps_us: Iterable[tuple[int, int]] = (),
    wall_us: Mapping[int, int] | None = None,
) -> set[int]:
    """I1, I9: values that are neither stored nor in a recorded gap (from, to)."""
    missing = {each.value for each in said} - {*stored}
    times, spans = wall_us or {}, [*gaps_us]
    return {
        value
        for value in missing
        if not any(a - SLACK_US <= times.get(value, -SLACK_US) <= b + SLACK_US for a, b in spans)
    }


def disordered(stored: Sequence[int]) -> set[int]:
    """I10: values of a counter that stand before an earlier one, in order of time."""
    return {before for before, after in pairwise(stored) if after < before}


def doubled(stored: Iterable[int]) -> set[int]:
    """I2: values that are in the database more than once."""
    return {value for value, times in Counter(stored).items() if times > 1}


def repeated(acted: Iterable[object]) -> set[object]:
    """I3: commands that reached the robot more than once."""
    return {each for each, times in Counter(acted).items() if times > 1}


def stale(told: Iterable[Told], pressed: Mapping[float, int]) -> list[tuple[Told, float]]:
    """I4: motions older than their time to live, with their age (ms); infinite for no press.

    Args:
        told: what reached the robot.
        pressed: the moment of each press by its velocity, which no other press has.

    """
    found = []
    for each in told:
        if each.moves:
            at = pressed.get(round(each.linear, 7))
            age = float("inf") if at is None else (each.at - at) / MS
            if age > TTL_MS + HOP_MS:
                found.append((each, age))
    return found


def stall_ms(said: Sequence[Said], moment: int) -> float:
    """Tell for how long the robot itself did not run around a moment (ms).

    It counts by the clock, so that a hole in its own ledger is the machine's, not the product's:
    what it heard then, it heard later than it was told.
    """
    pairs = pairwise(each.at for each in said)
    near = (b - a for a, b in pairs if b > moment - 1000 * MS and a < moment + 200 * MS)
    return max(near, default=0) / MS


def moved_after(told: Iterable[Told], end: int) -> list[Told]:
    """I4: motions after something that ends all motion (lease end, STOP, restart)."""
    return [each for each in told if each.moves and each.at > end]


def stop_ms(told: Sequence[Told], fault: int) -> float:
    """I5: how long after ``fault`` the robot was told zero for good; infinite when it never was."""
    last = max((each.at for each in told if each.moves), default=fault)
    zero = next((each.at for each in told if not each.moves and each.at > max(last, fault)), None)
    return float("inf") if zero is None else (zero - fault) / MS


def left_moving(told: Sequence[Told]) -> list[float]:
    """I5: for how long the robot heard nothing after each motion (ms): no next one, and no zero."""
    return [(after.at - before.at) / MS for before, after in pairwise(told) if before.moves]


def spread(values: Iterable[float]) -> tuple[float, float, float] | None:
    """Give least, median and most; none of nothing."""
    ordered = sorted(values)
    if not ordered:
        return None
    return ordered[0], ordered[len(ordered) // 2], ordered[-1]
