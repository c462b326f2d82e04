"""Forecast of several nights: what would be observed when, and with which chance. Pure.

Each night is planned with what is probably still waiting: a request that an earlier night has
planned counts for as much less as it is probably done by then. What a night plans is observed with
the chance that the roof is open.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import msgspec

from talaia.model.observing.plan import Plan, WhyNot
from talaia.planner.from_requests import NO_PAUSES, make_night, visits_of
from talaia.planner.outlook import CERTAIN
from talaia.planner.prices import CELL_S
from talaia.planner.session import PlanningSession
from talaia.planner.sky import MARK_S

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.model.observing.plan import Instrument, PauseRules
    from talaia.model.observing.requests import Proposal, RequestGroup
    from talaia.planner.night_problem import NightProblem
    from talaia.planner.sky import TelescopePlace

__all__ = ["OPEN_SHARE", "PRICE_S", "NightForecast", "WeekForecast", "forecast_nights"]

_DAY = 86_400.0
_HOUR = 3600.0
# What is less likely to be waiting is planned no more.
_LEAST = 0.02
OPEN_SHARE = 0.7
"""The share of nights' time in which a usual roof is open."""
PRICE_S = 300
"""Prices of a forecast are of stretches of this length (s)."""


class NightForecast(msgspec.Struct, frozen=True, kw_only=True):
    """One night of a forecast.

    Attributes:
        plan: as it would be with a clear sky.
        chances: that a request is observed in this night (0 to 1); others have none.
        prices: what each `PRICE_S` of the night costs, as value; empty: nothing is planned.
        hour_prices: what an hour of a proposal's time costs beside that, by its name.

    """

    plan: Plan
    chances: dict[str, float]
    prices: tuple[float, ...] = ()
    hour_prices: dict[str, float] = {}


class WeekForecast(msgspec.Struct, frozen=True, kw_only=True):
    """Tonight and the nights after it.

    Attributes:
        made_at: from when on (s since the epoch, UTC).
        open_share: the chance that a visit of a plan can be observed (0 to 1).
        nights: in order.
        reasons: why requests that the first night does not plan are not observed in it.

    """

    made_at: float
    open_share: float
    nights: tuple[NightForecast, ...]
    reasons: tuple[WhyNot, ...]


def forecast_nights(
    place: TelescopePlace,
    now: float,
    *,
    instrument: Instrument,
    pauses: PauseRules = NO_PAUSES,
    proposals: Sequence[Proposal] = (),
    groups: Sequence[RequestGroup] = (),
    nights: int = 7,
    open_share: float = OPEN_SHARE,
) -> WeekForecast:
    """Forecast tonight and the nights after it.

    Args:
        place: of the telescope.
        now: (s since the epoch, UTC); a night that has begun counts from then on.
        instrument: what takes how long.
        pauses: what is done between exposures beside that.
        proposals: with what they have left.
        groups: what waits.
        nights: how many.
        open_share: chance that a visit of a plan can be observed, by weather and faults (0 to 1).

    """
    waiting: dict[str, float] = {}
    limits = {proposal.id: proposal for proposal in proposals}
    found: list[NightForecast] = []
    reasons: tuple[WhyNot, ...] = ()
    time = now
    for _ in range(nights):
        problem = make_night(
            place, time, instrument=instrument, pauses=pauses, proposals=list(limits.values())
        )
        problem.add_visits(
            tuple(
                replace(visit, priority=visit.priority * waiting.get(visit.id, 1.0))
                for visit in visits_of(problem, groups)
                if waiting.get(visit.id, 1.0) >= _LEAST
            )
        )
        session = PlanningSession(problem, outlook=CERTAIN)
        begin = max(time, problem.start)
        plan = _plan_night(problem, session, begin)
        if not found and len(problem.table):
            planned = {block.request for block in plan.blocks}
            # Whole marks count: a window that opens just now counts as open in the next but one.
            said = session.why_not(begin + 2 * MARK_S) if problem.length_s else ()
            reasons = tuple(one for one in said if one.request not in planned)
        chances: dict[str, float] = {}
        for block in plan.blocks:
            left = waiting.get(block.request, 1.0)
            chances[block.request] = left * open_share
            waiting[block.request] = left * (1.0 - open_share)
            visit = problem.table.visits[problem.table.index[block.request]]
            limit = limits.get(problem.proposals[visit.proposal].id)
            if limit is not None:
                hours = (block.end - block.start) / _HOUR * chances[block.request]
                used = min(200_000.0, limit.hours_used + hours)
                limits[limit.id] = msgspec.structs.replace(limit, hours_used=used)
        found.append(_forecast(problem, session, plan, chances))
        time = max(plan.night_end, time + _DAY / 2) + _HOUR
    return WeekForecast(made_at=now, open_share=open_share, nights=tuple(found), reasons=reasons)


def _plan_night(problem: NightProblem, session: PlanningSession, begin: float) -> Plan:
    """Plan it; where the Sun does not set there is nothing to plan, and a day is counted."""
    if not problem.length_s:
        return Plan(made_at=begin, night_start=problem.start, night_end=problem.start)
    return session.plan(begin)


def _forecast(
    problem: NightProblem, session: PlanningSession, plan: Plan, chances: Mapping[str, float]
) -> NightForecast:
    prices = session.time_prices
    if prices is None:
        return NightForecast(plan=plan, chances=dict(chances))
    summed = prices.summed[:: PRICE_S // CELL_S]
    costs = (after - before for before, after in pairwise(summed))
    return NightForecast(
        plan=plan,
        chances=dict(chances),
        prices=tuple(round(float(cost), 6) for cost in costs),
        hour_prices={
            limit.id: round(float(price) * _HOUR, 6)
            for limit, price in zip(problem.proposals, prices.proposals, strict=False)
        },
    )
