"""The chance of a request that nobody has handed in yet, against a forecast that is there. Pure.

A whole new plan of a week takes seconds to minutes. The prices of a plan say as much: what comes
new finds its place where it is worth more than the time that it takes costs there
(`talaia.planner.prices`), for by these prices the plan itself was chosen.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.planner.feasibility import Feasibility
from talaia.planner.from_requests import visits_of
from talaia.planner.night_problem import NightProblem
from talaia.planner.sky import MARK_S
from talaia.planner.week import PRICE_S

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.observing.plan import Instrument
    from talaia.model.observing.requests import RequestGroup
    from talaia.planner.night_problem import Visit
    from talaia.planner.sky import Floats, NightSky
    from talaia.planner.week import NightForecast, WeekForecast

__all__ = ["NewcomerChances", "newcomer_chances"]

_HOUR = 3600.0
# A usual slew between fields (°), as the planner takes it before neighbours are known.
_USUAL_SLEW = 20.0
# How sharply the chance of a place rises where worth and price are about the same: measured, see
# the decision on chances.
_STEEPNESS = 8.0
# One of a group does not push another of the same worth out.
_TAKEN = 2.0


class NewcomerChances(NamedTuple):
    """One request's chances (0 to 1), by night; none: no plan holds what it asks for."""

    nights: tuple[float, ...] | None

    @property
    def tonight(self) -> float | None:
        """In the first night."""
        return self.nights[0] if self.nights else None

    @property
    def week(self) -> float | None:
        """In any of the nights."""
        return min(1.0, sum(self.nights)) if self.nights is not None else None


class _Standing(NamedTuple):
    """Where a request of the group that came before stands: a night, its end and its chance."""

    night: int
    end: int
    chance: float


def newcomer_chances(
    week: WeekForecast,
    find_sky: Callable[[float], tuple[float, int, NightSky]],
    group: RequestGroup,
    instrument: Instrument,
    *,
    now: float,
) -> list[NewcomerChances]:
    """Give the chances of each request of a group, beside what waits already.

    Args:
        week: what waits, as it is forecast.
        find_sky: gives start, length (s) and sky of the night at a time or the next.
        group: what is asked; every request counts as pending.
        instrument: what takes how long.
        now: nothing is observed before (s since the epoch, UTC).

    """
    found: dict[str, list[float]] = {request.id: [] for request in group.requests}
    waiting = dict.fromkeys(found, 1.0)
    planless: set[str] = set()
    standing: dict[str, _Standing] = {}
    for number, night in enumerate(week.nights):
        start, length_s, sky = find_sky(night.plan.night_start + MARK_S)
        problem = NightProblem(start=start, length_s=length_s, sky=sky, instrument=instrument)
        visits = visits_of(problem, (group,)) if length_s else ()
        problem.add_visits(visits)
        market = _Market(problem, night, group.proposal, begin=now)
        for row, visit in enumerate(visits):
            if not visit.needs_sky:
                planless.add(visit.id)
                continue
            before = standing.get(visit.after) if visit.after else _Standing(-1, 0, 1.0)
            chance = 0.0
            if before is not None and waiting[visit.id] > 0.0:
                earliest = before.end if before.night == number else 0
                place = market.best_place(row, visit, earliest=earliest, left=waiting[visit.id])
                chance = place.likely * week.open_share * waiting[visit.id] * before.chance
                if place.likely >= 0.5 and visit.id not in standing:
                    standing[visit.id] = _Standing(number, place.end, week.open_share)
            found[visit.id].append(chance)
            waiting[visit.id] -= chance
        for request in found.values():
            request.extend([0.0] * (number + 1 - len(request)))
    return [
        NewcomerChances(None if name in planless else tuple(chances))
        for name, chances in found.items()
    ]


class _Place(NamedTuple):
    """The best place in a night: how likely the planner takes it (0 to 1), and when it ends."""

    likely: float
    end: int


class _Market:
    """A night's time with its prices; who has found a place makes it dearer for the next."""

    def __init__(
        self, problem: NightProblem, night: NightForecast, proposal: str, *, begin: float
    ) -> None:
        self._problem = problem
        self._feasibility = Feasibility(problem)
        slots = math.ceil(self._feasibility.marks * MARK_S / PRICE_S)
        costs = np.zeros(slots)
        costs[: len(night.prices)] = night.prices[:slots]
        self._costs: Floats = costs
        self._hour_price = night.hour_prices.get(proposal, 0.0)
        self._begin = max(0, math.ceil(begin - problem.start))

    def best_place(self, row: int, visit: Visit, *, earliest: int, left: float) -> _Place:
        instrument, table = self._problem.instrument, self._problem.table
        marks = np.arange(self._feasibility.marks)
        can = self._feasibility.startable(np.array([row]), marks)[0] == marks
        lead = instrument.settle + instrument.acquire + _USUAL_SLEW / instrument.slew_rate
        starts = marks[can] * MARK_S
        starts = starts[starts >= max(earliest, self._begin) + (lead if self._begin else 0.0)]
        if not starts.size:
            return _Place(0.0, 0)
        block = int(table.block_s[row])
        edges = np.arange(len(self._costs) + 1) * float(PRICE_S)
        summed = np.concatenate([[0.0], np.cumsum(self._costs)])
        cost = np.interp(starts + block, edges, summed) - np.interp(starts - lead, edges, summed)
        best = int(np.argmin(cost))
        price = float(cost[best]) + self._hour_price * block / _HOUR
        # What earlier nights have probably done is worth as much less here, as in the forecast.
        worth = float(table.value[row]) * left
        first, last = (starts[best] - lead) / PRICE_S, (starts[best] + block) / PRICE_S
        likely = _likely(worth, price)
        self._raise_price(first, last, worth * likely)
        return _Place(likely, int(starts[best]) + block)

    def _raise_price(self, first: float, last: float, worth: float) -> None:
        """Let what was found cost more than another of its group is worth there."""
        begin, end = max(0, math.floor(first)), max(1, math.ceil(last))
        rate = _TAKEN * worth / max(1.0, last - first)
        self._costs[begin:end] = np.maximum(self._costs[begin:end], rate)


def _likely(worth: float, price: float) -> float:
    if worth <= 0.0:
        return 0.0
    if price <= 0.0:
        return 1.0
    return 1.0 / (1.0 + math.exp(-_STEEPNESS * math.log(worth / price)))
