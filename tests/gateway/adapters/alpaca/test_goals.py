"""When a method of ASCOM is done: by what the device says of itself."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.adapters.alpaca.goals import ABSENT, SETTLE_NS, AlpacaGoal, stop_of
from talaia.wire.frames import CommandPhase as Phase


def phase(goal: AlpacaGoal, now_ns: int = 0, **values: object) -> Phase | None:
    outcome = goal.evaluate_values(values, now_ns)
    return None if outcome is None else outcome.phase


def test_a_shutter_is_closed_when_it_says_so_and_not_before() -> None:
    goal = AlpacaGoal("dome/0/closeshutter", {}, 0)
    assert phase(goal) is None
    assert phase(goal, shutterstatus=3) is Phase.RUNNING
    assert phase(goal, shutterstatus=0) is Phase.RUNNING
    assert phase(goal, shutterstatus=1) is Phase.SUCCEEDED
    assert phase(goal, shutterstatus=4) is Phase.FAILED


@given(st.sampled_from([None, 2, 3, True, False, "1", 1.5, -1, [], ABSENT]))
def test_nothing_but_closed_counts_as_closed(said: object) -> None:
    goal = AlpacaGoal("dome/0/closeshutter", {}, 0)
    assert phase(goal, shutterstatus=said) is not Phase.SUCCEEDED


def test_what_rests_elsewhere_has_failed_after_it_has_settled() -> None:
    goal = AlpacaGoal("telescope/0/park", {}, 0)
    assert phase(goal, 0, slewing=False, atpark=False) is Phase.RUNNING
    assert phase(goal, SETTLE_NS - 1, slewing=True, atpark=False) is Phase.RUNNING
    assert phase(goal, SETTLE_NS, slewing=False, atpark=False) is Phase.RUNNING
    end = goal.evaluate_values({"slewing": False, "atpark": False}, 2 * SETTLE_NS)
    assert end is not None
    assert end.phase is Phase.FAILED
    assert "Parked: no" in end.message


@pytest.mark.parametrize(("asked", "there"), [(0.0, 359.5), (359.6, 0.2), (90.0, 90.9)])
def test_an_azimuth_is_reached_around_the_circle(asked: float, there: float) -> None:
    goal = AlpacaGoal("dome/0/slewtoazimuth", {"Azimuth": asked}, 0)
    assert phase(goal, slewing=False, azimuth=there) is Phase.SUCCEEDED


def test_a_relative_focuser_is_believed_by_its_rest_and_a_dome_without_shutter_is_not() -> None:
    focuser = AlpacaGoal("focuser/0/move", {"Position": 100}, 0)
    assert phase(focuser, ismoving=False, position=ABSENT) is Phase.SUCCEEDED
    dome = AlpacaGoal("dome/0/openshutter", {}, 0)
    assert phase(dome, shutterstatus=ABSENT) is not Phase.SUCCEEDED


def test_an_exposure_tells_how_far_it_is_and_a_stopped_one_is_cancelled() -> None:
    goal = AlpacaGoal("camera/0/startexposure", {"Duration": 10.0, "Light": True}, 0)
    running = goal.evaluate_values({"camerastate": 2, "imageready": False}, 5 * SECOND)
    assert running is not None
    assert running.progress == 0.5
    goal.cancelled = True
    assert phase(goal, camerastate=0, imageready=False) is Phase.CANCELLED


def test_a_switch_is_asked_for_by_its_number() -> None:
    goal = AlpacaGoal("switch/0/setswitch", {"Id": 3, "State": True}, 0)
    assert goal.properties == ["getswitch?Id=3"]
    end = goal.evaluate_values({"getswitch?Id=3": True}, 0)
    assert end is not None
    assert end.phase is Phase.SUCCEEDED


@pytest.mark.parametrize(
    ("target", "fields", "values", "words"),
    [
        ("dome/0/openshutter", {}, {"shutterstatus": 0}, "Shutter: open"),
        ("camera/0/setccdtemperature", {"SetCCDTemperature": -10.0},
         {"setccdtemperature": -10.0}, "Set point: -10 °C"),
        ("covercalibrator/0/opencover", {}, {"coverstate": 3}, "Cover: open"),
        ("switch/0/setswitch", {"Id": 3, "State": True}, {"getswitch": True}, "on"),
        ("switch/0/setswitchvalue", {"Id": 3, "Value": 0.5}, {"getswitchvalue": 0.5}, "0.5"),
    ],
)  # fmt: skip
def test_what_was_reached_is_told_in_the_words_of_the_page(target, fields, values, words) -> None:
    end = AlpacaGoal(target, fields, 0).evaluate_values(values, 0)
    assert end is not None
    assert (end.phase, end.message) == (Phase.SUCCEEDED, words)


def test_binning_and_gain_are_set_when_the_camera_says_so() -> None:
    binning = AlpacaGoal("camera/0/binx", {"BinX": 2}, 0)
    assert phase(binning, binx=1) is Phase.RUNNING
    assert phase(binning, binx=2) is Phase.SUCCEEDED
    gain = AlpacaGoal("camera/0/gain", {"Gain": 100}, 0)
    assert phase(gain, gain=100) is Phase.SUCCEEDED
    assert phase(gain, gain=0) is Phase.RUNNING
    assert phase(gain, 2 * SETTLE_NS, gain=0) is Phase.FAILED


def test_each_thing_that_moves_has_a_stop() -> None:
    assert stop_of("dome/0") == "dome/0/abortslew"
    assert stop_of("camera/1") == "camera/1/abortexposure"
    assert stop_of("safetymonitor/0") == ""
