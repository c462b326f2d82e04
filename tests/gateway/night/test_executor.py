"""A night runs by itself, and nothing of it opens a roof that may not be open."""

from __future__ import annotations

import pytest
from hypothesis import example, given, settings, strategies as st
from night_observatory import (
    EVENING,
    MOVING,
    SAFE,
    PureObservatory,
    example_site,
    place_of_date,
    request,
)

from talaia.gateway.night.arming import NightArming
from talaia.gateway.night.block_run import SLEWS_BEFORE_FRAME, BlockParts
from talaia.gateway.night.imaging.guide_steps import GUIDE_AGAIN_S
from talaia.gateway.night.night_values import NightView, PlanQuestion
from talaia.gateway.night.roof.unended_commands import GUARD_S
from talaia.gateway.night.target_place import arcseconds_between
from talaia.model.observing.requests import Constraints, Guiding, Urgency
from talaia.model.observing.states import ObservationState, SuspensionCause
from talaia.model.observing.targets import FixedTarget, SolarSystemBody, SolarSystemTarget
from talaia.wire.frames import CommandPhase, NightPhase

pytestmark = pytest.mark.pure
S, P = ObservationState, NightPhase


def planned(*names: str) -> PureObservatory:
    """Give an armed observatory whose planner gives these in order, then nothing."""
    world = PureObservatory()
    world.ask(*(request(name) for name in names))
    ended: set[str] = set()

    def choose(_question: PlanQuestion) -> str:
        ended.update(one.request for one in world.changes if one.state is S.COMPLETED)
        return next((name for name in names if name not in ended), "")

    world.choice = choose
    world.arm()
    return world


def states(world: PureObservatory, name: str) -> list[ObservationState]:
    return [one.state for one in world.changes if one.request == name]


def test_an_armed_night_opens_observes_everything_and_counts_each_frame_once() -> None:
    world = planned("m31", "m33")
    world.until(lambda: len(world.frames) == 6)
    world.pass_time(5)
    assert world.frames == ["m31"] * 3 + ["m33"] * 3
    assert states(world, "m31") == [S.IN_PROGRESS] * 3 + [S.COMPLETED]
    assert world.changes[3].frames_done == (3,)
    # The roof before the telescope, and the cooler before both.
    order = ["camera/cool", "dome/open", "telescope/unpark", "telescope/goto", "camera/expose"]
    assert [name for _, name, _ in world.ledger][:5] == order
    assert world.events == []


def test_a_night_with_nothing_more_to_observe_lets_the_cooler_warm_at_dawn() -> None:
    world = planned("m31")
    world.until(lambda: world.executor.phase is P.OBSERVING)
    world.until(lambda: len(world.frames) == 3)
    world.idle_for = 7200.0
    world.until(lambda: world.shutter == "closed")
    assert world.asked("camera/cooler") == []
    world.sun = -7.0
    world.pass_time(5)
    assert len(world.asked("camera/cooler")) == 1


def test_what_is_held_to_a_limit_waits_while_nobody_knows_and_says_so() -> None:
    world = PureObservatory()
    clear = Constraints(max_clouds=20.0, max_seeing=2.0)
    world.ask(request("m31", constraints=clear), request("m33"))
    # A planner that looks at none of it.
    world.choice = lambda _question: "m31"
    world.unread = frozenset({"clouds"})
    world.arm()
    # What is not held to it is observed meanwhile.
    world.until(lambda: len(world.frames) == 1)
    assert world.frames == ["m33"]
    assert any("nobody knows how cloudy it is; it allows 20 %" in e.message for e in world.events)
    world.until(lambda: len(world.frames) == 3)
    world.pass_time(600)
    assert states(world, "m31") == []
    world.unread, world.clouds = frozenset({"seeing"}), 5.0
    world.pass_time(600)
    assert states(world, "m31") == []
    world.unread, world.seeing = frozenset(), 1.5
    world.until(lambda: "m31" in world.frames)


