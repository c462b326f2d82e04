"""The camera is turned to the angle that a request asks for, before its field is centred."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace
from night_observatory import PureObservatory, request

from talaia.gateway.night.block_run import BlockParts
from talaia.model.night_frames import NightField, RotatorCommand
from talaia.model.observing.requests import RequestGroup
from talaia.model.observing.states import ObservationState
from talaia.wire.frames import CommandPhase

pytestmark = pytest.mark.pure
ROTATOR = RotatorCommand(command="rotator/goto", argument="angle", reading="rotator/angle")


def field_with(rotator: RotatorCommand | None) -> NightField:
    return NightField(width=0.4, height=0.3, rotator=rotator)


def panel(name: str, angle: float | None, **asked: float) -> RequestGroup:
    """Ask for a field at a position angle (°)."""
    group = request(name, frames=1, **asked)
    (one,) = group.requests
    turned = replace(one, target=replace(one.target, position_angle=angle))
    return replace(group, requests=(turned,))


def observed(site: PureObservatory, *names: str) -> None:
    """Let these be observed one after the other."""

    def choose(_question: object) -> str:
        done = {one.request for one in site.changes if one.state is ObservationState.COMPLETED}
        return next((name for name in names if name not in done), "")

    site.choice = choose
    site.arm()
    ends = {ObservationState.COMPLETED, ObservationState.FAILED}
    site.until(lambda: any(one.request == names[-1] and one.state in ends for one in site.changes))


def test_each_panel_is_slewed_to_and_turned_to_its_own_angle_before_it_is_centred() -> None:
    site = PureObservatory(field=field_with(ROTATOR), parts=BlockParts(solves=True))
    groups = panel("a", 30.0, hours_east=0.9), panel("b", 31.5), panel("c", 31.5)
    site.ask(*groups)
    observed(site, "a", "b", "c")
    acts = ("rotator/goto", "telescope/goto", "part/centre", "camera/expose")
    told = [name for _, name, _ in site.ledger if name in acts]
    # For c it stands there already.
    assert told == [*acts, *acts, *acts[1:]]
    slews = [args["ra"] for args in site.args if "ra" in args]
    assert slews[0] != slews[1] == pytest.approx(slews[2], abs=0.001)
    assert site.angle == 31.5


def test_a_request_that_leaves_the_angle_open_turns_nothing() -> None:
    site = PureObservatory(field=field_with(ROTATOR))
    site.ask(panel("a", None))
    observed(site, "a")
    assert site.asked("rotator/goto") == []


def test_where_there_is_no_rotator_nothing_is_turned() -> None:
    site = PureObservatory(field=field_with(None))
    site.ask(panel("a", 180.0))
    observed(site, "a")
    assert site.changes[-1].state is ObservationState.COMPLETED


def test_a_rotator_that_does_not_get_there_fails_the_block_without_a_frame() -> None:
    site = PureObservatory(field=field_with(ROTATOR))
    site.faults["rotator/goto"] = CommandPhase.FAILED
    site.ask(panel("a", 90.0))
    observed(site, "a")
    assert site.changes[-1].state is ObservationState.FAILED
    assert site.changes[-1].why.startswith("turning the camera to 90°")
    assert site.asked("camera/expose") == []


def test_an_angle_near_a_whole_turn_is_near_nothing() -> None:
    site = PureObservatory(field=field_with(ROTATOR))
    site.angle = 359.9
    site.ask(panel("a", 0.0))
    observed(site, "a")
    assert site.asked("rotator/goto") == []


@pytest.mark.parametrize(
    ("changes", "angle"),
    [({}, 350.0), ({"zero": 20.0}, 10.0), ({"zero": 20.0, "reverse": True}, 30.0)],
)
def test_the_rotators_own_angle_follows_from_its_zero_and_its_way_round(
    changes: dict[str, Any], angle: float
) -> None:
    assert replace(ROTATOR, **changes).angle_for(350.0) == pytest.approx(angle)
