"""What each moment of the rest of the night is worth, and what each visit earns beyond that.

Lagrange's relaxation of "one visit at a time" and of the allocations: with a price for every
moment, each visit takes the place where it earns most; where more than one wants a moment its
price rises, where none does it falls. A plan is then judged by what it pays for the time that it
takes, so that plans of different length compare, and a visit that could be observed later as well
leaves the moment to one that could not. (Subgradient method with Polyak's step, as in Fisher,
*Management Science* 27, 1981.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.planner.beam_search import never_stopped
from talaia.planner.sky import MARK_S

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.planner.fairness import ShareProblem
    from talaia.planner.feasibility import Feasibility
    from talaia.planner.night_problem import Ints
    from talaia.planner.sky import Floats

__all__ = ["CELL_S", "PriceProblem", "TimePrices", "find_prices"]

# Time is priced by cells of this length, and starts are tried by slots (s).
CELL_S = 20
_SLOT_S = 300
_CELLS_IN_MARK = MARK_S // CELL_S
# The first guess at how far the bound is above the best plan.
_AMBITION = 0.08
# Steps without a better bound before that guess becomes smaller.
_PATIENCE = 10
# The prices of allocations move so much less than those of time.
_ALLOCATION_SCALE = 20.0
# And those of shares.
_SHARE_SCALE = 20.0


class PriceProblem(NamedTuple):
    """What is priced.

    Attributes:
        rows: of the visits (n).
        values: of each when complete, at full weight (n).
        blocks: of each (s; n).
        proposal: of each (n).
        seconds_left: of each proposal (s).
        weights: of a value by the mark at which its block begins (marks).
        second: from when on.
        overhead: what leads to a block, typically (s).
        shutters: shutter time of each (s; n).
        shares: who is to get how much of that; none: priorities alone count.

    """

    rows: Ints
    values: Floats
    blocks: Ints
    proposal: Ints
    seconds_left: Floats
    weights: Floats
    second: int
    overhead: float
    shutters: Floats
    shares: ShareProblem | None = None


class TimePrices(NamedTuple):
    """Prices of time.

    Attributes:
        cells: price of each cell of the night.
        summed: price of all cells before each (one more than cells).
        proposals: price of a second of each allocation.
        rents: what each visit earns at its best place (n).
        margins: the same, below zero where it earns nothing (n).
        bound: no plan is worth more, if every visit takes the typical overhead.
        pulls: prices of shares that are too much, and too little; see `ShareProblem`.
        tilts: what a second of each proposal's shutter earns beside its priority, by the end up to
            which it counts; see `ShareProblem`.
        ends: those (s).

    """

    cells: Floats
    summed: Floats
    proposals: Floats
    rents: Floats
    margins: Floats
    bound: float
    pulls: Floats
    tilts: Floats
    ends: Ints

    def until(self, seconds: Ints) -> Floats:
        """Give the price of all time before the given seconds."""
        clipped = np.clip(seconds, 0, len(self.cells) * CELL_S - 1)
        cell = clipped // CELL_S
        part = (clipped - cell * CELL_S) / CELL_S
        return np.asarray(self.summed.take(cell) + part * self.cells.take(cell))


def find_prices(
    feasibility: Feasibility,
    asked: PriceProblem,
    *,
    iterations: int,
    former: TimePrices | None = None,
    stopped: Callable[[], bool] = never_stopped,
) -> TimePrices:
    """Find prices; ``former`` ones are a better beginning than none.

    It is asked before each iteration whether it is ``stopped``; then it gives the best so far.
    """
    places = _Places(feasibility, asked)
    cells, width = places.cells, _SLOT_S // CELL_S
    begins = np.arange(0, cells, width)
    gone = begins < asked.second // CELL_S - width
    if former is not None:
        slots, allocation = former.cells[::width].copy(), former.proposals.copy()
    else:
        slots = np.full(len(begins), _usual_rate(asked) * CELL_S)
        allocation = np.zeros(len(asked.seconds_left))
    shares = asked.shares
    ends = 0 if shares is None else len(shares.ends)
    pulls = np.zeros((2, ends, len(allocation)))
    if former is not None and shares is not None and former.pulls.shape[1] >= ends > 0:
        # Ends that are nearer than the night's own go by, the farthest of them first.
        pulls = shares.moved(former.pulls[:, [*range(ends - 1), -1]], pulls)
    slots[gone] = 0.0
    best_bound, best = np.inf, (slots, allocation, pulls)
    ambition, since = _AMBITION, 0
    for _ in range(iterations):
        if stopped():
            break
        price = np.repeat(slots, width)[:cells]
        tilts = None if shares is None else shares.tilts(pulls)
        bound, slope, spent, planned_s = places.evaluate(_sums(price), allocation, tilts)
        bound += float(price[asked.second // CELL_S :].sum())
        bound += float((allocation * asked.seconds_left).sum())
        if shares is not None:
            bound += shares.paid(pulls)
        if bound < best_bound * (1.0 - 1e-4):
            best_bound, best, since = bound, (slots, allocation, pulls), 0
        else:
            since += 1
            if since >= _PATIENCE:
                ambition, since = ambition * 0.7, 0
        demand = np.add.reduceat(slope, begins)
        excess = (spent - asked.seconds_left) / CELL_S
        # What is free and wanted by nobody stays so.
        demand[gone | ((slots <= 0.0) & (demand < 0.0))] = 0.0
        excess[(allocation <= 0.0) & (excess < 0.0)] = 0.0
        norm = float((demand**2).sum() / width + (excess**2).sum() / _ALLOCATION_SCALE)
        unfair = np.zeros_like(pulls)
        if shares is not None:
            unfair = shares.excess(planned_s) / CELL_S
            unfair[(pulls <= 0.0) & (unfair < 0.0)] = 0.0
            norm += float((unfair**2).sum() / _SHARE_SCALE)
        if norm <= 0.0:
            break
        step = (bound - best_bound * (1.0 - ambition)) / norm
        slots = np.maximum(0.0, slots + step / width * demand)
        allocation = np.maximum(0.0, allocation + step / _ALLOCATION_SCALE / CELL_S * excess)
        if shares is not None:
            pulls = shares.moved(pulls, step / _SHARE_SCALE / CELL_S * unfair)
    slots, allocation, pulls = best
    price = np.repeat(slots, width)[:cells]
    tilts = None if shares is None else shares.tilts(pulls)
    margins = places.margins(_sums(price), allocation, tilts)
    return TimePrices(
        cells=price,
        summed=_sums(price),
        proposals=allocation,
        rents=np.maximum(margins, 0.0),
        margins=margins,
        bound=best_bound,
        pulls=pulls,
        tilts=np.zeros((1, len(allocation))) if tilts is None else tilts,
        ends=places.ends,
    )


def _sums(price: Floats) -> Floats:
    return np.concatenate([[0.0], np.cumsum(price)])


def _usual_rate(asked: PriceProblem) -> float:
    """Give about what a second is worth: that of the last visit that would fit one after one."""
    taken = asked.blocks + asked.overhead
    rate = asked.values / taken
    order = np.argsort(-rate)
    rest = len(asked.weights) * MARK_S - asked.second
    index = int(np.searchsorted(np.cumsum(taken[order]), rest))
    return float(rate[order[min(index, len(order) - 1)]]) * 0.7


class _Places:
    """Where each visit could stand: one place by slot."""

    def __init__(self, feasibility: Feasibility, asked: PriceProblem) -> None:
        self._asked = asked
        self.cells = feasibility.marks * _CELLS_IN_MARK
        width = _SLOT_S // MARK_S
        marks = np.arange(asked.second // MARK_S + 1, feasibility.marks, width)
        begin = feasibility.startable(asked.rows, marks).astype(np.int64)
        fits = begin < marks[None, :] + width
        begin = np.where(fits, begin, 0)
        lead = round(asked.overhead / CELL_S)
        length = np.round(asked.blocks / CELL_S).astype(np.int64)[:, None]
        self._from = np.clip(begin * _CELLS_IN_MARK - lead, 0, self.cells)
        self._to = np.clip(begin * _CELLS_IN_MARK + length, 0, self.cells)
        self._weights = asked.weights[np.minimum(begin, len(asked.weights) - 1)]
        self._worth = np.where(fits, asked.values[:, None] * self._weights, -1e9)
        self._count = np.arange(len(asked.rows))
        # The first end of the night that comes behind each place.
        ends = np.zeros(1, np.int64) if asked.shares is None else asked.shares.ends
        self._until = np.minimum(np.searchsorted(ends, begin * MARK_S, "right"), len(ends) - 1)
        self.ends = ends

    def _gains(self, summed: Floats, allocation: Floats, tilts: Floats | None) -> Floats:
        gains = self._worth - summed.take(self._to) + summed.take(self._from)
        if tilts is not None:
            earned = tilts[self._until, self._asked.proposal[:, None]]
            gains += earned * self._asked.shutters[:, None] * self._weights
        gains -= (allocation[self._asked.proposal] * self._asked.blocks)[:, None]
        return np.asarray(gains)

    def margins(self, summed: Floats, allocation: Floats, tilts: Floats | None) -> Floats:
        return np.asarray(self._gains(summed, allocation, tilts).max(axis=1, initial=-1e9))

    def evaluate(
        self, summed: Floats, allocation: Floats, tilts: Floats | None
    ) -> tuple[float, Floats, Floats, Floats]:
        """Give what all visits earn, and the demand for each cell less one.

        The others are by proposal: what is spent of its allocation, and its shutter time up to each
        end of the night (s).
        """
        gains, count = self._gains(summed, allocation, tilts), len(allocation)
        if not gains.shape[1]:
            nothing = np.zeros((len(self.ends), count))
            return 0.0, np.full(self.cells, -1.0), nothing[0], nothing
        place = gains.argmax(axis=1)
        earned = gains[self._count, place]
        rows = np.flatnonzero(earned > 0.0)
        begin, end = self._from[rows, place[rows]], self._to[rows, place[rows]]
        demand = np.bincount(begin, minlength=self.cells + 1).astype(np.float64)
        demand -= np.bincount(end, minlength=self.cells + 1)
        payers = self._asked.proposal[rows]

        # What lies behind a closing that may come is got only so likely.
        likely = self._asked.shutters[rows] * self._weights[rows, place[rows]]
        spent = np.zeros(count)
        np.add.at(spent, payers, self._asked.blocks[rows])
        group = self._until[rows, place[rows]] * count + payers
        by_end = np.zeros(len(self.ends) * count)
        np.add.at(by_end, group, likely)
        planned_s = np.cumsum(by_end.reshape(-1, count), axis=0)
        return float(earned[rows].sum()), np.cumsum(demand)[:-1] - 1.0, spent, planned_s