def test_a_seeing_that_is_too_bad_in_the_centred_field_ends_the_try_before_a_frame() -> None:
    world = PureObservatory(parts=BlockParts(solves=True))
    world.ask(request("m31", constraints=Constraints(max_seeing=2.0)))
    world.choice = lambda _question: "m31" if world.seeing is None else ""
    world.field_seeing = 2.6
    world.arm()
    world.until(lambda: S.SUSPENDED in states(world, "m31"))
    ended = world.changes[-1]
    assert ended.cause is SuspensionCause.WEATHER
    assert ended.why == "the seeing is 2.6″, it allows 2.0″"
    world.pass_time(300)
    # Nothing was exposed for nothing, and nothing counts as failed.
    assert (world.frames, S.FAILED in states(world, "m31")) == ([], False)


def test_frames_that_were_begun_in_a_good_seeing_go_on() -> None:
    world = PureObservatory(parts=BlockParts(solves=True))
    world.ask(request("m31", constraints=Constraints(max_seeing=2.0)))
    world.choice = lambda _question: "m31"
    world.field_seeing = 1.8
    world.arm()
    world.until(lambda: len(world.frames) == 1)
    world.seeing = 2.2
    world.until(lambda: len(world.frames) == 3)
    assert S.SUSPENDED not in states(world, "m31")


def test_darks_are_taken_of_a_chip_that_is_cooled() -> None:
    world = planned("m31")
    world.closing = "Rain: wet"
    world.until(lambda: bool(world.asked("camera/dark")))
    assert world.asked("camera/cool")[0] <= world.asked("camera/dark")[0]


def test_nothing_is_asked_for_while_nobody_has_armed_it() -> None:
    world = PureObservatory()
    world.ask(request("m31"))
    world.choice = lambda _question: "m31"
    world.pass_time(600)
    assert world.ledger == []


def test_it_waits_for_dark_and_closes_at_dawn_whatever_is_under_way() -> None:
    world = planned("m31")
    world.sun = -5.0
    world.pass_time(100)
    assert (world.ledger, world.executor.phase) == ([], P.WAITING)
    world.sun = -13.0
    world.until(lambda: world.executor.phase is P.OBSERVING)
    world.pass_time(30)
    world.sun = -7.5
    world.until(lambda: world.executor.phase is P.WAITING)
    assert (world.shutter, world.telescope) == ("closed", "parked")
    assert states(world, "m31")[-1] is S.SUSPENDED
    # The cooler is let warm, once.
    assert len(world.asked("camera/cooler")) == 1


def test_rain_suspends_keeps_frames_and_counts_no_failure_and_then_it_goes_on() -> None:
    world = planned("m31")
    world.until(lambda: len(world.frames) == 1)
    world.pass_time(20)
    world.closing = "Rain: wet"
    world.pass_time(2)
    assert world.changes[-1].state is S.SUSPENDED
    assert world.changes[-1].cause is SuspensionCause.WEATHER
    assert world.changes[-1].frames_done == (1,)
    assert world.executor.phase in {P.CLOSED, P.CALIBRATING}
    world.pass_time(900)
    # Darks fill the closure.
    assert world.asked("camera/dark")
    assert world.shutter == "closed"
    world.closing = ""
    world.until(lambda: states(world, "m31")[-1] is S.COMPLETED)
    assert world.frames == ["m31"] * 3
    assert S.FAILED not in states(world, "m31")


def test_it_plans_anew_before_it_opens_and_stays_closed_when_there_is_nothing_to_observe() -> None:
    world = planned()
    world.pass_time(600)
    assert world.asked("dome/open") == []


def test_what_is_best_is_asked_anew_as_soon_as_the_roof_is_open() -> None:
    world = planned("m31")
    world.durations["dome/open"] = 2.0
    world.until(lambda: world.executor.phase is P.OBSERVING)
    open_at = world.now
    world.until(lambda: bool(world.asked("telescope/goto")))
    # At once, and not at its next look.
    assert world.asked("telescope/goto")[0] - open_at < 3.0


