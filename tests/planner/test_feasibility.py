"""Possible starts, against a slow oracle that knows no arrays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from talaia.model.observing.plan import Instrument
from talaia.planner.feasibility import NEVER, Feasibility
from talaia.planner.night_problem import FrameRun, NightProblem, Visit
from talaia.planner.sky import TelescopePlace, compute_sky

pytestmark = pytest.mark.pure

LENGTH = 1800
# 2027-01-18, 22:00 UTC.
SKY = compute_sky(TelescopePlace(42.05, 0.73), 1_800_309_600.0, LENGTH)

windows = st.lists(
    st.tuples(st.integers(0, LENGTH), st.integers(0, LENGTH)).map(sorted).map(tuple),
    min_size=1,
    max_size=3,
)
visits = st.builds(
    Visit,
    id=st.just("v"),
    ra=st.floats(0, 359.99),
    dec=st.floats(-60, 90),
    runs=st.tuples(st.integers(1, 8), st.floats(1, 100)).map(lambda run: (FrameRun(*run),)),
    windows=windows.map(tuple),
    min_altitude=st.sampled_from([0.0, 20.0, 45.0, 60.0]),
    max_airmass=st.sampled_from([1.2, 2.0, 40.0]),
    min_moon_distance=st.sampled_from([0.0, 30.0, 90.0]),
    max_moon_illumination=st.sampled_from([0.1, 1.0]),
)


def feasibility_of(visit: Visit) -> Feasibility:
    problem = NightProblem(start=0.0, length_s=LENGTH, sky=SKY, instrument=Instrument())
    problem.add_visits((visit,))
    return Feasibility(problem)


def slow_start(allowed: np.ndarray, visit: Visit, second: int) -> int:
    """Try every second, and every mark of its block."""
    block = visit.block_s()
    for start in range(second, LENGTH - block + 1):
        inside = any(
            first <= start // 60 * 60 and start + block <= last // 60 * 60
            for first, last in visit.windows
        )
        if inside and allowed[start // 60 : -(-(start + block) // 60) + 1].all():
            return start
    return NEVER


@settings(max_examples=40)
@given(visits, st.integers(0, LENGTH))
def test_the_next_start_is_that_of_the_slow_oracle(visit, second):
    feasibility = feasibility_of(visit)
    expected = slow_start(feasibility.allowed[0], visit, second)
    assert feasibility.next_start(0, second) == expected
    if expected < NEVER:
        assert feasibility.may_start(0, expected)


def test_a_shorter_block_fits_where_the_whole_did_not():
    visit = Visit(id="v", ra=83.8, dec=20.0, runs=(FrameRun(10, 60.0),), windows=((0, 600),))
    feasibility = feasibility_of(visit)
    assert feasibility.next_start(0, 0) == 0
    assert feasibility.next_start(0, 61) == NEVER
    feasibility._problem.table.block_s[0] = 120
    feasibility.update_block(0)
    assert feasibility.next_start(0, 61) == 61
    assert feasibility.next_start(0, 481) == NEVER


def test_a_block_longer_than_any_night_never_starts():
    visit = Visit(id="v", dec=80.0, runs=(FrameRun(10_000, 86_400.0),) * 100, windows=((0, 600),))
    assert feasibility_of(visit).next_start(0, 0) == NEVER


@pytest.mark.parametrize(("beyond", "allowed"), [(0.005, False), (0.02, True)])
def test_the_last_thousandths_of_a_degree_of_the_sun_are_left_to_other_skies(beyond, allowed):
    visit = Visit(
        id="v",
        ra=83.8,
        dec=20.0,
        runs=(FrameRun(1, 1.0),),
        windows=((0, LENGTH),),
        max_sun_altitude=float(SKY.sun_altitude.max()) + beyond,
    )
    assert bool(feasibility_of(visit).allowed.all()) is allowed
