"""What a second of each proposal earns or pays, for the shares that are due."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.model.observing.plan import Instrument
from talaia.planner.fairness import EVEN_HANDED, INDIFFERENT, ShareProblem
from talaia.planner.night_problem import FrameRun, NightProblem, ProposalLimit, Visit
from talaia.planner.outlook import WeatherOutlook
from talaia.planner.progress import NightProgress
from talaia.planner.search import THOROUGH, NightSearch
from talaia.planner.sky import TelescopePlace, compute_sky

pytestmark = pytest.mark.pure

DUE = np.array([0.5, 0.5, 0.0])
LENGTH = 14_400
# 2027-01-18, 22:00 UTC.
SKY = compute_sky(TelescopePlace(42.05, 0.73), 1_800_309_600.0, LENGTH)


def shares(got: tuple[float, ...], most: float = 5.0) -> ShareProblem:
    return ShareProblem(
        due=DUE,
        got_s=np.array(got),
        slack=0.1,
        most=np.array([most]),
        ends=np.array([LENGTH]),
    )


def test_who_would_get_too_little_earns_and_who_would_get_too_much_pays():
    asked = shares((0.0, 0.0, 0.0))
    excess = asked.excess(np.array([[9000.0, 1000.0, 0.0]]))
    assert excess[0, 0, 0] == pytest.approx(3000.0)
    assert excess[1, 0, 1] == pytest.approx(3000.0)
    pulls = asked.moved(np.zeros((2, 1, 3)), excess / 3000.0)
    tilts = asked.tilts(pulls)[0]
    assert tilts[0] < 0.0 < tilts[1]
    # Rapid requests: nothing is due to them, and their priority alone counts.
    assert tilts[2] == 0.0


def test_what_was_got_before_counts():
    asked = shares((9000.0, 0.0, 0.0))
    # As much for the other makes it even.
    assert (asked.excess(np.array([[0.0, 9000.0, 0.0]])) < 0.0).all()


def test_what_begins_before_a_nearer_end_is_priced_for_that_and_for_those_behind_it():
    asked = shares((0.0, 0.0, 0.0))._replace(
        most=np.array([5.0, 5.0]), ends=np.array([3600, LENGTH])
    )
    # All for one up to the nearer end, and even in the whole night.
    excess = asked.excess(np.array([[3600.0, 0.0, 0.0], [7200.0, 7200.0, 0.0]]))
    assert (excess[:, 1, :2] < 0.0).all()
    tilts = asked.tilts(asked.moved(np.zeros((2, 2, 3)), excess / 3600.0))
    assert tilts[0, 0] < 0.0 < tilts[0, 1]
    assert (tilts[1] == 0.0).all()


@given(
    st.lists(st.floats(0, 1e5), min_size=6, max_size=6),
    st.lists(st.floats(0, 4), min_size=2, max_size=2),
)
def test_no_price_of_a_share_grows_beyond_its_limit_or_below_nothing(planned, most):
    asked = shares((100.0, 0.0, 0.0))._replace(most=np.array(most), ends=np.array([3600, LENGTH]))
    pulls = np.zeros((2, 2, 3))
    for _ in range(20):
        pulls = asked.moved(pulls, asked.excess(np.array(planned).reshape(2, 3)))
    assert pulls.min() >= 0.0
    assert (pulls.sum(axis=(0, 2)) <= np.array(most) + 1e-9).all()


def test_prices_that_would_be_too_high_together_all_fall_by_the_same():
    asked = shares((0.0, 0.0, 0.0), most=4.0)
    before = np.array([[[3.0, 0.0, 0.0]], [[0.0, 2.5, 0.0]]])
    moved = asked.moved(before, np.full((2, 1, 3), 0.2))
    # 0.2 are left of nothing: they are gone, and 3.2 and 2.7 share the limit.
    assert moved[0, 0, 0] == pytest.approx(2.25)
    assert moved[1, 0, 1] == pytest.approx(1.75)
    assert moved.sum() == pytest.approx(4.0)


def planned_shares(fairness, *, third=False):
    """Plan four hours that one proposal with the higher priority could fill alone."""
    problem = NightProblem(start=0.0, length_s=LENGTH, sky=SKY, instrument=Instrument())
    problem.proposals = [
        ProposalLimit(name, share=0.5, seconds_left=1e6) for name in ("rich", "poor")
    ]
    problem.add_visits(
        tuple(
            Visit(
                id=f"{proposal}{number}",
                ra=100.0 + 2.0 * number,
                dec=30.0,
                runs=(FrameRun(10, 60.0),),
                windows=((0, LENGTH),),
                proposal=proposal,
                priority=10.0 + 3.0 * (proposal == 0),
                shutter_s=600.0,
            )
            for proposal in (0, 1)
            for number in range(30)
        )
    )
    progress = NightProgress(problem)
    search = NightSearch(progress, WeatherOutlook(), fairness)
    search.search(0, THOROUGH)
    rows = [step.row for step in search.plan]
    rows = rows[: len(rows) // 3] if third else rows
    seconds = np.bincount(problem.table.proposal[rows], problem.table.shutter_s[rows], 2)
    return seconds / seconds.sum()


def test_a_plan_keeps_to_what_is_due_when_it_is_asked_to():
    assert planned_shares(INDIFFERENT)[0] > 0.9
    assert planned_shares(EVEN_HANDED)[0] == pytest.approx(0.5, abs=EVEN_HANDED.slack + 0.05)


def test_a_night_that_may_end_sooner_is_even_from_its_beginning():
    shares = planned_shares(EVEN_HANDED, third=True)
    assert shares[0] == pytest.approx(0.5, abs=EVEN_HANDED.slack + 0.1)