def test_a_dark_that_is_under_way_is_ended_before_the_roof_opens() -> None:
    world = planned("m31")
    world.closing = "Rain: wet"
    world.pass_time(40)
    assert world.executor.phase is P.CALIBRATING
    world.closing = ""
    world.until(lambda: bool(world.asked("dome/open")))
    assert world.asked("camera/abort")[-1] <= world.asked("dome/open")[0]


def test_three_targets_that_fail_are_a_fault_of_a_device_and_somebody_is_called() -> None:
    world = planned()
    world.ask(*(request(name) for name in ("a", "b", "c", "d")))
    order = iter("abcd")
    world.choice = lambda _question: next(order, "")
    world.faults["telescope/goto"] = CommandPhase.FAILED
    world.until(lambda: world.executor.phase is P.FAULT)
    assert (world.shutter, world.telescope) == ("closed", "parked")
    assert [one.kind for one in world.events] == ["night_fault"]
    assert "d: slewing: its own words" in world.events[0].message
    # Each step was tried twice.
    assert len(world.asked("telescope/goto")) == 6
    before = len(world.ledger)
    world.pass_time(600)
    assert len(world.ledger) == before
    # A person who arms it again has looked.
    world.faults.clear()
    world.choice = lambda _question: "d"
    world.arm()
    world.until(lambda: "d" in world.frames)


def test_one_that_succeeds_in_between_makes_the_count_begin_anew() -> None:
    world = planned()
    world.ask(*(request(name) for name in ("a", "b", "c", "d", "e")))
    # It is asked before it opens, too: what it opens for is chosen anew behind it.
    order = iter("aabcde")

    def choose(_question: PlanQuestion) -> str:
        name = next(order, "")
        world.faults = {} if name == "c" else {"telescope/goto": CommandPhase.FAILED}
        return name

    world.choice = choose
    world.until(lambda: world.executor.phase is P.OBSERVING)
    world.pass_time(1500)
    assert P.FAULT is not world.executor.phase
    assert world.events == []


def test_a_roof_that_does_not_open_is_a_fault_and_is_closed() -> None:
    world = planned("m31")
    world.faults["dome/open"] = None
    world.until(lambda: world.executor.phase is P.FAULT)
    assert len(world.asked("dome/open")) == 2
    assert [one.kind for one in world.events] == ["night_fault"]


def test_a_roof_that_does_not_close_is_asked_again_and_again_and_said() -> None:
    world = planned("m31")
    world.until(lambda: world.executor.phase is P.OBSERVING)
    world.faults["dome/close"] = CommandPhase.FAILED
    world.executor.disarm_night("enough", world.view)
    world.pass_time(300)
    assert world.executor.phase is P.PARKING
    assert len(world.asked("dome/close")) > 8
    assert "night_not_closed" in {one.kind for one in world.events}
    world.faults.clear()
    world.until(lambda: world.executor.night_state().phase is P.DISARMED)
    assert world.shutter == "closed"


def test_a_roof_of_which_nothing_is_known_is_closed() -> None:
    world = planned("m31")
    world.until(lambda: len(world.frames) == 1)
    world.blind = True
    world.pass_time(2)
    assert world.changes[-1].cause is SuspensionCause.FAULT
    world.pass_time(200)
    assert world.asked("telescope/park")
    assert world.asked("dome/close")
    # By its word alone it is not taken for closed.
    assert world.executor.phase is P.PARKING
    world.blind = False
    world.until(lambda: world.executor.phase is not P.PARKING)
    assert world.shutter == "closed"


def leave(world: PureObservatory, cause: str) -> None:
    match cause:
        case "dawn":
            world.sun = -7.5
        case "weather":
            world.closing = "Rain: wet"
        case "nobody may open":
            world.barred = "Weather: nobody knows the wind"
        case "unknown":
            world.blind = True
        case "disarmed":
            world.executor.disarm_night("enough", world.view)
        case "its time is over":
            world.executor.arm_night("ada", EVENING + world.now + 1.0, world.view)
        case _:
            raise AssertionError(cause)


