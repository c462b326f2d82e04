"""A night's planning: events in, decisions with reasons out."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from talaia.model.observing.plan import Instrument, VetoCause
from talaia.model.observing.requests import (
    Configuration,
    Constraints,
    GroupOperator,
    Proposal,
    Request,
    RequestGroup,
    Urgency,
    Window,
)
from talaia.model.observing.states import RequestState
from talaia.model.observing.targets import FixedTarget, IcrsTarget, SolarSystemTarget, Target
from talaia.planner.between.overheads import overhead_matrix, overheads_from
from talaia.planner.errors import UnknownRequest
from talaia.planner.from_requests import make_night
from talaia.planner.progress import NightProgress
from talaia.planner.session import PlanningSession
from talaia.planner.sky import TelescopePlace

pytestmark = pytest.mark.pure

MONTSEC = TelescopePlace(42.05, 0.73, 1570.0)
# 2027-01-18, 22:00 UTC: dark, and Orion is high.
EVENING = 1_800_309_600.0
ORION = IcrsTarget(name="M42", ra=83.82, dec=-5.39)
PROPOSALS = [Proposal(id="school", share=1.0, hours_allocated=10.0)]


def request(name: str, target: Target | None = ORION, **more: object) -> Request:
    fields: dict[str, object] = {
        "configurations": (Configuration(filter="V", exposure=60.0, count=3),),
        "windows": (Window(start=EVENING - 86_400, end=EVENING + 86_400),),
        **more,
    }
    return Request(id=name, target=target, **fields)


def group(*requests: Request, **more: object) -> RequestGroup:
    fields: dict[str, object] = {"proposal": "school", **more}
    return RequestGroup(id=f"g-{requests[0].id}", requests=requests, **fields)


def session_of(*groups: RequestGroup) -> PlanningSession:
    problem = make_night(
        MONTSEC, EVENING, instrument=Instrument(), proposals=PROPOSALS, groups=groups
    )
    return PlanningSession(problem)


def test_what_is_worth_most_by_a_minute_is_first_and_says_why():
    session = session_of(group(request("dear"), priority=30.0), group(request("cheap")))
    decision = session.decide(EVENING)
    assert decision.request == "dear"
    # Unparked, settled and centred before the first exposure.
    assert decision.not_before >= EVENING + 20 + 3 + 20
    assert "worth" in decision.reason
    session.complete_request("dear")
    assert session.decide(EVENING + 300).request == "cheap"


def test_turning_the_camera_takes_its_time_and_the_angle_stays_until_another_is_wanted():
    turned = msgspec.structs.replace(ORION, position_angle=350.0)
    other = msgspec.structs.replace(ORION, position_angle=10.0)
    groups = [
        group(request("first", turned), priority=40.0),
        group(request("any"), priority=20.0),
        group(request("last", other)),
    ]
    problem = make_night(
        MONTSEC,
        EVENING,
        instrument=Instrument(rotator_rate=2.0),
        proposals=PROPOSALS,
        groups=groups,
    )
    first, any_angle, last = (problem.table.index[name] for name in ("first", "any", "last"))
    progress = NightProgress(problem)

    def overhead(row: int) -> int:
        return int(overheads_from(problem, progress.pointing, np.array([row]), 0)[0])

    # From the park nobody knows how the camera stands: a quarter of a turn, beside the usual 43 s.
    assert (overhead(first), overhead(any_angle)) == (43 + 45, 43)
    progress.complete_visit(first)
    progress.complete_visit(any_angle)
    # From 350 to 10° it is 20°, and nothing leads to what is of the same field.
    assert overhead(last) == 10
    assert overhead_matrix(problem, np.array([first, last])).tolist() == [[0, 10], [10, 0]]


def test_with_a_closed_roof_nothing_under_the_sky_is_observed():
    session = session_of(group(request("a")))
    session.close_roof("rain")
    decision = session.decide(EVENING)
    assert decision.request == ""
    assert "rain" in decision.reason
    assert session.why_not(EVENING)[0].cause is VetoCause.ROOF
    session.open_roof()
    assert session.decide(EVENING).request == "a"


def test_a_sequence_keeps_its_order():
    session = session_of(
        group(request("first"), request("second"), operator=GroupOperator.SEQUENCE, priority=20.0)
    )
    assert session.decide(EVENING).request == "first"
    (why,) = session.why_not(EVENING, ["second"])
    assert why.cause is VetoCause.SEQUENCE
    session.complete_request("first")
    assert session.decide(EVENING + 300).request == "second"


@pytest.mark.parametrize(
    "ended",
    [RequestState.FAILURE_LIMIT_REACHED, RequestState.WINDOW_EXPIRED, RequestState.CANCELED],
)
def test_what_comes_after_one_that_failed_before_the_night_is_never_released(ended):
    sequence = group(
        request("first", state=ended), request("second"), operator=GroupOperator.SEQUENCE
    )
    session = session_of(sequence, group(request("other"), priority=1.0))
    assert session.decide(EVENING).request == "other"
    assert [block.request for block in session.plan(EVENING).blocks] == ["other"]
    (why,) = session.why_not(EVENING, ["second"])
    assert why.cause is VetoCause.SEQUENCE
    assert "first" in why.sentence
    # One that is complete before the night holds nobody up.
    done = request("done", state=RequestState.COMPLETED)
    after = session_of(group(done, request("next"), operator=GroupOperator.SEQUENCE))
    assert after.decide(EVENING).request == "next"


def test_frames_that_were_read_out_are_not_taken_again():
    session = session_of(group(request("a")))
    whole = session.plan(EVENING).blocks[0]
    session.suspend_request("a", (2,))
    rest = session.plan(EVENING).blocks[0]
    assert whole.end - whole.start == 3 * 65
    assert rest.end - rest.start == 65


def test_a_rapid_request_interrupts_what_is_not_rapid():
    session = session_of(
        group(request("slow")),
        group(request("alert"), urgency=Urgency.RAPID_RESPONSE),
        group(request("other"), urgency=Urgency.RAPID_RESPONSE),
    )
    assert session.interrupt(EVENING, "alert", "slow")
    assert not session.interrupt(EVENING, "slow", "alert")
    assert not session.interrupt(EVENING, "alert", "other")


@pytest.mark.parametrize(
    ("wanted", "cause"),
    [
        (request("x", IcrsTarget(ra=83.82, dec=-80.0)), VetoCause.ALTITUDE),
        (request("x", constraints=Constraints(min_moon_distance=180.0)), VetoCause.MOON_DISTANCE),
        (request("x", constraints=Constraints(max_hour_angle=0.01)), VetoCause.HOUR_ANGLE),
        (
            request("x", windows=(Window(start=EVENING + 600, end=EVENING + 6000),)),
            VetoCause.WINDOW,
        ),
        (
            request("x", windows=(Window(start=EVENING - 600, end=EVENING + 100),)),
            VetoCause.DOES_NOT_FIT,
        ),
        (request("x", FixedTarget(altitude=10.0, azimuth=0.0)), VetoCause.ALTITUDE),
        (
            request("x", configurations=(Configuration(exposure=3600.0, count=11),)),
            VetoCause.ALLOCATION,
        ),
    ],
)
def test_the_first_veto_is_named_in_words(wanted, cause):
    (why,) = session_of(group(wanted)).why_not(EVENING)
    assert why.cause is cause
    assert why.sentence


def test_a_window_that_comes_says_until_when():
    window = Window(start=EVENING + 600, end=EVENING + 6000)
    (why,) = session_of(group(request("x", windows=(window,)))).why_not(EVENING)
    assert why.until == pytest.approx(EVENING + 600, abs=60)
    assert "until 22:10 UTC" in why.sentence


def test_what_is_allowed_and_not_first_names_who_is_ahead():
    session = session_of(group(request("dear"), priority=21.0), group(request("cheap")))
    (why,) = session.why_not(EVENING, ["cheap"])
    assert why.cause is VetoCause.OUTRANKED
    assert why.outranked_by == "dear"
    assert "2.1 times" in why.sentence


def test_bodies_that_move_are_observed_where_they_are():
    # Mars was in Leo, up from the late evening on.
    session = session_of(group(request("mars", SolarSystemTarget(body="mars"))))
    assert session.decide(EVENING).request == "mars"


def test_an_event_about_a_request_that_was_never_given_is_an_error():
    with pytest.raises(UnknownRequest, match="nobody"):
        session_of(group(request("a"))).complete_request("nobody")
