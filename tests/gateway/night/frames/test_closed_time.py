"""Darks and biases of requests are taken while the roof is closed, and keep nobody from the sky."""

from __future__ import annotations

import pytest
from night_observatory import PureObservatory, request

from talaia.model.observing.requests import Guiding, ImageType
from talaia.model.observing.states import ObservationState, SuspensionCause
from talaia.wire.frames import CommandPhase, NightPhase

pytestmark = pytest.mark.pure
S, P = ObservationState, NightPhase
RAIN = "Rain: wet"


def world_with(*kinds: ImageType, frames: int = 2, seconds: float = 30.0) -> PureObservatory:
    """Give an armed observatory, in rain, with a request of each kind, named after it."""
    world = PureObservatory()
    world.ask(
        *(
            request(kind.lower(), frames=frames, seconds=seconds, type=kind, guiding=Guiding.OFF)
            for kind in kinds
        )
    )
    world.closing = RAIN
    world.arm()
    return world


def states(world: PureObservatory, name: str) -> list[ObservationState]:
    return [one.state for one in world.changes if one.request == name]


def test_requests_of_darks_and_biases_are_served_in_rain_before_the_own_darks() -> None:
    world = world_with(ImageType.DARK, ImageType.BIAS)
    world.until(lambda: states(world, "dark")[-1:] == [S.COMPLETED])
    # The description's own have other exposures.
    assert {args["seconds"] for args in world.args if "seconds" in args} <= {30.0}
    world.until(lambda: states(world, "bias")[-1:] == [S.COMPLETED])
    assert (len(world.asked("camera/dark")), len(world.asked("camera/bias"))) == (2, 2)
    assert world.changes[-1].frames_done == (2,)
    world.pass_time(120.0)
    assert len(world.asked("camera/dark")) > 2
    # Of a chip that is cooled, once, and under a roof that stays closed.
    assert world.asked("camera/cool")[0] <= world.asked("camera/dark")[0]
    assert len(world.asked("camera/cool")) == 1
    assert world.asked("dome/open") == []
    assert world.executor.night_state().phase is P.CALIBRATING


def test_a_sky_to_observe_comes_first_and_darks_that_were_read_out_are_kept() -> None:
    world = world_with(ImageType.DARK, frames=3, seconds=60.0)
    world.until(lambda: len(world.asked("camera/dark")) == 2)
    light, dark = request("m31"), request("dark", frames=3, seconds=60.0, type=ImageType.DARK)
    world.executor.chooser.replace_requests([light, dark], {"dark": (1,)}, frozenset())
    world.choice = lambda _question: "" if "m31" in world.frames[2:] else "m31"
    world.closing = ""
    world.until(lambda: bool(world.asked("dome/open")))
    (suspended,) = [one for one in world.changes if one.state is S.SUSPENDED]
    assert suspended.frames_done == (1,)
    assert world.asked("camera/abort")[-1] <= world.asked("dome/open")[0]
    world.until(lambda: states(world, "m31")[-1:] == [S.COMPLETED])
    # Under the open roof none is taken; the next rain has the rest.
    assert len(world.asked("camera/dark")) == 2
    world.closing = RAIN
    world.until(lambda: states(world, "dark")[-1] is S.COMPLETED)
    assert len(world.asked("camera/dark")) == 4


def test_in_the_twilight_of_the_evening_darks_are_taken_and_by_day_none() -> None:
    world = world_with(ImageType.DARK)
    world.closing, world.sun = "", 20.0
    world.pass_time(300.0)
    assert world.ledger == []
    world.sun = -2.0
    world.until(lambda: states(world, "dark")[-1:] == [S.COMPLETED])
    # It stays cold for the night that comes, and is let warm once, in its morning.
    world.pass_time(60.0)
    assert world.asked("camera/cooler") == []
    world.sun = -30.0
    world.pass_time(60.0)
    world.sun = -7.0
    world.pass_time(10.0)
    assert len(world.asked("camera/cooler")) == 1
    assert len(world.asked("camera/cool")) == 1


def test_darks_give_way_to_a_person_and_go_on_behind_them() -> None:
    world = world_with(ImageType.DARK)
    world.until(lambda: len(world.asked("camera/dark")) == 1)
    world.person = "Ada"
    world.pass_time(120.0)
    assert world.changes[-1].cause is SuspensionCause.PERSON
    assert len(world.asked("camera/dark")) == 1
    world.person = ""
    world.until(lambda: states(world, "dark")[-1] is S.COMPLETED)


def test_no_dark_is_taken_while_nobody_knows_whether_the_roof_is_closed() -> None:
    world = world_with(ImageType.DARK)
    world.until(lambda: len(world.asked("camera/dark")) == 1)
    world.blind = True
    world.pass_time(5.0)
    assert states(world, "dark")[-1] is S.SUSPENDED
    before = len(world.asked("camera/dark"))
    world.pass_time(300.0)
    assert len(world.asked("camera/dark")) == before


def test_a_camera_that_takes_no_dark_fails_its_request_in_words() -> None:
    world = world_with(ImageType.DARK)
    world.faults["camera/dark"] = CommandPhase.FAILED
    world.until(lambda: S.FAILED in states(world, "dark"))
    assert world.changes[-1].why == "dark 1 of 2: its own words"
    assert len(world.asked("camera/dark")) == world.night.step_tries


def test_the_planner_is_not_asked_for_what_needs_no_sky() -> None:
    world = world_with(ImageType.DARK)
    world.closing = ""
    # A planner that lies: it is told once, and the roof stays closed.
    world.choice = lambda _question: "dark"
    world.until(lambda: states(world, "dark")[-1:] == [S.COMPLETED])
    assert world.asked("dome/open") == []


def test_darks_are_taken_only_of_a_proposal_that_can_pay_for_them() -> None:
    world = world_with(ImageType.DARK, ImageType.BIAS)
    world.executor.chooser.take_hours({"school": 30.0})
    world.pass_time(600.0)
    # Two darks of half a minute are more than it has left; so are two biases of that time here.
    assert states(world, "dark") == states(world, "bias") == []
    # The description's own cost nobody anything.
    assert world.asked("camera/dark")
    world.executor.chooser.take_hours({"school": 80.0})
    world.until(lambda: states(world, "dark")[-1:] == [S.COMPLETED])