@pytest.mark.parametrize(
    "cause",
    ["dawn", "weather", "nobody may open", "unknown", "disarmed", "its time is over"],
)
def test_the_night_itself_parks_and_closes_though_the_roofs_guard_is_dead(cause: str) -> None:
    world = planned("m31")
    world.guarded = False
    world.until(lambda: len(world.frames) == 1)
    world.pass_time(20)
    leave(world, cause)
    since = world.now
    roof = example_site().enclosures["dome"]
    # Where interlocks close, their guard has its own time first.
    guard = GUARD_S + roof.mount_within + roof.move_within * (1 + roof.retries)
    world.until(lambda: bool(world.asked("dome/close")), guard + 60.0)
    asked = world.asked("dome/close")[0]
    assert world.asked("telescope/park")[0] <= asked
    # At once; a telescope that says nothing is waited for as long as it may take to park.
    at_once = {"dawn": 30.0, "disarmed": 30.0, "its time is over": 30.0}
    at_once["unknown"] = 10.0 + 2 * roof.mount_within
    assert asked - since < at_once.get(cause, guard + 60.0)
    if cause == "unknown":
        world.pass_time(60)
        world.blind = False
    world.until(lambda: world.shutter == "closed" and world.telescope == "parked", 120.0)
    # What was exposed is ended at once, and not before.
    assert world.asked("camera/abort")[0] - since <= 2.0
    assert world.changes[-1].state is S.SUSPENDED
    assert len(world.frames) == 1


def test_a_person_who_acts_is_given_way_to_and_it_goes_on_behind_them() -> None:
    world = planned("m31")
    world.until(lambda: len(world.frames) == 1)
    world.person = "Ada"
    world.pass_time(60)
    assert world.changes[-1].cause is SuspensionCause.PERSON
    asked = len(world.ledger)
    world.pass_time(600)
    assert len(world.ledger) == asked
    assert world.executor.night_state().why == "Ada is at work"
    world.person = ""
    world.until(lambda: states(world, "m31")[-1] is S.COMPLETED)


def test_rain_closes_it_while_a_person_is_at_work_too() -> None:
    world = planned("m31")
    world.until(lambda: world.executor.phase is P.OBSERVING)
    world.person, world.barred = "Ada", "Switch on site: local"
    world.until(lambda: world.shutter == "closed")


def test_somebody_who_closes_the_roof_ends_the_night() -> None:
    world = planned("m31")
    world.until(lambda: len(world.frames) == 1)
    world.shutter, world.person = "closed", "Ada"
    world.until(lambda: world.executor.phase is P.DISARMED)
    assert world.events[-1].kind == "night_disarmed"
    assert world.executor.arming == NightArming()


def test_a_rapid_request_interrupts_and_the_other_goes_on_behind_it() -> None:
    world = planned("m31")
    world.until(lambda: len(world.frames) == 1)
    world.executor.chooser.replace_requests(
        [request("m31"), request("burst", frames=1, urgency=Urgency.RAPID_RESPONSE)],
        {"m31": (1,)},
        frozenset(),
    )
    world.choice = lambda _question: "m31" if "burst" in world.frames else "burst"
    world.until(lambda: "burst" in world.frames)
    assert [one.cause for one in world.changes if one.state is S.SUSPENDED] == [
        SuspensionCause.RAPID
    ]
    world.until(lambda: states(world, "m31")[-1] is S.COMPLETED)
    assert world.frames == ["m31", "burst", "m31", "m31"]


