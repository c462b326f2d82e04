"""Who moves the vehicle."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from talaia.clock import MS
from talaia.sim.vehicle.base import MAX_SPEED, MAX_TURN, Base, Change, MotionSource, Ramp

pytestmark = pytest.mark.pure


def test_a_command_is_wanted_until_it_is_too_old() -> None:
    base = Base()
    assert base.set_velocity(0, 0.2, 0.5) == Change(MotionSource.TWIST, 0.2, 0.5)
    assert base.pass_time(400 * MS) is None
    assert base.speed == 0.2
    assert base.pass_time(450 * MS) == Change(MotionSource.TIME_OUT, 0.0, 0.0)
    assert (base.speed, base.turn) == (0.0, 0.0)


def test_half_a_second_after_the_last_command_the_vehicle_stands_still() -> None:
    base, ramp = Base(), Ramp()
    ramp.follow_velocity(10.0, MAX_SPEED, MAX_TURN)
    base.set_velocity(0, MAX_SPEED, MAX_TURN)
    for period in range(26):
        base.pass_time(period * 20 * MS)
        ramp.follow_velocity(0.02, base.speed, base.turn)
    assert (ramp.speed, ramp.turn) == (0.0, 0.0)


def test_repeated_commands_keep_it_going_and_change_nothing() -> None:
    base = Base()
    base.set_velocity(0, 0.1, 0.0)
    for step in range(1, 50):
        assert base.set_velocity(step * 50 * MS, 0.1, 0.0) is None
        assert base.pass_time(step * 50 * MS) is None
    assert base.speed == 0.1


def test_a_time_out_is_told_once() -> None:
    base = Base()
    base.set_velocity(0, 0.1, 0.0)
    assert base.pass_time(600 * MS) is not None
    assert base.pass_time(700 * MS) is None


def test_keys_drive_as_the_cloudconnect_contract_says() -> None:
    base = Base()
    signs = {}
    for key in "wxads":
        base.press_key(0, key)
        signs[key] = (
            math.copysign(1, base.speed) * (base.speed != 0),
            base.turn > 0,
            base.turn < 0,
        )
    assert signs["w"] == (1, False, False)
    assert signs["x"] == (-1, False, False)
    assert signs["a"] == (0, True, False)
    assert signs["d"] == (0, False, True)
    assert signs["s"] == (0, False, False)


def test_a_key_times_out_too() -> None:
    base = Base()
    base.press_key(0, "w")
    assert base.pass_time(500 * MS) == Change(MotionSource.TIME_OUT, 0.0, 0.0)


def test_other_keys_change_nothing() -> None:
    base = Base()
    base.press_key(0, "w")
    assert base.press_key(10 * MS, "forward") is None
    assert base.speed > 0


def test_stop_refuses_all_motion_until_it_is_released() -> None:
    base = Base(wandering=True)
    base.set_wander_velocity(0.1, 0.0)
    assert base.latch_stop(engaged=True) == Change(MotionSource.STOP, 0.0, 0.0)
    assert not base.wandering
    assert base.set_velocity(1, 0.2, 0.0) is None
    assert base.press_key(2, "w") is None
    assert base.set_wander_velocity(0.1, 0.0) is None
    assert base.switch_wandering(on=True) == (False, None)
    assert base.speed == 0.0
    assert base.latch_stop(engaged=False) is None
    assert base.speed == 0.0
    assert base.set_velocity(3, 0.2, 0.0) is not None


def test_a_release_does_not_bring_wandering_back() -> None:
    base = Base(wandering=True)
    base.latch_stop(engaged=True)
    base.latch_stop(engaged=False)
    assert base.set_wander_velocity(0.1, 0.0) is None


def test_a_command_from_outside_ends_wandering_for_good() -> None:
    base = Base(wandering=True)
    assert base.set_wander_velocity(0.1, 0.2) == Change(MotionSource.WANDER, 0.1, 0.2)
    base.set_velocity(0, 0.0, 0.0)
    assert not base.wandering
    base.pass_time(10_000 * MS)
    assert base.set_wander_velocity(0.1, 0.2) is None


def test_turning_wandering_off_stops_the_vehicle() -> None:
    base = Base()
    assert base.switch_wandering(on=True) == (True, None)
    base.set_wander_velocity(0.1, 0.2)
    assert base.switch_wandering(on=False) == (True, Change(MotionSource.WANDER, 0.0, 0.0))


@given(speed=st.floats(), turn=st.floats())
def test_whatever_is_asked_stays_within_the_limits(speed: float, turn: float) -> None:
    base = Base()
    base.set_velocity(0, speed, turn)
    assert abs(base.speed) <= MAX_SPEED
    assert abs(base.turn) <= MAX_TURN
    if not (math.isfinite(speed) and math.isfinite(turn)):
        assert (base.speed, base.turn) == (0.0, 0.0)


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-5, 5)), max_size=40))
def test_the_ramp_never_jumps(goals: list[tuple[float, float]]) -> None:
    ramp = Ramp()
    for speed, turn in goals:
        before = (ramp.speed, ramp.turn)
        ramp.follow_velocity(0.02, speed, turn)
        assert abs(ramp.speed - before[0]) <= Ramp.BRAKE * 0.02 + 1e-12
        assert abs(ramp.turn - before[1]) <= Ramp.TURN_BRAKE * 0.02 + 1e-12
