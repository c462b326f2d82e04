"""What no plan of a night can be worth more than: a linear program, made safe by weak duality.

Visits may be split at will, take the least overhead that any order could leave them, and weather
and arrivals are known beforehand; so the bound lies above every real plan. Slots of 300 s. For
many visits only the densest are in the program; its prices are then applied to all of them, which
keeps it a bound whatever they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.planner.feasibility import Feasibility
from talaia.planner.sky import MARK_S

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.planner.night_problem import Ints, NightProblem
    from talaia.planner.progress import NightProgress
    from talaia.planner.sky import Floats

__all__ = ["RestBound", "bound_value"]

# Marks of a minute in one slot of the program.
_SLOT_MARKS = 5
# Visits in the program; its prices are then applied to all others, too.
_IN_PROGRAM = 500
# Fields nearer than 0.01° count as one: nothing is slewed and centred between them.
_FIELDS_PER_DEGREE = 100


class _Program(NamedTuple):
    """Values (n), blocks (n), least overheads (n), seconds by slot (n × slots), and limits."""

    values: Floats
    blocks: Floats
    overheads: Floats
    covered: Floats
    slots: Floats
    total: float
    proposal: Ints
    left: Floats


class RestBound:
    """Bounds the rest of one night again and again, as it goes on.

    The program is solved once. Its prices then bound whatever is left of the night: by weak duality
    any prices do, and those of the evening remain good ones, for hundredths of the time.
    """

    def __init__(self, progress: NightProgress) -> None:
        """Bound what ``progress`` leaves to be done."""
        # Read anew each time: what is done and used by then.
        self._progress = progress
        # Of slots, of the whole time and of allocations; None until first asked.
        self._prices: tuple[Floats, float, Floats] | None = None

    def value(self, second: int) -> float | None:
        """Give what no plan from a second on is worth more than; none: scipy is not there."""
        progress = self._progress
        # What is over counts as closed.
        problem, gone = progress.problem, [(0, max(0, second) // MARK_S * MARK_S)]
        allowed = progress.feasibility.run_end >= 0
        if not len(allowed):
            return 0.0
        open_marks = _open_marks(allowed.shape[1], gone)
        program = _make_program(problem, allowed & open_marks, gone)
        program = program._replace(
            # Done is worth nothing more, but stays a column: the prices are by column.
            values=np.where(progress.done, 0.0, program.values),
            left=np.maximum(0.0, program.left - progress.used_s),
        )
        # A visit whose frames are all there already has no block left.
        possible = _possible(program) & (program.values > 0.0) & (program.blocks > 0.0)
        if not possible.any():
            return 0.0
        if self._prices is None:
            # Where nothing is possible the length may be 0.
            lengths = np.where(possible, program.blocks + program.overheads, 1.0)
            worth = np.where(possible, program.values / lengths, 0.0)
            chosen = np.argsort(-worth)[:_IN_PROGRAM]
            try:
                self._prices = _solve(program, chosen[possible[chosen]])
            except ImportError:
                return None
        slots, total, allocation = self._prices
        # Proposals that came later: their allocation is not scarce yet.
        more = np.zeros(len(program.left) - len(allocation))
        prices = (slots, total, np.concatenate([allocation, more]))
        return _dual_bound(program, possible, prices)[0]


def bound_value(
    problem: NightProblem,
    closed: Sequence[tuple[int, int]] = (),
    feasibility: Feasibility | None = None,
) -> float:
    """Give the bound on priority times minutes of shutter of a night.

    Args:
        problem: all its visits, those that arrive later among them.
        closed: from when to when the roof was closed (s of the night).
        feasibility: of the problem, where it is at hand.

    """
    allowed = (feasibility or Feasibility(problem)).run_end >= 0
    if not len(allowed):
        return 0.0
    program = _make_program(problem, allowed & _open_marks(allowed.shape[1], closed), closed)
    possible = _possible(program)
    density = np.where(possible, program.values / (program.blocks + program.overheads), 0.0)
    order = np.argsort(-density)
    order = order[density[order] > 0.0]
    if not order.size:
        return 0.0
    chosen = order[:_IN_PROGRAM]
    best = np.inf
    # What the first prices still find worth its time comes into the program, once.
    for _ in range(2):
        prices = _solve(program, chosen)
        bound, gains = _dual_bound(program, possible, prices)
        best = min(best, bound)
        more = np.setdiff1d(np.flatnonzero(gains > 0.0), chosen)
        if not more.size:
            break
        chosen = np.concatenate([chosen, more])
    return float(best)


def _possible(program: _Program) -> np.ndarray:
    """Tell which visits have room at all; what holds at a mark may hold for a mark round it."""
    return np.asarray(program.covered.sum(1) >= np.maximum(program.blocks - 2 * MARK_S, 1.0))


def _open_marks(marks: int, closed: Sequence[tuple[int, int]]) -> np.ndarray:
    seconds = np.arange(marks) * MARK_S
    is_open = np.ones(marks, np.bool_)
    for begin, end in closed:
        is_open &= ~((seconds >= begin) & (seconds < end))
    return is_open


def _make_program(
    problem: NightProblem, covered: np.ndarray, closed: Sequence[tuple[int, int]]
) -> _Program:
    table = problem.table
    marks = covered.shape[1]
    # Without resuming a block must be whole, and its minutes lie inside a run that holds it.
    if not problem.resume:
        covered = _inside_blocks(covered, table.block_s)
    # The last slot is filled up with marks at which nothing is possible.
    padding = -marks % _SLOT_MARKS
    is_open = np.pad(_open_marks(marks, closed), (0, padding))
    slots = is_open.reshape(-1, _SLOT_MARKS).sum(1) * float(MARK_S)
    by_slot = np.pad(covered, ((0, 0), (0, padding)))
    by_slot = by_slot.reshape(len(covered), -1, _SLOT_MARKS).sum(2) * float(MARK_S)
    by_slot = np.minimum(by_slot, slots)
    # Time at which nothing can be observed is no time that any plan could sell.
    usable = np.minimum(slots, by_slot.max(axis=0))
    overheads = _least_overheads(problem)
    return _Program(
        values=table.value,
        blocks=table.block_s.astype(np.float64),
        overheads=overheads,
        covered=by_slot,
        slots=usable,
        total=float(usable.sum() + overheads.max()),
        proposal=table.proposal,
        left=np.array([limit.seconds_left for limit in problem.proposals]),
    )


def _inside_blocks(allowed: np.ndarray, block_s: Ints) -> np.ndarray:
    """Keep the marks that lie in a run long enough for the whole block, less a mark at each end."""
    covered = np.zeros_like(allowed)
    for row, block in enumerate(block_s):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], allowed[row].astype(np.int8), [0]])))
        for begin, end in edges.reshape(-1, 2):
            if (end - begin + 1) * MARK_S >= block:
                covered[row, begin:end] = True
    return covered


def _least_overheads(problem: NightProblem) -> Floats:
    """Give what any order leaves a visit: nothing where another one has its field and filter."""
    table, instrument = problem.table, problem.instrument
    places = np.stack(
        [
            np.round(table.ra * _FIELDS_PER_DEGREE),
            np.round(table.dec * _FIELDS_PER_DEGREE),
            table.filter_first,
        ],
        axis=1,
    )
    _, field, in_field = np.unique(places[:, :2], axis=0, return_inverse=True, return_counts=True)
    _, same, alike = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    least = np.where(alike[same.ravel()] > 1, 0.0, instrument.filter_change)
    alone = in_field[field.ravel()] == 1
    return np.asarray(np.where(alone, instrument.settle + instrument.acquire, least))


def _solve(program: _Program, chosen: Ints) -> tuple[Floats, float, Floats]:
    """Solve the program over some visits; gives prices of slots, of the total, of allocations."""
    from scipy.optimize import linprog
    from scipy.sparse import csr_matrix

    index, slot = np.nonzero(program.covered[chosen] > 0.0)
    visit = chosen[index]
    count, slots = len(chosen), len(program.slots)
    column = np.arange(len(visit))
    # A visit that is split pays its overhead in parts, in proportion: less than any real plan.
    stretch = 1.0 + program.overheads[visit] / program.blocks[visit]
    one = np.ones(len(visit))
    rows: list[Ints] = [index, count + slot, np.full(len(visit), count + slots)]
    rows.append(count + slots + 1 + program.proposal[visit])
    matrix = csr_matrix(
        (
            np.concatenate([one, one, stretch, one]),
            (np.concatenate(rows), np.tile(column, 4)),
        ),
        shape=(count + slots + 1 + len(program.left), len(visit)),
    )
    total = np.array([program.total])
    limits = [program.blocks[chosen], program.slots, total, program.left]
    solved = linprog(
        -(program.values / program.blocks)[visit],
        A_ub=matrix,
        b_ub=np.concatenate(limits),
        bounds=np.stack([np.zeros(len(visit)), program.covered[visit, slot]], axis=1),
        method="highs",
    )
    # Prices are never negative; the solver's rounding may be.
    dual = np.maximum(0.0, -np.asarray(solved.ineqlin.marginals))
    return dual[count : count + slots], float(dual[count + slots]), dual[count + slots + 1 :]


def _dual_bound(
    program: _Program, possible: np.ndarray, prices: tuple[Floats, float, Floats]
) -> tuple[float, Floats]:
    """Give the bound that follows from any prices, and what each visit earns beyond them."""
    slot_price, total_price, allocation = prices
    rate = program.values / program.blocks
    stretch = 1.0 + program.overheads / program.blocks
    earned = rate[:, None] - slot_price - (total_price * stretch)[:, None]
    earned -= allocation[program.proposal][:, None]
    earned = np.where((program.covered > 0.0) & possible[:, None], earned, 0.0)
    # Each visit takes its best slots first, up to its block: the inner maximum of the dual.
    order = np.argsort(-earned, axis=1)
    best = np.maximum(np.take_along_axis(earned, order, 1), 0.0)
    room = np.take_along_axis(program.covered, order, 1)
    before = np.cumsum(room, axis=1) - room
    used = np.clip(program.blocks[:, None] - before, 0.0, room)
    gains = (best * used).sum(1)
    bound = (slot_price * program.slots).sum() + total_price * program.total
    bound += (allocation * program.left).sum() + gains.sum()
    return float(bound), gains