def test_a_rapid_request_that_only_the_planner_refuses_interrupts_nothing() -> None:
    world = planned("m31")
    world.until(lambda: len(world.frames) == 1)
    # The planner knows of the Moon beside it; the simplest rules do not.
    burst = request("burst", frames=1, urgency=Urgency.RAPID_RESPONSE)
    world.executor.chooser.replace_requests([request("m31"), burst], {"m31": (1,)}, frozenset())
    world.until(lambda: states(world, "m31")[-1] is S.COMPLETED)
    assert world.frames == ["m31"] * 3
    assert S.SUSPENDED not in states(world, "m31")


def test_a_rapid_request_that_is_chosen_and_then_refused_interrupts_once_in_a_while() -> None:
    world = planned()
    burst = request("burst", frames=1, urgency=Urgency.RAPID_RESPONSE)
    world.ask(request("m31", frames=200), burst)
    # A planner that says one thing while a block is under way and another when asked for the next.
    world.choice = lambda question: "burst" if question.current else "m31"
    world.until(lambda: bool(world.frames))
    world.pass_time(1500.0)
    assert states(world, "m31").count(S.SUSPENDED) == 1
    assert len(world.frames) > 15


def test_a_rapid_request_interrupts_though_the_planner_is_dead() -> None:
    world = planned("m31")
    world.until(lambda: len(world.frames) == 1)
    world.mute_planner = True
    burst = request("burst", frames=1, urgency=Urgency.RAPID_RESPONSE)
    world.executor.chooser.replace_requests(
        [request("m31", frames=9), burst], {"m31": (1,)}, frozenset()
    )
    world.until(lambda: "burst" in world.frames, 180.0)
    assert states(world, "m31")[-1] is S.SUSPENDED


def test_a_planner_that_says_nothing_is_done_without_and_said_once() -> None:
    world = planned("m31", "m33")
    world.mute_planner = True
    world.until(lambda: len(world.frames) == 6)
    assert [one.kind for one in world.events] == ["night_planner_failed"]


def test_the_simplest_planner_spends_no_more_than_a_proposal_has() -> None:
    world = planned("m31", "m33")
    world.mute_planner = True
    # Three frames of a minute with their readout.
    world.executor.chooser.take_hours({"school": 200.0})
    world.until(lambda: len(world.frames) == 3)
    world.executor.chooser.take_hours({"school": 5.0})
    world.pass_time(900.0)
    assert world.frames == ["m31"] * 3
    # One that nobody knows pays nothing.
    world.executor.chooser.take_hours({"club": 9000.0})
    world.pass_time(900.0)
    assert len(world.frames) == 3


def test_a_planner_that_chooses_what_nobody_can_pay_is_not_believed() -> None:
    world = planned("m31")
    world.executor.chooser.take_hours({"school": 5.0})
    world.pass_time(300.0)
    assert world.frames == []
    assert "school has 0 min left, it needs 3" in world.events[0].message


@pytest.mark.parametrize("lie", ["nothing-like-it", "later"])
def test_a_planner_that_lies_is_not_believed(lie: str) -> None:
    world = planned()
    world.ask(request("m31"), request("later", start=EVENING + 7200.0))
    world.choice = lambda _question: lie
    world.until(lambda: len(world.frames) == 3)
    assert set(world.frames) == {"m31"}
    assert len(world.events) == 1
    assert lie in world.events[0].message


def test_one_night_is_over_at_its_time() -> None:
    world = planned()
    world.ask(request("m31", frames=50))
    world.choice = lambda _question: "m31"
    world.arm(until=EVENING + 300.0)
    world.until(lambda: world.executor.phase is P.DISARMED)
    assert world.shutter == "closed"
    assert world.executor.arm_night("ada", EVENING, world.view) == "that time is over"


def test_a_gateway_that_was_armed_brings_everything_to_rest_before_it_goes_on() -> None:
    world = PureObservatory(arming=NightArming(armed_by="ada"))
    world.shutter, world.telescope = "opened", "idle"
    world.ask(request("m31"))
    world.choice = lambda _question: "m31"
    world.until(lambda: world.executor.phase is P.OBSERVING)
    names = [name for _, name, _ in world.ledger]
    assert names.index("dome/close") < names.index("dome/open")


