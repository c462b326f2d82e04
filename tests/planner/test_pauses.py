"""The mount's turn at the meridian, and focus runs: in plans, with their time and their reasons."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from talaia.model.observing.plan import Instrument, PauseKind, PauseRules, PlannedBlock
from talaia.model.observing.requests import (
    Configuration,
    Proposal,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.targets import FixedTarget, IcrsTarget, Target
from talaia.planner.between.pauses import BlockPauses
from talaia.planner.from_requests import make_night
from talaia.planner.session import PlanningSession
from talaia.planner.sky import TelescopePlace

pytestmark = pytest.mark.pure

MONTSEC = TelescopePlace(42.05, 0.73, 1570.0)
# 2027-01-18, 22:00 UTC.
EVENING = 1_800_309_600.0
HOUR = 3600.0
# Since 2000 the meridian has gone on among the stars by so much, at 50° of declination (s).
DRIFT_S = 150.0
RULES = PauseRules(flip=98.0, focus=150.0, focus_every=7200.0)
NO_FLIP = msgspec.structs.replace(RULES, flip=0.0)
NO_FOCUS = msgspec.structs.replace(RULES, focus=0.0)


def group(
    name: str,
    target: Target,
    *parts: tuple[str, int],
    priority: float = 10.0,
    window: tuple[float, float] = (-86_400.0, 86_400.0),
) -> RequestGroup:
    configurations = tuple(
        Configuration(filter=wheel, exposure=120.0, count=count) for wheel, count in parts
    )
    request = Request(
        id=name,
        target=target,
        configurations=configurations,
        windows=(Window(start=EVENING + window[0], end=EVENING + window[1]),),
    )
    return RequestGroup(id=f"g-{name}", proposal="school", requests=(request,), priority=priority)


def session_of(rules: PauseRules, *groups: RequestGroup) -> PlanningSession:
    problem = make_night(
        MONTSEC,
        EVENING,
        instrument=Instrument(),
        pauses=rules,
        proposals=[Proposal(id="school", share=1.0, hours_allocated=20.0)],
        groups=groups,
    )
    return PlanningSession(problem)


def blocks_of(rules: PauseRules, *groups: RequestGroup) -> dict[str, PlannedBlock]:
    return {block.request: block for block in session_of(rules, *groups).plan(EVENING).blocks}


def target_before_meridian(hours: float) -> IcrsTarget:
    """A target that passes the meridian so many hours after the evening."""
    problem = make_night(MONTSEC, EVENING, instrument=Instrument())
    mark = problem.second(EVENING) // 60
    right = np.degrees(problem.sky.sidereal[mark]) + 15.0 * hours * 1.0027
    return IcrsTarget(name="there", ra=float(right % 360.0), dec=50.0)


def test_a_block_that_passes_the_meridian_lasts_as_much_longer_as_the_mount_turns():
    crossing = group("crossing", target_before_meridian(1.0), ("V", 40))
    without = blocks_of(PauseRules(), crossing)["crossing"]
    block = blocks_of(NO_FOCUS, crossing)["crossing"]
    (flip,) = block.pauses
    assert flip.kind is PauseKind.FLIP
    assert "meridian" in flip.reason
    # At the meridian, as far as whole frames let it, or waiting for it before.
    assert flip.start <= EVENING + HOUR + DRIFT_S
    assert flip.end >= EVENING + HOUR - DRIFT_S
    assert block.end - block.start == pytest.approx(
        without.end - without.start + (flip.end - flip.start), abs=2.0
    )


@pytest.mark.parametrize(("hours", "frames"), [(3.0, 10), (-1.0, 40)])
def test_a_block_on_one_side_of_the_meridian_has_no_turn(hours, frames):
    block = blocks_of(NO_FOCUS, group("one", target_before_meridian(hours), ("V", frames)))["one"]
    assert block.pauses == ()


def test_a_mount_that_tracks_beyond_the_meridian_turns_later_and_waits_for_nothing():
    crossing = group("crossing", target_before_meridian(1.0), ("V", 40))
    (early,) = blocks_of(NO_FOCUS, crossing)["crossing"].pauses
    patient = msgspec.structs.replace(NO_FOCUS, flip_after=600.0)
    (late,) = blocks_of(patient, crossing)["crossing"].pauses
    assert EVENING + HOUR + 600.0 - 125.0 - DRIFT_S < late.start <= EVENING + HOUR + 600.0 + DRIFT_S
    assert late.end - late.start == pytest.approx(RULES.flip)
    assert early.end - early.start >= RULES.flip


def test_a_fixed_direction_is_neither_turned_over_nor_focused_on():
    fixed = group("fixed", FixedTarget(altitude=60.0, azimuth=180.0), ("V", 40))
    assert blocks_of(RULES, fixed)["fixed"].pauses == ()


def test_each_filter_is_focused_through_before_its_first_frame_and_again_after_a_while():
    # Near the pole: nothing passes the meridian, and all may begin at any time.
    pole = IcrsTarget(name="pole", ra=30.0, dec=80.0)
    rules = msgspec.structs.replace(NO_FLIP, focus_every=3600.0)
    planned = blocks_of(
        rules,
        group("first", pole, ("V", 10), priority=30.0),
        group("same", pole, ("V", 10), priority=20.0, window=(0.0, 2400.0)),
        group("other", pole, ("R", 45), priority=10.0),
    )
    first, same, other = (planned[name] for name in ("first", "same", "other"))
    # The one whose window ends is first.
    (run,) = same.pauses
    assert run.kind is PauseKind.FOCUS
    assert run.end == same.start
    assert run.reason == "not focused yet in this night"
    # What leads to it has the run in it.
    assert same.start == EVENING + same.overhead
    assert first.pauses == ()
    runs = other.pauses
    assert runs[0].reason == "another filter: R"
    assert [one.reason for one in runs[1:]] == ["some time has passed since the last one"]
    assert runs[1].start - runs[0].end == pytest.approx(3600.0, abs=1.0)
    assert other.end - other.start == pytest.approx(45 * 125.0 + 150.0, abs=1.0)


def test_a_change_of_filter_within_a_block_has_its_focus_run_in_the_blocks_time():
    pole = IcrsTarget(name="pole", ra=30.0, dec=80.0)
    planned = blocks_of(NO_FLIP, group("both", pole, ("V", 5), ("R", 5)))["both"]
    change = Instrument().filter_change
    assert planned.end - planned.start == pytest.approx(10 * 125.0 + change + 150.0, abs=1.0)


def test_what_was_focused_already_is_not_focused_again_and_a_cooling_tube_sooner():
    pole = group("one", IcrsTarget(name="pole", ra=30.0, dec=80.0), ("V", 40))
    session = session_of(NO_FLIP, pole)
    session.set_focus(filter_name="V", time=EVENING - 600.0, every=None)
    assert session.plan(EVENING).blocks[0].pauses == ()
    session.set_focus(filter_name="V", time=EVENING - 600.0, every=2400.0, again="the tube cools")
    runs = session.plan(EVENING).blocks[0].pauses
    assert [one.reason for one in runs] == ["the tube cools"] * len(runs)
    assert runs[0].start == pytest.approx(EVENING + 1800.0, abs=1.0)


def test_a_rapid_request_is_not_promised_before_its_focus_run():
    session = session_of(NO_FLIP, group("one", target_before_meridian(2.0), ("V", 5)))
    decision = session.decide(EVENING)
    session.set_focus(filter_name="V", time=EVENING, every=None)
    assert decision.not_before - session.decide(EVENING).not_before == pytest.approx(150.0)


def test_a_block_whose_turn_no_longer_fits_into_its_window_is_not_planned():
    # Forty frames and what leads to them, and a minute: no time to turn over.
    ends = 40 * 125.0 + 43.0 + 120.0
    target = target_before_meridian(1.0)
    tight = group("tight", target, ("V", 40), window=(0.0, ends))
    assert "tight" in blocks_of(PauseRules(), tight)
    assert "tight" not in blocks_of(NO_FOCUS, tight)


def test_a_mount_and_a_site_without_either_reckon_nothing():
    problem = make_night(MONTSEC, EVENING, instrument=Instrument())
    assert BlockPauses(problem, np.zeros(0, np.int64)).none
