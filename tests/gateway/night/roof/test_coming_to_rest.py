"""A night leaves no telescope standing and no roof open behind it, whatever came between."""

from __future__ import annotations

import pytest
from night_observatory import PureObservatory, request

from talaia.gateway.night.arming import NightArming
from talaia.wire.frames import CommandPhase, NightPhase

pytestmark = pytest.mark.pure
P = NightPhase
AT_REST = ("closed", "parked")


def observing() -> PureObservatory:
    """Give an observatory that observes, for as long as it is night."""
    world = PureObservatory()
    world.ask(request("m31", frames=200))
    world.choice = lambda _question: "m31"
    world.arm()
    world.until(lambda: bool(world.frames))
    return world


def stands(world: PureObservatory) -> tuple[str, str]:
    return world.shutter, world.telescope


def test_a_telescope_without_power_parks_when_it_has_it_again_while_the_roof_closes() -> None:
    world = observing()
    world.faults["telescope/park"] = CommandPhase.FAILED
    world.sun = -7.5
    world.until(lambda: bool(world.asked("dome/close")))
    world.faults.clear()
    world.until(lambda: world.executor.phase is P.WAITING)
    assert stands(world) == AT_REST
    assert world.events == []


def test_a_telescope_that_does_not_park_is_a_fault_and_is_asked_until_it_does() -> None:
    world = observing()
    world.faults["telescope/park"] = CommandPhase.FAILED
    world.sun = -7.5
    world.until(lambda: world.executor.phase is P.FAULT)
    world.pass_time(600.0)
    # People are called once.
    assert [one.kind for one in world.events] == ["night_not_parked"]
    world.faults.clear()
    world.pass_time(70.0)
    assert (stands(world), world.executor.phase) == (AT_REST, P.FAULT)
    asked = len(world.ledger)
    world.sun = -30.0
    world.telescope = "idle"
    world.pass_time(600.0)
    # What stands otherwise after that is a person's doing.
    assert len(world.ledger) == asked


def test_a_person_who_sees_to_a_telescope_that_does_not_park_is_left_alone() -> None:
    world = observing()
    world.faults["telescope/park"] = CommandPhase.FAILED
    world.sun = -7.5
    world.until(lambda: world.executor.phase is P.FAULT)
    world.person = "grace"
    world.pass_time(2.0)
    asked = len(world.ledger)
    world.pass_time(300.0)
    assert len(world.ledger) == asked
    # Who opens the roof has it in hand from there on.
    world.shutter = "opened"
    world.pass_time(2.0)
    world.shutter, world.person = "closed", ""
    world.pass_time(300.0)
    assert len(world.ledger) == asked


@pytest.mark.parametrize(
    ("arming", "phase"),
    [
        (NightArming(opened=True), P.DISARMED),
        (NightArming(fault="three targets failed", opened=True), P.FAULT),
        (NightArming(armed_by="ada", opened=True), P.WAITING),
    ],
)
def test_what_a_killed_gateway_was_closing_the_next_one_closes(
    arming: NightArming, phase: NightPhase
) -> None:
    world = PureObservatory(arming=arming)
    world.shutter, world.telescope = "opened", "idle"
    world.until(lambda: world.executor.phase is phase)
    assert stands(world) == AT_REST
    assert world.executor.arming == NightArming(armed_by=arming.armed_by, fault=arming.fault)
    assert world.asked("dome/open") == []


def test_it_is_kept_that_the_roof_was_opened_until_all_is_at_rest() -> None:
    world = observing()
    assert world.executor.arming.opened
    world.executor.disarm_night("enough", world.view)
    assert world.executor.arming == NightArming(opened=True)
    world.until(lambda: world.executor.phase is P.DISARMED)
    assert world.executor.arming == NightArming()