def test_a_fault_stays_one_over_a_restart() -> None:
    world = PureObservatory(arming=NightArming(fault="three targets failed"))
    world.ask(request("m31"))
    world.choice = lambda _question: "m31"
    world.pass_time(300)
    assert world.executor.phase is P.FAULT
    assert world.ledger == []


def test_an_exposure_of_which_nobody_knows_the_end_is_not_simply_done_once_more() -> None:
    world = planned("m31")
    world.faults["camera/expose"] = CommandPhase.UNKNOWN
    world.until(lambda: S.FAILED in states(world, "m31"))
    assert len(world.asked("camera/expose")) == 1


def allowed(command: str, view: NightView) -> bool:
    """Judge one thing that was asked for, by how things stood then."""
    if command not in MOVING:
        return True
    if view.closing or view.barred or view.sun > -8.0:
        return False
    return command == "dome/open" or view.opened is True


EVENT = st.tuples(
    st.sampled_from(
        (
            *("rain", "dry", "bar", "free", "blind", "sees", "dawn", "night", "person", "alone"),
            *("disarm", "arm", "stuck", "works", "closed", "mute", "speaks"),
        )
    ),
    st.integers(1, 90),
)


def happen(world: PureObservatory, what: str) -> None:
    match what:
        case "rain":
            world.closing = "Rain: wet"
        case "dry":
            world.closing = ""
        case "bar":
            world.barred = "Switch on site: local"
        case "free":
            world.barred = ""
        case "blind" | "sees":
            world.blind = what == "blind"
        case "dawn":
            world.sun = -3.0
        case "night":
            world.sun = -30.0
        case "person":
            world.person = "Ada"
        case "alone":
            world.person = ""
        case "disarm":
            world.executor.disarm_night("enough", world.view)
        case "arm":
            world.arm()
        case "stuck":
            world.faults["dome/close"] = world.faults["telescope/goto"] = CommandPhase.FAILED
        case "works":
            world.faults.clear()
        case "closed":
            world.shutter = "closed"
        case "mute" | "speaks":
            world.mute_planner = what == "mute"
        case _:
            raise AssertionError(what)


@settings(max_examples=60, deadline=None)
@given(events=st.lists(EVENT, max_size=25))
@example(events=[("dry", 4), ("disarm", 20)])
@example(events=[("dry", 24), ("blind", 1), ("dry", 31)])
def test_whatever_happens_nothing_moves_that_may_not_and_it_comes_to_rest(
    events: list[tuple[str, int]],
) -> None:
    world = planned("m31", "m33", "m42")
    for what, seconds in events:
        happen(world, what)
        world.pass_time(seconds)
    wrong = [entry for entry in world.ledger if not allowed(entry[1], entry[2])]
    assert wrong == []
    # Frames are counted once, and none more than was asked for.
    assert all(world.frames.count(name) <= 3 for name in ("m31", "m33", "m42"))
    # Whatever it was: disarmed and with devices that work it ends closed and parked.
    for what in ("works", "sees", "dry", "free", "alone", "disarm"):
        happen(world, what)
    since = len(world.ledger)
    world.until(lambda: world.executor.phase is P.DISARMED, 1200)
    assert {name for _, name, _ in world.ledger[since:]} <= set(SAFE)
    if any(name in MOVING for _, name, _ in world.ledger):
        assert world.shutter == "closed"


def test_a_field_that_cannot_be_centred_fails_its_block_after_its_tries() -> None:
    site = PureObservatory(parts=BlockParts(solves=True))
    site.ask(request("m31"))
    site.choice = lambda _question: "m31"
    site.faults["part/centre"] = CommandPhase.FAILED
    site.arm()
    site.until(lambda: any(one.state is ObservationState.FAILED for one in site.changes))
    assert len(site.asked("part/centre")) == site.night.step_tries
    assert site.frames == []


