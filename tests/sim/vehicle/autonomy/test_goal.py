"""The vehicle drives by itself to where it is sent, and STOP and people come first."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.clock import SECOND
from talaia.sim.vehicle.autonomy.goal import ALIGNED, NEAR, Goal, choose_goal_velocity
from talaia.sim.vehicle.base import MAX_SPEED, MAX_TURN, Base, MotionSource
from talaia.sim.vehicle.world import Motion

pytestmark = pytest.mark.pure

places, headings = st.floats(-5, 5), st.floats(-math.pi, math.pi)


def motion(x: float, y: float, yaw: float) -> Motion:
    return Motion(x=x, y=y, yaw=yaw, speed=0, slip=0, turn=0, acceleration=0, left=0, right=0)


@given(places, places, headings, st.builds(Goal, places, places, headings))
@settings(max_examples=examples(50, many=2000), deadline=None)
def test_every_goal_is_reached(x: float, y: float, yaw: float, goal: Goal) -> None:
    for _ in range(20_000):
        velocity = choose_goal_velocity(motion(x, y, yaw), goal)
        if velocity is None:
            break
        speed, turn = velocity
        assert abs(speed) <= MAX_SPEED
        assert abs(turn) <= MAX_TURN
        x, y = x + 0.02 * speed * math.cos(yaw), y + 0.02 * speed * math.sin(yaw)
        yaw = math.remainder(yaw + 0.02 * turn, 2 * math.pi)
    assert math.hypot(goal.x - x, goal.y - y) <= NEAR
    assert abs(math.remainder(goal.yaw - yaw, 2 * math.pi)) <= ALIGNED


def test_a_command_from_outside_ends_a_goal() -> None:
    base = Base()
    assert base.set_goal(Goal(1, 0, 0))
    base.set_velocity(SECOND, 0.1, 0.0)
    assert base.goal is None
    assert base.set_goal_velocity((0.1, 0.0)) is None


def test_stop_ends_a_goal_and_refuses_another() -> None:
    base = Base()
    base.set_goal(Goal(1, 0, 0))
    assert base.set_goal_velocity((0.1, 0.0)) is not None
    base.latch_stop(engaged=True)
    assert base.goal is None
    assert not base.set_goal(Goal(1, 0, 0))
    base.latch_stop(engaged=False)
    assert base.set_goal_velocity((0.1, 0.0)) is None
    assert base.speed == 0.0


def test_a_goal_that_is_reached_is_over() -> None:
    base = Base()
    base.set_goal(Goal(1, 0, 0))
    base.set_goal_velocity((0.1, 0.0))
    change = base.set_goal_velocity(None)
    assert change is not None
    assert (change.source, change.speed) == (MotionSource.GOAL, 0.0)
    assert base.goal is None


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_goal_that_is_nowhere_is_refused(bad: float) -> None:
    assert not Base().set_goal(Goal(bad, 0, 0))
