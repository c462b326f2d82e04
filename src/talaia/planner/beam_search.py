"""Searches the order of visits in continuous time: a beam of partial plans, judged by prices.

Partial plans go side by side through the night, in buckets by the time at which they end. Each is
extended by the visits that pay best for the time that they take; of each bucket the best few are
kept. Everything in a bucket is one set of numpy arrays.

Long, because the pool of partial plans and what extends them share their columns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.planner.between.overheads import overhead_matrix, overheads_from
from talaia.planner.between.pauses import BlockPauses
from talaia.planner.feasibility import NEVER
from talaia.planner.sky import MARK_S

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from talaia.planner.feasibility import Feasibility
    from talaia.planner.night_problem import Ints
    from talaia.planner.prices import TimePrices
    from talaia.planner.progress import NightProgress
    from talaia.planner.sky import Floats

__all__ = [
    "BeamShape",
    "Field",
    "OrderedVisit",
    "make_field",
    "never_stopped",
    "score_order",
    "search_beam",
]


def never_stopped() -> bool:
    """Let a search come to its end."""
    return False


class OrderedVisit(NamedTuple):
    """One visit of a plan: its row, first exposure and last readout (s of the night)."""

    row: int
    start: int
    end: int


class BeamShape(NamedTuple):
    """How widely is searched.

    Attributes:
        width: partial plans that are kept of each bucket.
        branches: extensions of each.
        bucket_s: length of a bucket (s).
        horizon_s: how far ahead (s); beyond it, prices stand for the rest of the night.

    """

    width: int = 8
    branches: int = 8
    bucket_s: int = 120
    horizon_s: int = 86_400


class Field(NamedTuple):
    """What a search chooses from, as arrays over its ``n`` candidates.

    Attributes:
        rows: of the visits.
        worth: of each when complete, by the mark at which its block begins (n × marks).
        rents: of each, with the price of its allocation.
        blocks: (s).
        between: overhead from each to each; the last line: from where the telescope points.
        proposal: of each.
        left: of each proposal's allocation (s).
        prices: of time.
        after: index of the candidate that comes before in a sequence; -1: none.
        pauses: of the candidates' blocks.

    """

    rows: Ints
    worth: Floats
    rents: Floats
    blocks: Ints
    between: Ints
    proposal: Ints
    left: Floats
    prices: TimePrices
    after: Ints
    pauses: BlockPauses


def make_field(
    progress: NightProgress,
    rows: Ints,
    *,
    second: int,
    worth: Floats,
    rents: Floats,
    prices: TimePrices,
) -> Field:
    """Gather what a search from ``second`` on needs of some visits."""
    problem = progress.problem
    table = problem.table
    # The last line is the way from where the telescope points now, so that the first visit of a
    # plan is looked up as any other.
    between = np.empty((len(rows) + 1, len(rows)), np.int64)
    between[:-1] = overhead_matrix(problem, rows)
    between[-1] = overheads_from(problem, progress.pointing, rows, second)
    local = {int(row): index for index, row in enumerate(rows)}
    before = table.after[rows]
    # A predecessor that is no candidate is never complete in this plan: so is its successor.
    after = [
        -1 if done else local.get(int(row), index)
        for index, (row, done) in enumerate(zip(before, progress.are_released(rows), strict=True))
    ]
    limits = np.array([limit.seconds_left for limit in problem.proposals])
    return Field(
        rows=rows,
        worth=worth,
        rents=rents,
        blocks=table.block_s[rows],
        between=between,
        proposal=table.proposal[rows],
        left=limits - progress.used_s,
        prices=prices,
        after=np.array(after, np.int64),
        pauses=BlockPauses(problem, rows),
    )


class _Pool:
    """Partial plans that wait in buckets, by the time at which they end."""

    def __init__(self, buckets: int, room: int) -> None:
        # How many plans wait in each bucket; what lies beyond means nothing.
        self.counts = np.zeros(buckets, np.int64)
        # Of each bucket. Four times what one step can bring: more would be chosen from for nothing.
        self._room = room
        # When each plan ends, and when its last visit begins (s of the night).
        self.end = np.zeros((buckets, room), np.int64)
        self.start = np.zeros((buckets, room), np.int64)
        # The visit that it ends with, and the number of the kept plan that it extends.
        self.last = np.zeros((buckets, room), np.int64)
        self.parent = np.zeros((buckets, room), np.int64)
        # What it earns beyond the prices of its time.
        self.score = np.zeros((buckets, room))
        # Which visits it has, as one number; see `_Search`.
        self.mark = np.zeros((buckets, room), np.uint64)

    def insert(self, bucket: Ints, columns: tuple[NDArray[np.generic], ...]) -> None:
        """Add plans to their buckets; what has no room is dropped."""
        # Grouped by bucket: how far each stands behind the first of its group is its place there.
        order = np.argsort(bucket, kind="stable")
        sorted_bucket = bucket[order]
        first = np.searchsorted(sorted_bucket, sorted_bucket)
        place = np.arange(len(order)) - first + self.counts[sorted_bucket]
        fits = place < self._room
        order, sorted_bucket, place = order[fits], sorted_bucket[fits], place[fits]
        targets = (self.end, self.start, self.last, self.parent, self.score, self.mark)
        for target, column in zip(targets, columns, strict=True):
            target[sorted_bucket, place] = column[order]
        self.counts += np.bincount(sorted_bucket, minlength=len(self.counts))

    def select(self, bucket: int, width: int) -> Ints:
        """Give the places of the best plans of a bucket, no two of the same visits."""
        count = int(self.counts[bucket])
        # Three times as many as are kept: the same visits in another order often end together.
        order = np.argsort(-self.score[bucket, :count])[: 3 * width]
        _, first = np.unique(self.mark[bucket, order], return_index=True)
        return np.asarray(order[np.sort(first)[:width]])


def search_beam(
    progress: NightProgress,
    field: Field,
    second: int,
    shape: BeamShape,
    *,
    stopped: Callable[[], bool] = never_stopped,
) -> tuple[OrderedVisit, ...]:
    """Search from ``second`` on; gives the best plan.

    It is asked after each bucket whether it is ``stopped``; then it gives the best so far.
    """
    if not field.rows.size:
        return ()
    return _Search(progress, field, second, shape).run(stopped)


class _Search:
    def __init__(
        self, progress: NightProgress, field: Field, second: int, shape: BeamShape
    ) -> None:
        self._feasibility = progress.feasibility
        self._field, self._shape, self._second = field, shape, second
        self._horizon = min(progress.problem.length_s, second + shape.horizon_s)
        count = len(field.rows)
        # One more for what ends after the last whole bucket, one for the night's very end.
        buckets = (progress.problem.length_s - second) // shape.bucket_s + 2
        self._pool = _Pool(buckets, shape.width * shape.branches * 4)
        # All plans that can ever be kept, and the empty one that all begin with.
        most = buckets * shape.width + 1
        # Of each kept plan: which visits it has, and what it spent of each allocation (s).
        self._used = np.zeros((most, count), np.bool_)
        self._spent = np.zeros((most, len(field.left)))
        # Of each: through which filter it was focused last, and when.
        self._focus = np.empty((most, 2), np.int64)
        self._focus[0] = progress.focus
        # Of each: the plan that it extends, its visit, begin and end: the way back at the end.
        self._steps = np.zeros((most, 4), np.int64)
        self._states = 0
        # The best total so far, and the number of its plan; 0 is the plan that does nothing.
        self._best = (-np.inf, 0)
        # One random number for each visit: the sum over a plan says which visits it has.
        self._marks = np.random.default_rng(1).integers(1, 2**63, count, dtype=np.uint64)
        # To the night's end nothing is left to be priced: what a plan is worth is what counts.
        self._whole_night = self._horizon >= progress.problem.length_s
        self._worth = np.zeros(most)
        # Candidates that wait for another one; mostly there are none, and nothing is looked up.
        self._in_order = np.flatnonzero(field.after >= 0)
        # Where each candidate's row begins in `worth`, laid out flat.
        self._offsets = np.arange(count) * field.worth.shape[1]

    def run(self, stopped: Callable[[], bool]) -> tuple[OrderedVisit, ...]:
        count = len(self._field.rows)
        self._states = 1
        # The empty plan: `count` is the line of `between` that begins where the telescope points.
        self._steps[0] = (-1, count, self._second, self._second)
        self._extend(
            np.array([0]),
            np.array([self._second]),
            last=np.array([count]),
            score=np.array([0.0]),
            mark=np.zeros(1, np.uint64),
        )
        pool, shape = self._pool, self._shape
        # Plans that end beyond the horizon are finished, but not extended.
        last = (self._horizon - self._second) // shape.bucket_s
        # One pass, for time goes on; what ends in the bucket that it began in is dropped.
        for bucket in range(len(pool.counts)):
            if not pool.counts[bucket]:
                continue
            if stopped():
                break
            chosen = pool.select(bucket, shape.width)
            number = self._keep(bucket, chosen)
            end, score = pool.end[bucket, chosen], pool.score[bucket, chosen]
            self._finish(score, end, number)
            if bucket <= last:
                visits = pool.last[bucket, chosen]
                mark = pool.mark[bucket, chosen]
                self._extend(number, end, last=visits, score=score, mark=mark)
        return self._trace(self._best[1])

    def _keep(self, bucket: int, chosen: Ints) -> Ints:
        """Store partial plans; gives their numbers."""
        pool = self._pool
        number = np.arange(self._states, self._states + len(chosen))
        self._states += len(chosen)
        parent, visit = pool.parent[bucket, chosen], pool.last[bucket, chosen]
        self._used[number] = self._used[parent]
        self._used[number, visit] = True
        self._spent[number] = self._spent[parent]
        self._spent[number, self._field.proposal[visit]] += self._field.blocks[visit]
        mark = pool.start[bucket, chosen] // MARK_S
        self._worth[number] = self._worth[parent] + self._field.worth[visit, mark]
        if not self._field.pauses.none:
            start, end = pool.start[bucket, chosen], pool.end[bucket, chosen]
            self._focus[number] = _focus_after(
                self._field, self._focus[parent], visit, (start, end)
            )
        self._steps[number, 0] = parent
        self._steps[number, 1] = visit
        self._steps[number, 2] = pool.start[bucket, chosen]
        self._steps[number, 3] = pool.end[bucket, chosen]
        return number

    def _finish(self, score: Floats, end: Ints, number: Ints) -> None:
        """Remember the plan that is best if nothing follows up to the horizon."""
        if self._whole_night:
            total = self._worth[number]
        else:
            prices = self._field.prices
            # Time that a plan leaves free up to the horizon has its price, and never earns by it.
            rest = prices.until(np.array([self._horizon])) - prices.until(end)
            total = score - np.maximum(rest, 0.0)
        best = int(np.argmax(total))
        if total[best] > self._best[0]:
            self._best = (float(total[best]), int(number[best]))

    def _extend(
        self,
        number: Ints,
        end: Ints,
        *,
        last: Ints,
        score: Floats,
        mark: NDArray[np.uint64],
    ) -> None:
        field = self._field
        # All plans of the bucket by all candidates at once: one matrix for each quantity.
        begin = end[:, None] + field.between[last]
        start, finish = _timed_blocks(self._feasibility, field, begin, focus=self._focus[number])
        never = start >= NEVER
        # Any mark that may be looked up; these are ruled out below.
        start[never] = 0
        paid = field.prices.until(finish) - field.prices.until(end)[:, None]
        gain = field.worth.take(self._offsets + start // MARK_S) - field.rents - paid
        never |= self._used[number]
        if self._in_order.size:
            before = field.after[self._in_order]
            never[:, self._in_order] |= ~self._used[number][:, before]
        # What rounding leaves is no reason to refuse the last block of an allocation.
        spent = self._spent[number][:, field.proposal] + field.blocks
        never |= spent > field.left[field.proposal] + 1e-6
        gain[never] = -np.inf
        # Between gain for each second, which favours short visits, and gain alone, which favours
        # long ones.
        key = gain / np.sqrt(finish - end[:, None])
        # Which are the best few, not in which order: they need not be sorted.
        branches = min(self._shape.branches, key.shape[1])
        child = np.argpartition(-key, branches - 1, axis=1)[:, :branches]
        plan = np.repeat(np.arange(len(number)), branches)
        child = child.ravel()
        # Where fewer are possible than branches are asked for, the rest were ruled out.
        good = gain[plan, child] > -np.inf
        plan, child = plan[good], child[good]
        ends = finish[plan, child]
        self._pool.insert(
            (ends - self._second) // self._shape.bucket_s,
            (
                ends,
                start[plan, child],
                child,
                number[plan],
                score[plan] + gain[plan, child],
                mark[plan] + self._marks[child],
            ),
        )

    def _trace(self, number: int) -> tuple[OrderedVisit, ...]:
        steps = []
        # Number 0 is the empty plan.
        while number > 0:
            parent, visit, start, end = (int(part) for part in self._steps[number])
            steps.append(OrderedVisit(int(self._field.rows[visit]), start, end))
            number = parent
        return tuple(reversed(steps))


def _timed_blocks(
    feasibility: Feasibility, field: Field, begin: Ints, *, focus: Ints, only: int | None = None
) -> tuple[Ints, Ints]:
    """Give when blocks begin and end that could be begun at seconds (plans × candidates).

    ``focus`` has the last focus run of each plan: its filter and its second. Of one candidate
    only, where ``only`` says which.
    """
    pauses = field.pauses
    index = np.arange(len(field.rows)) if only is None else np.array([only])
    rows, blocks = field.rows[index], field.blocks[index]
    if pauses.none:
        start = feasibility.earliest_starts(rows[None, :], begin)
        return start, start + blocks
    index = index[None, :]
    # Columns, so that each plan stands against every candidate.
    filters, focused = focus[:, :1], focus[:, 1:]
    due = pauses.focus_due(index, begin, filters, focused)
    start = feasibility.earliest_starts(rows[None, :], begin + pauses.focus_s * due)
    longer = pauses.block_seconds(index, start, np.where(due, start, focused))
    # What would then end behind its window or its sky is not begun.
    fits = feasibility.lasts_until(rows[None, :], start, longer)
    start = np.where(fits, start, NEVER)
    return start, start + blocks + longer


def _focus_after(field: Field, focus: Ints, visit: Ints, times: tuple[Ints, Ints]) -> Ints:
    """Give the last focus run of each plan (plans × 2) after its new last visit."""
    pauses, (start, end) = field.pauses, times
    filters, focused = focus[:, 0], focus[:, 1]
    due = pauses.focus_due(visit, start - pauses.focus_s, filters, focused)
    since = pauses.focused_after(visit, start, end, np.where(due, start, focused))
    # A block of several filters ends in focus for its last one.
    changes = due | (pauses.first[visit] != pauses.last[visit])
    return np.stack([np.where(changes, pauses.last[visit], filters), since], axis=1)


def score_order(
    progress: NightProgress, field: Field, second: int, *, order: tuple[int, ...], horizon_s: int
) -> tuple[tuple[OrderedVisit, ...], float]:
    """Time visits one after the other; gives the plan and its score.

    The score of a whole night is what its visits are worth; up to a nearer horizon, what they earn
    beyond the prices of the time. Visits that are no candidates any more, or no longer fit, are
    left out.
    """
    local = {int(row): index for index, row in enumerate(field.rows)}
    horizon = min(progress.problem.length_s, second + horizon_s)
    left = field.left.copy()
    steps: list[OrderedVisit] = []
    time, last, worth, rents = second, len(field.rows), 0.0, 0.0
    focus = np.array([progress.focus], np.int64)
    for row in order:
        index = local.get(row)
        if index is None or time > horizon or left[field.proposal[index]] < field.blocks[index]:
            continue
        begin = np.array([[time + int(field.between[last, index])]])
        starts, ends = _timed_blocks(progress.feasibility, field, begin, focus=focus, only=index)
        start, end = int(starts[0, 0]), int(ends[0, 0])
        if start >= NEVER:
            continue
        if not field.pauses.none:
            focus = _focus_after(field, focus, np.array([index]), (starts[0], ends[0]))
        worth += float(field.worth[index, start // MARK_S])
        rents += float(field.rents[index])
        left[field.proposal[index]] -= field.blocks[index]
        steps.append(OrderedVisit(row, start, end))
        time, last = end, index
    if horizon >= progress.problem.length_s:
        return tuple(steps), worth
    paid = field.prices.until(np.array([second, max(time, horizon)]))
    return tuple(steps), worth - rents - float(paid[1] - paid[0])