def test_a_block_goes_on_out_of_focus_and_without_a_guider() -> None:
    due = iter([True])
    site = PureObservatory(
        parts=BlockParts(guides=True, focus_due=lambda _name, _time: next(due, False))
    )
    site.ask(request("m31"))
    site.choice = lambda _question: "m31"
    site.faults |= {f"part/{part}": CommandPhase.FAILED for part in ("focus", "guide", "unguide")}
    site.arm()
    site.until(lambda: any(one.state is ObservationState.COMPLETED for one in site.changes))
    assert len(site.asked("part/focus")) == 1
    assert site.frames == ["m31"] * 3


def observe(site: PureObservatory, name: str) -> None:
    """Let the request be observed to its end."""
    site.choice = lambda _question: name
    site.arm()
    site.until(
        lambda: any(
            one.state in {ObservationState.COMPLETED, ObservationState.FAILED}
            for one in site.changes
        )
    )


def sent(site: PureObservatory) -> list[tuple[float, float]]:
    """Give where the telescope was sent: right ascension (h), declination (°)."""
    return [(args["ra"], args["dec"]) for args in site.args if "ra" in args]


def test_the_telescope_goes_after_the_moon_between_two_frames() -> None:
    moon = SolarSystemTarget(body=SolarSystemBody.MOON)
    site = PureObservatory(parts=BlockParts(solves=True))
    site.ask(request("moon", frames=4, seconds=200.0, target=moon))
    observe(site, "moon")
    slews = site.asked("telescope/goto")
    assert site.frames == ["Moon"] * 4
    # It goes 60″ in two minutes, but is not centred: the stars about it are not its own.
    assert len(slews) == 4
    assert not site.asked("part/centre")
    place = example_site().place
    assert place is not None
    for at, where in zip(slews, sent(site), strict=True):
        there = place_of_date(moon, EVENING + at, place)
        assert there is not None
        assert arcseconds_between(where, there) < 90.0


def test_a_fixed_direction_is_gone_back_to_where_no_command_points_at_it_and_not_for_ever() -> None:
    site = PureObservatory(point=None)
    # Stars pass it by 15″ in each second, so it is gone from wherever a slew ends.
    fixed = FixedTarget(name="pole side", altitude=60.0, azimuth=20.0)
    site.ask(request("fixed", frames=3, target=fixed))
    observe(site, "fixed")
    assert site.frames == ["pole side"] * 3
    assert 3 <= len(site.asked("telescope/goto")) <= 3 * SLEWS_BEFORE_FRAME


def test_a_star_is_not_gone_back_to() -> None:
    site = PureObservatory()
    site.ask(request("m31", frames=3, seconds=600.0))
    observe(site, "m31")
    assert len(site.asked("telescope/goto")) == 1


def test_a_guide_star_that_was_lost_is_held_again_before_the_next_frame() -> None:
    def lost() -> str:
        over = len(site.frames) >= 2 and len(site.asked("part/guide")) < 2
        return "the star is lost" if over else ""

    site = PureObservatory(parts=BlockParts(guides=True, guide_lost=lost))
    site.ask(request("m31", frames=4, guiding=Guiding.ON))
    observe(site, "m31")
    assert site.frames == ["m31"] * 4
    assert len(site.asked("part/guide")) == 2
    # Before the frame that follows, not after it.
    again = site.asked("part/guide")[1]
    assert sum(at < again for at in site.asked("camera/expose")) == 2


def test_a_star_that_stays_lost_fails_a_request_that_must_be_guided() -> None:
    def lost() -> str:
        if not site.frames:
            return ""
        # Asked for before the second frame, and from there on no star is found.
        site.faults["part/guide"] = CommandPhase.FAILED
        return "clouds"

    site = PureObservatory(parts=BlockParts(guides=True, guide_lost=lost))
    site.ask(request("m31", guiding=Guiding.ON))
    observe(site, "m31")
    assert site.changes[-1].state is ObservationState.FAILED
    assert site.frames == ["m31"]


