"""A telescope that the roof clears gets ready while the roof opens; any other waits for it."""

from __future__ import annotations

import pytest
from night_observatory import PureObservatory, request

from talaia.model.interlocks.enclosure import ClosingOrder
from talaia.model.interlocks.interlock import Step
from talaia.wire.frames import CommandPhase, NightPhase

pytestmark = pytest.mark.pure
P = NightPhase
CLEAR = [ClosingOrder.PARALLEL, ClosingOrder.CLOSE_FIRST]


def opening(order: ClosingOrder) -> PureObservatory:
    """Give an observatory that has just asked its roof to open."""
    world = PureObservatory(order=order)
    world.ask(request("m31", frames=200))
    world.choice = lambda _question: "m31"
    world.arm()
    world.until(lambda: bool(world.asked("dome/open")))
    return world


@pytest.mark.parametrize("order", CLEAR)
def test_it_is_unparked_and_sent_to_its_first_target_before_the_roof_is_open(order) -> None:
    world = opening(order)
    world.faults["dome/open"] = None
    world.shutter = "opening"
    world.until(lambda: bool(world.asked("telescope/goto")))
    assert world.shutter == "opening"
    assert world.asked("telescope/unpark")
    # No frame before the roof is open.
    world.pass_time(5.0)
    assert world.executor.phase is P.OPENING
    assert not world.frames


def test_one_that_stands_in_the_roofs_way_is_left_parked_until_it_is_open() -> None:
    world = opening(ClosingOrder.MOUNT_FIRST)
    world.faults["dome/open"] = None
    world.shutter = "opening"
    world.pass_time(20.0)
    assert not world.asked("telescope/unpark")
    assert not world.asked("telescope/goto")


def test_a_slew_ahead_that_fails_fails_nothing() -> None:
    world = opening(ClosingOrder.PARALLEL)
    world.faults["telescope/goto"] = CommandPhase.FAILED
    world.until(lambda: world.executor.phase is P.OBSERVING)
    world.faults.clear()
    world.until(lambda: bool(world.frames))
    assert world.events == []


def test_a_telescope_that_is_let_only_under_an_open_roof_waits_for_it() -> None:
    world = opening(ClosingOrder.PARALLEL)
    world.faults |= {"dome/open": None, "telescope/unpark": CommandPhase.REFUSED}
    world.shutter = "opening"
    world.until(lambda: bool(world.asked("telescope/unpark")))
    world.pass_time(10.0)
    assert world.executor.phase is P.OPENING
    world.faults.clear()
    world.shutter = "opened"
    world.until(lambda: bool(world.frames))
    assert world.events == []


def test_rain_while_both_move_closes_and_parks() -> None:
    world = opening(ClosingOrder.PARALLEL)
    world.until(lambda: bool(world.asked("telescope/unpark")))
    world.closing = "rain"
    world.pass_time(60.0)
    assert (world.shutter, world.telescope) == ("closed", "parked")
    assert not world.frames
    assert world.executor.phase in {P.CLOSED, P.CALIBRATING}


def test_a_roof_that_does_not_open_is_a_fault_and_the_telescope_parks_again() -> None:
    world = opening(ClosingOrder.PARALLEL)
    world.faults["dome/open"] = CommandPhase.FAILED
    world.shutter = "closed"
    world.until(lambda: world.executor.phase is P.FAULT)
    world.pass_time(60.0)
    assert (world.shutter, world.telescope) == ("closed", "parked")


def starting(required: list[bool]) -> PureObservatory:
    """Give one whose camera gets ready by such steps, which do not end by themselves."""
    steps = [Step(command="camera/cool", within=30.0, required=one) for one in required]
    world = PureObservatory(start=tuple(steps))
    world.ask(request("m31", frames=200))
    world.choice = lambda _question: "m31"
    world.faults["camera/cool"] = None
    world.arm()
    world.until(lambda: bool(world.asked("camera/cool")))
    return world


def test_what_the_roof_need_not_wait_for_gets_ready_beside_it() -> None:
    world = starting([False])
    world.pass_time(2.0)
    assert world.asked("dome/open")
    # Nothing is observed before it is ready, or has had its time.
    world.pass_time(25.0)
    assert world.shutter == "opened"
    assert world.asked("telescope/unpark")
    assert not world.frames
    world.until(lambda: bool(world.frames))
    assert world.events == []


def test_what_is_required_is_waited_for_with_all_that_stands_before_it() -> None:
    world = starting([False, True, False])
    world.pass_time(20.0)
    assert not world.asked("dome/open")
    # Each has its time, then the roof opens, and the last gets ready beside it.
    world.until(lambda: bool(world.asked("dome/open")))
    assert len(world.asked("camera/cool")) == 2
    world.pass_time(2.0)
    assert len(world.asked("camera/cool")) == 3
    world.until(lambda: bool(world.frames))


def test_filter_and_gain_of_the_first_frame_are_set_while_the_roof_opens() -> None:
    world = PureObservatory()
    world.ask(request("m31", frames=200, filter="R", gain=30.0))
    world.choice = lambda _question: "m31"
    world.faults["wheel/select"] = None
    world.arm()
    world.until(lambda: bool(world.asked("wheel/select")))
    assert world.shutter != "opened"
    # A wheel that hangs fails nothing yet: the block behind it asks again, and judges.
    world.until(lambda: len(world.asked("wheel/select")) == 2)
    assert world.shutter == "opened"
    assert world.events == []
    world.faults.clear()
    world.until(lambda: bool(world.frames))
