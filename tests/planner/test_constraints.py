"""What else keeps visits away: the horizon's outline, hour angle, phase, seeing, clouds."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.model.observing.plan import Instrument, VetoCause
from talaia.model.observing.requests import PhaseWindow
from talaia.planner.feasibility import Feasibility, constraint_masks
from talaia.planner.night_problem import FrameRun, NightProblem, ProposalLimit, Visit
from talaia.planner.progress import NightProgress
from talaia.planner.session import PlanningSession
from talaia.planner.sky import MARK_S, TelescopePlace, compute_sky

pytestmark = pytest.mark.pure

LENGTH = 14_400
# 2027-01-18, 22:00 UTC: Castor culminates within these hours.
BEGIN = 1_800_309_600.0
SKY = compute_sky(TelescopePlace(42.05, 0.73), BEGIN, LENGTH)
CASTOR = (113.65, 31.89)


def problem_of(*visits: Visit, **instrument: object) -> NightProblem:
    problem = NightProblem(
        start=BEGIN,
        length_s=LENGTH,
        sky=SKY,
        instrument=Instrument(**instrument),  # type: ignore[arg-type]
    )
    problem.proposals = [ProposalLimit("school", share=1.0, seconds_left=1e6)]
    problem.add_visits(visits)
    return problem


def castor(name: str = "castor", **limits: object) -> Visit:
    ra, dec = CASTOR
    return Visit(
        id=name,
        ra=ra,
        dec=dec,
        runs=(FrameRun(1, 60.0),),
        windows=((0, LENGTH),),
        **limits,  # type: ignore[arg-type]
    )


def mask_of(problem: NightProblem, cause: str) -> np.ndarray:
    return dict(constraint_masks(problem, problem.table.visits))[cause][0]


def azimuth_of_castor() -> np.ndarray:
    return SKY.azimuths(SKY.star_directions(np.array([CASTOR[0]]), np.array([CASTOR[1]])))[0]


def test_a_wall_in_the_east_hides_what_stands_behind_it_and_nothing_in_the_west():
    wall = ((0.0, 0.0), (179.0, 89.0), (180.0, 0.0), (359.0, 0.0))
    problem = problem_of(castor(), horizon_mask=wall)
    azimuth = azimuth_of_castor()
    # It crosses the meridian in these hours, so that both sides are there.
    east, west = (azimuth > 60.0) & (azimuth < 178.0), azimuth > 181.0
    assert east.any()
    assert west.any()
    seen = mask_of(problem, "horizon")
    high = np.degrees(np.arcsin(directions() @ SKY.zenith))[0]
    assert (seen[east] == (high >= azimuth * 89.0 / 179.0)[east]).all()
    assert seen[west].all()


def directions() -> np.ndarray:
    return SKY.star_directions(np.array([CASTOR[0]]), np.array([CASTOR[1]]))


def test_an_hour_angle_is_kept_on_both_sides_of_the_meridian():
    allowed = np.flatnonzero(mask_of(problem_of(castor(max_hour_angle=0.5)), "hour_angle"))
    # Half an hour before to half an hour after it culminates, at a sidereal clock's rate.
    assert len(allowed) * MARK_S == pytest.approx(3590.0, abs=MARK_S)
    highest = int(np.argmax((directions() @ SKY.zenith)[0]))
    assert allowed.mean() == pytest.approx(highest, abs=1.0)


def test_a_phase_that_passes_through_nought_is_met_at_both_of_its_ends():
    period = 7200.0
    wanted = PhaseWindow(epoch=BEGIN, period=period, start=0.75, end=0.25)
    allowed = mask_of(problem_of(castor(phase=wanted)), "phase")
    phase = (np.arange(len(allowed)) * MARK_S / period) % 1.0
    assert (allowed == ((phase >= 0.75) | (phase <= 0.25))).all()
    # A block fits where it ends within it, too.
    assert Feasibility(problem_of(castor(phase=wanted))).next_start(0, 1_800) == 5_400


def test_what_should_be_measured_and_says_nothing_holds_back_what_is_held_to_it():
    problem = problem_of(
        castor("sharp", max_seeing=2.0, shutter_s=60.0),
        castor("clear", max_clouds=20.0, shutter_s=60.0),
        castor("any", shutter_s=60.0),
    )
    session = PlanningSession(problem)

    def planned(*unread: str) -> set[str]:
        session.set_conditions(seeing=None, clouds=None, unread=frozenset(unread))
        return {block.request for block in session.plan(BEGIN + 3600.0).blocks}

    assert planned() == {"sharp", "clear", "any"}
    assert planned("clouds") == {"sharp", "any"}
    assert planned("clouds", "seeing") == {"any"}
    whys = {why.request: why for why in session.why_not(BEGIN + 3600.0)}
    assert whys["sharp"].cause is VetoCause.SEEING
    # It may be known again at any moment, so no word of the night's end.
    assert whys["sharp"].sentence == "nobody knows the seeing now, and it allows 2.0″"
    assert whys["clear"].sentence == "nobody knows how cloudy it is now, and it allows 20 %"
    # As soon as it is known it counts again.
    session.set_conditions(seeing=1.0, clouds=0.0)
    assert {block.request for block in session.plan(BEGIN + 3600.0).blocks} == {
        "sharp",
        "clear",
        "any",
    }


def test_a_limit_on_a_seeing_that_is_measured_in_the_field_is_told_with_the_plan():
    session = PlanningSession(problem_of(castor("sharp", max_seeing=2.0, shutter_s=60.0)))
    words = "whether the seeing is within 2.0″ is seen in its field"
    assert words in session.plan(BEGIN + 3600.0).blocks[0].reason
    session.set_conditions(seeing=1.5, clouds=None)
    assert words not in session.plan(BEGIN + 3600.0).blocks[0].reason


def test_seeing_and_clouds_leave_out_what_they_are_too_bad_for_and_unmeasured_ones_nothing():
    progress = NightProgress(
        problem_of(castor("sharp", max_seeing=2.0), castor("clear", max_clouds=20.0))
    )

    def may() -> list[str]:
        visits = progress.problem.table.visits
        return [visits[row].id for row in progress.candidates(0)]

    assert may() == ["sharp", "clear"]
    assert progress.set_conditions(seeing=3.0, clouds=None)
    assert may() == ["clear"]
    assert progress.set_conditions(seeing=1.5, clouds=60.0)
    assert may() == ["sharp"]
    # The same once more lets nothing else be observed, and is no reason to plan anew.
    assert not progress.set_conditions(seeing=1.6, clouds=70.0)