def test_guiding_that_may_be_left_out_is_not_begun_again_before_every_frame() -> None:
    site = PureObservatory(parts=BlockParts(guides=True, guide_lost=lambda: "clouds"))
    site.ask(request("m31", frames=12, seconds=60.0))
    observe(site, "m31")
    begun = site.asked("part/guide")
    assert site.frames == ["m31"] * 12
    assert len(begun) == 2
    assert begun[1] - begun[0] >= GUIDE_AGAIN_S


@pytest.mark.parametrize("after", [1, 10, 19])
def test_a_roof_that_has_just_been_asked_to_open_is_asked_to_close_though_it_is_still_closed(
    after: int,
) -> None:
    site = planned("m31")
    site.until(lambda: bool(site.asked("dome/open")))
    site.pass_time(after)
    assert site.shutter == "closed"
    site.executor.disarm_night("by ada", site.view)
    site.until(lambda: site.executor.phase is P.DISARMED)
    site.pass_time(60)
    assert site.shutter == "closed"
    assert len(site.asked("dome/close")) == 1


def test_a_telescope_that_has_just_been_asked_to_unpark_is_asked_to_park() -> None:
    site = planned("m31")
    site.durations["telescope/unpark"] = 30.0
    site.until(lambda: bool(site.asked("telescope/unpark")))
    assert site.telescope == "parked"
    site.executor.disarm_night("by ada", site.view)
    site.until(lambda: site.executor.phase is P.DISARMED)
    site.pass_time(60)
    assert site.asked("telescope/park")


def test_a_roof_that_nobody_knows_the_opening_of_is_closed_once_that_time_is_over() -> None:
    site = planned("m31")
    # Neither of them is ever answered, and the roof does not stir.
    site.faults |= {"dome/open": None, "dome/close": None}
    site.until(lambda: bool(site.asked("dome/open")))
    site.executor.disarm_night("by ada", site.view)
    site.until(lambda: site.executor.phase is P.DISARMED, 3600)
    assert site.asked("dome/close")
    assert site.shutter == "closed"


def test_the_morning_is_told_what_became_of_the_night() -> None:
    site = planned("m31", "m33")
    site.until(lambda: len(site.frames) == 2)
    site.closing = "rain"
    site.until(lambda: site.executor.phase is P.CLOSED)
    site.pass_time(300.0)
    site.closing = ""
    site.until(lambda: len(site.frames) >= 6)
    site.pass_time(60.0)
    assert site.summaries == []
    site.sun = -5.0
    site.until(lambda: site.executor.phase is P.WAITING)
    site.pass_time(5.0)
    (told,) = site.summaries
    assert told.good
    assert told.message.startswith("2 requests observed, 6 frames: m31, m33; open for ")
    assert told.message.endswith("broken off 1 time: rain")
    # By day nothing more is told, and the next night is counted from its own evening on.
    site.pass_time(600.0)
    site.sun = -30.0
    site.pass_time(60.0)
    site.executor.disarm_night("by ada", site.view)
    site.until(lambda: site.executor.phase is P.DISARMED)
    site.pass_time(5.0)
    assert len(site.summaries) == 2
    assert site.summaries[1].message.startswith("no requests observed, no frames; ")


def test_a_night_that_failed_says_what_to_look_at() -> None:
    site = planned("m31")
    site.faults["dome/open"] = CommandPhase.FAILED
    site.until(lambda: site.executor.phase is P.FAULT)
    site.pass_time(5.0)
    (told,) = site.summaries
    assert not told.good
    assert "to look at: opening the roof" in told.message


def test_whoever_has_not_armed_the_night_is_told_nothing_of_it() -> None:
    site = PureObservatory()
    site.pass_time(60.0)
    site.sun = -5.0
    site.pass_time(60.0)
    assert site.summaries == []
