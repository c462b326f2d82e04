"""Forecast of several nights: what would be observed when, and with which chance. Pure.

Each night is planned with what is probably still waiting: a request that an earlier night has
planned counts for as much less as it is probably done by then. What a night plans is observed with
the chance that the roof is open.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.planner.from_requests import make_night, visits_of
from talaia.planner.outlook import CERTAIN
from talaia.planner.session import PlanningSession

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.model.observing.plan import Instrument
    from talaia.model.observing.requests import Proposal, RequestGroup
    from talaia.planner.sky import TelescopePlace

__all__ = ["NightChances", "forecast_nights"]

_DAY = 86_400.0
_HOUR = 3600.0
# What is less likely to be waiting is planned no more.
_LEAST = 0.02
# The share of nights' time in which a usual roof is open.
_OPEN = 0.7


class NightChances(NamedTuple):
    """One night of a forecast.

    Attributes:
        start: (s since the epoch, UTC).
        end: likewise.
        chances: that a request is observed in this night (0 to 1); others have none.

    """

    start: float
    end: float
    chances: Mapping[str, float]


def forecast_nights(
    place: TelescopePlace,
    now: float,
    *,
    instrument: Instrument,
    proposals: Sequence[Proposal] = (),
    groups: Sequence[RequestGroup] = (),
    nights: int = 7,
    open_share: float = _OPEN,
) -> list[NightChances]:
    """Forecast tonight and the nights after it.

    Args:
        place: of the telescope.
        now: (s since the epoch, UTC); a night that has begun counts from then on.
        instrument: what takes how long.
        proposals: with what they have left.
        groups: what waits.
        nights: how many.
        open_share: chance that a visit of a plan can be observed, by weather and faults (0 to 1).

    """
    waiting: dict[str, float] = {}
    limits = {proposal.id: proposal for proposal in proposals}
    found: list[NightChances] = []
    time = now
    for _ in range(nights):
        problem = make_night(place, time, instrument=instrument, proposals=list(limits.values()))
        problem.add_visits(
            tuple(
                replace(visit, priority=visit.priority * waiting.get(visit.id, 1.0))
                for visit in visits_of(problem, groups)
                if waiting.get(visit.id, 1.0) >= _LEAST
            )
        )
        end = problem.unix(problem.length_s)
        session = PlanningSession(problem, outlook=CERTAIN)
        chances: dict[str, float] = {}
        # Where the Sun does not set there is nothing to plan, and a day is counted all the same.
        blocks = session.plan(max(time, problem.start)).blocks if problem.length_s else ()
        for block in blocks:
            left = waiting.get(block.request, 1.0)
            chances[block.request] = left * open_share
            waiting[block.request] = left * (1.0 - open_share)
            visit = problem.table.visits[problem.table.index[block.request]]
            limit = limits.get(problem.proposals[visit.proposal].id)
            if limit is not None:
                hours = (block.end - block.start) / _HOUR * chances[block.request]
                used = min(200_000.0, limit.hours_used + hours)
                limits[limit.id] = msgspec.structs.replace(limit, hours_used=used)
        found.append(NightChances(problem.start, end, chances))
        time = max(end, time + _DAY / 2) + _HOUR
    return found
