"""What is best now, at once: the worth of each visit by the time that it takes from now on."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.planner.between.pauses import leads_from
from talaia.planner.feasibility import NEVER

if TYPE_CHECKING:
    from talaia.planner.night_problem import Ints
    from talaia.planner.progress import NightProgress
    from talaia.planner.sky import Floats

__all__ = ["Choice", "choose_now", "rank_now", "soonest_start"]

# A visit that begins later than this is no choice for now (s).
_LONGEST_IDLE_S = 600


class Choice(NamedTuple):
    """A visit and when it would begin.

    Attributes:
        row: of the visit.
        start: of its first exposure (s of the night).
        end: of its last readout.
        overhead: before it (s).
        rate: what it is worth by a minute from now to its end.
        next_rate: the same of the next best; 0: there is none.

    """

    row: int
    start: int
    end: int
    overhead: int
    rate: float
    next_rate: float


def rank_now(progress: NightProgress, second: int, rows: Ints) -> tuple[Ints, Floats, Ints]:
    """Give start, worth by a minute, and overhead of each visit if it were next."""
    table = progress.problem.table
    overhead = leads_from(progress, second, rows)
    start = progress.feasibility.earliest_starts(rows, second + overhead)
    taken = start + table.block_s[rows] - second
    rate = table.value[rows] / np.maximum(taken, 1) * 60.0
    return start, np.where(start < NEVER, rate, -1.0), overhead


def choose_now(progress: NightProgress, second: int) -> Choice | None:
    """Choose the visit that is worth most by a minute; none where nothing begins soon."""
    rows = progress.released(progress.candidates(second))
    if not rows.size:
        return None
    start, rate, overhead = rank_now(progress, second, rows)
    idle = start - second - overhead
    rate = np.where(idle <= _LONGEST_IDLE_S, rate, -1.0)
    order = np.argsort(-rate)[:2]
    best = int(order[0])
    if rate[best] <= 0.0:
        return None
    row = int(rows[best])
    return Choice(
        row=row,
        start=int(start[best]),
        end=int(start[best]) + int(progress.problem.table.block_s[row]),
        overhead=int(overhead[best]),
        rate=float(rate[best]),
        next_rate=max(0.0, float(rate[int(order[1])])) if len(order) > 1 else 0.0,
    )


def soonest_start(progress: NightProgress, second: int) -> int:
    """Give the second at which to set out for whatever may begin first; `NEVER` if nothing."""
    rows = progress.released(progress.candidates(second))
    if not rows.size:
        return NEVER
    start, _, overhead = rank_now(progress, second, rows)
    return int((start - overhead).min())
