"""What no plan can exceed."""

from __future__ import annotations

import pytest

from talaia.model.observing.plan import Instrument
from talaia.planner.bound import bound_value
from talaia.planner.night_problem import FrameRun, NightProblem, ProposalLimit, Visit
from talaia.planner.outlook import CERTAIN
from talaia.planner.session import PlanningSession
from talaia.planner.sky import TelescopePlace, compute_sky

# 2027-01-18, 22:00 UTC.
EVENING = 1_800_309_600.0
LENGTH = 7200
SKY = compute_sky(TelescopePlace(42.05, 0.73), EVENING, LENGTH)


def problem_of(count: int, hours: float = 10.0) -> NightProblem:
    """Visits of ten minutes each round the pole, a degree from one another."""
    problem = NightProblem(
        start=EVENING,
        length_s=LENGTH,
        sky=SKY,
        instrument=Instrument(),
        proposals=[ProposalLimit("p", 1.0, hours * 3600.0)],
    )
    problem.add_visits(
        tuple(
            Visit(
                id=f"v{number}",
                ra=100.0 + number,
                dec=60.0,
                priority=10.0,
                shutter_s=550.0,
                runs=(FrameRun(10, 60.0),),
                windows=((0, LENGTH),),
            )
            for number in range(count)
        )
    )
    return problem


def value_of(problem: NightProblem) -> float:
    session = PlanningSession(problem, outlook=CERTAIN)
    return session.plan(EVENING).value


def test_where_everything_fits_plan_and_bound_are_all_of_it():
    problem = problem_of(4)
    everything = 4 * 10.0 * 550.0 / 60.0
    assert value_of(problem) == pytest.approx(everything)
    assert bound_value(problem) == pytest.approx(everything, rel=1e-6)


def test_a_full_night_is_bounded_by_its_time_and_nearly_filled():
    problem = problem_of(30)
    bound, value = bound_value(problem), value_of(problem)
    # Eleven blocks of ten minutes with their overhead; no order has twelve.
    assert value == pytest.approx(11 * 10.0 * 550.0 / 60.0)
    assert value <= bound < value * 1.1


def test_a_closed_roof_and_a_small_allocation_lower_the_bound():
    open_night = bound_value(problem_of(30))
    assert bound_value(problem_of(30), closed=[(0, LENGTH // 2)]) < 0.55 * open_night
    assert bound_value(problem_of(30, hours=0.5)) == pytest.approx(
        3 * 10.0 * 550.0 / 60.0, rel=0.01
    )


def test_a_plan_says_what_no_plan_of_the_rest_of_the_night_exceeds():
    problem = problem_of(30)
    session = PlanningSession(problem, outlook=CERTAIN)
    plan = session.plan(EVENING)
    assert plan.value <= plan.bound == pytest.approx(bound_value(problem), rel=1e-6)
    # Half of the night later, with what was done in it done.
    for block in plan.blocks:
        if block.end <= EVENING + LENGTH / 2:
            session.complete_request(block.request)
    rest = session.plan(EVENING + LENGTH / 2)
    assert rest.value <= rest.bound
    assert rest.bound == pytest.approx(plan.bound / 2, rel=0.1)
