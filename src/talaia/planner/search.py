"""The anytime search for the rest of a night: prices, then beams, the former plan kept at hand.

Each call does a bounded piece of work. What it finds is compared with the former plan, timed anew;
the better by one measure is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.planner.beam_search import (
    BeamShape,
    Field,
    OrderedVisit,
    make_field,
    never_stopped,
    score_order,
    search_beam,
)
from talaia.planner.fairness import FairnessRule, ShareProblem
from talaia.planner.prices import PriceProblem, TimePrices, find_prices
from talaia.planner.sky import MARK_S

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.planner.night_problem import Ints
    from talaia.planner.outlook import WeatherOutlook
    from talaia.planner.progress import NightProgress
    from talaia.planner.sky import Floats

__all__ = ["IDLE", "PROMPT", "THOROUGH", "Effort", "NightSearch"]

# A usual slew between fields (°), for what leads to a block before its neighbours are known.
_USUAL_SLEW = 20.0
# Before prices are known, the best by worth a minute of each half hour are chosen.
_COVER_S = 1800
_COVER_EACH = 60


class Effort(NamedTuple):
    """How much is tried in one call.

    Attributes:
        shapes: of the beams.
        iterations: of the prices.
        candidates: visits that a beam chooses from.

    """

    shapes: tuple[BeamShape, ...]
    iterations: int
    candidates: int


PROMPT = Effort((BeamShape(8, 8, 120, 10_800),), 40, 250)
"""For a decision: some hours ahead."""

THOROUGH = Effort((BeamShape(16, 10, 120), BeamShape(48, 12, 60)), 200, 350)
"""While there is time: the whole night."""

IDLE = (
    THOROUGH,
    Effort((BeamShape(96, 16, 60),), 200, 350),
    Effort((BeamShape(160, 20, 60),), 200, 450),
)
"""One after the other while nobody asks; then it is enough."""
_WHOLE_NIGHT_S = BeamShape().horizon_s


class NightSearch:
    """Searches again and again through one night, each time from what it found before."""

    def __init__(
        self, progress: NightProgress, outlook: WeatherOutlook, fairness: FairnessRule
    ) -> None:
        """Begin without a plan."""
        self._progress = progress
        self._outlook = outlook
        self._fairness = fairness
        self.plan: tuple[OrderedVisit, ...] = ()
        self.method = ""
        self.bound: float | None = None
        self._prices: TimePrices | None = None
        # Of the rounds in idle time, which look from a later second on.
        self._idle_prices: TimePrices | None = None

    def search(
        self,
        second: int,
        effort: Effort,
        *,
        steady: bool = False,
        since: int | None = None,
        stopped: Callable[[], bool] = never_stopped,
    ) -> tuple[OrderedVisit, ...]:
        """Search the rest of the night from ``second`` on; gives the best plan that is known.

        Args:
            second: of the night.
            effort: how much is tried.
            steady: plans are compared by all of the night, so that the new one is worth no less.
            since: from which second on values fade; none: from ``second``.
            stopped: tells that there is no more time; then the former plan stands.

        """
        progress = self._progress
        rows = self._choose_rows(second)
        if not rows.size:
            self.plan, self.method = (), "dispatch"
            return ()
        problem = progress.problem
        marks = np.arange(progress.feasibility.marks, dtype=np.float64) * MARK_S
        weights = self._outlook.weights(marks - float(second if since is None else since))
        blocks = problem.table.block_s[rows]
        values = problem.table.value[rows] * self._outlook.completion(blocks)
        prices = self._prices = self._find_prices(
            second, rows, values, weights, iterations=effort.iterations, stopped=stopped
        )
        worth = (values[:, None] + self._tilted(rows)) * weights
        field = self._make_field(second, rows, worth, prices, most=effort.candidates)
        kept = tuple(step.row for step in self.plan)
        orders = [("kept", kept)]
        for shape in effort.shapes:
            found = search_beam(progress, field, second, shape, stopped=stopped)
            orders.append(("search", tuple(step.row for step in found)))
        if stopped():
            # What was found in a part of the time is worth no comparison.
            return self.plan
        # The first shape's horizon is the measure of all.
        horizon_s = _WHOLE_NIGHT_S if steady else effort.shapes[0].horizon_s
        best, chosen = -np.inf, kept
        for name, order in orders:
            # What was planned before goes on behind what looks less far ahead.
            whole = (*order, *(row for row in kept if row not in order))
            _, score = score_order(
                progress, field, second, order=whole if steady else order, horizon_s=horizon_s
            )
            if score > best + 1e-9:
                best, chosen, self.method = score, whole, name
        self.plan, _ = score_order(progress, field, second, order=chosen, horizon_s=_WHOLE_NIGHT_S)
        return self.plan

    def improve_rest(
        self, second: int, effort: Effort, *, since: int, stopped: Callable[[], bool]
    ) -> None:
        """Search what follows after ``second``; what prices a decision goes by stay as they are."""
        # Those of a later second lack what lies before it.
        prices, self._prices = self._prices, self._idle_prices or self._prices
        try:
            self.search(second, effort, steady=True, since=since, stopped=stopped)
        finally:
            self._idle_prices, self._prices = self._prices, prices

    def lead_with(self, step: OrderedVisit) -> None:
        """Put what is observed now before the rest of the plan."""
        self.plan = (step, *(one for one in self.plan if one.row != step.row))

    def plan_first(self, rows: Sequence[int]) -> None:
        """Begin from an order of visits that was good before."""
        self.plan = tuple(OrderedVisit(row, 0, 0) for row in rows)

    @property
    def prices(self) -> TimePrices | None:
        """Of the newest search; None: there was nothing to choose from."""
        return self._prices

    def price_of(self, begin: int, end: int) -> float:
        """Give what a minute costs between two seconds of the night, as priced last."""
        if self._prices is None or end <= begin:
            return 0.0
        paid = self._prices.until(np.array([begin, end]))
        return float(paid[1] - paid[0]) / (end - begin) * 60.0

    def _tilted(self, rows: Ints) -> Floats:
        """Give what visits earn beside their priority, for the shares of their proposals.

        By the mark at which they begin (visits × marks), or the same at all (visits × 1).
        """
        table, prices = self._progress.problem.table, self._prices
        if prices is None or not prices.tilts.any():
            return np.zeros((len(rows), 1))
        ends, known = prices.tilts.shape
        # One that has just come to the night has lacked nothing yet.
        tilts = np.zeros((ends, len(self._progress.problem.proposals)))
        tilts[:, :known] = prices.tilts
        begins = np.arange(self._progress.feasibility.marks) * MARK_S
        until = np.minimum(np.searchsorted(prices.ends, begins, "right"), ends - 1)
        earned = tilts[:, table.proposal[rows]] * table.shutter_s[rows]
        return np.asarray(earned.T[:, until] if ends > 1 else earned.T)

    def _shares(self, second: int, rows: Ints, values: Floats) -> ShareProblem | None:
        rule, progress = self._fairness, self._progress
        shutter_s = float(progress.problem.table.shutter_s[rows].sum())
        if rule.most <= 0.0 or shutter_s <= 0.0:
            return None
        due = np.array([limit.share for limit in progress.problem.proposals])
        usual = float(values.sum()) / shutter_s
        ends, likely = rule.ends_from(second, progress.problem.length_s)
        # A difference of shares costs the same at each end: a second of it more at a near one.
        whole = float(progress.shutter_s.sum()) + ends - second
        most = rule.most * usual * likely * whole[-1] / np.maximum(whole, 1.0)
        return ShareProblem(due, progress.shutter_s, rule.slack, most, ends)

    def _choose_rows(self, second: int) -> Ints:
        """Choose visits that could begin at all: for each half hour those worth most a minute."""
        progress = self._progress
        rows = progress.candidates(second)
        marks = np.arange(second // MARK_S, progress.feasibility.marks, _COVER_S // MARK_S)
        if not rows.size or not marks.size:
            return rows[:0]
        begin = progress.feasibility.startable(rows, marks)
        fits = begin < marks[None, :] + _COVER_S // MARK_S
        table = progress.problem.table
        rate = table.value[rows] + self._tilted(rows)[:, 0]
        rate = rate / (table.block_s[rows] + self._usual_overhead())
        chosen = np.zeros(len(rows), np.bool_)
        for slot in range(len(marks)):
            here = np.flatnonzero(fits[:, slot])
            if len(here) > _COVER_EACH:
                here = here[np.argpartition(-rate[here], _COVER_EACH)[:_COVER_EACH]]
            chosen[here] = True
        chosen |= np.isin(rows, list(self._kept_rows()))
        return np.asarray(rows[chosen & fits.any(axis=1)])

    def _kept_rows(self) -> frozenset[int]:
        return frozenset(step.row for step in self.plan)

    def _usual_overhead(self) -> float:
        instrument = self._progress.problem.instrument
        return instrument.settle + instrument.acquire + _USUAL_SLEW / instrument.slew_rate

    def _find_prices(
        self,
        second: int,
        rows: Ints,
        values: Floats,
        weights: Floats,
        *,
        iterations: int,
        stopped: Callable[[], bool],
    ) -> TimePrices:
        progress = self._progress
        table = progress.problem.table
        limits = np.array([limit.seconds_left for limit in progress.problem.proposals])
        asked = PriceProblem(
            rows=rows,
            values=values,
            blocks=table.block_s[rows],
            proposal=table.proposal[rows],
            seconds_left=limits - progress.used_s,
            weights=weights,
            second=second,
            overhead=self._usual_overhead(),
            shutters=table.shutter_s[rows],
            shares=self._shares(second, rows, values),
        )
        former = self._prices
        if former is not None and len(former.proposals) != len(limits):
            former = None
        return find_prices(
            progress.feasibility, asked, iterations=iterations, former=former, stopped=stopped
        )

    def _make_field(
        self, second: int, rows: Ints, worth: Floats, prices: TimePrices, *, most: int
    ) -> Field:
        """Leave the visits that come nearest to paying for their time, and those of the plan."""
        table = self._progress.problem.table
        blocks = table.block_s[rows]
        merit = prices.margins / np.sqrt(blocks + self._usual_overhead())
        merit[np.isin(rows, list(self._kept_rows()))] = np.inf
        merit[table.after[rows] >= 0] = np.inf
        best = np.argsort(-merit)[:most]
        rents = prices.rents + prices.proposals[table.proposal[rows]] * blocks
        return make_field(
            self._progress,
            rows[best],
            second=second,
            worth=worth[best],
            rents=rents[best],
            prices=prices,
        )
