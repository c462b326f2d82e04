"""What wheels make of a wanted velocity, and what an arm does."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import pytest
from hypothesis import given, strategies as st

from talaia.clock import MS
from talaia.sim.vehicle.base import Base, MotionSource
from talaia.sim.vehicle.description.urdf import make_urdf
from talaia.sim.vehicle.drives.drivetrain import Drivetrain
from talaia.sim.vehicle.drives.jogged_arm import ARM_JOINTS, JoggedArm
from talaia.sim.vehicle.drives.kinematics import (
    MAX_SPEED,
    MAX_STEERING,
    MAX_TURN,
    TRACK,
    WHEEL_RADIUS,
    WHEELBASE,
    DriveKind,
    Velocity,
    front_angles,
    limit_velocity,
    mecanum_rates,
    steering_for,
    turn_of,
)
from talaia.sim.vehicle.world import Motion, World

pytestmark = pytest.mark.pure

ANY = st.floats(allow_nan=True, allow_infinity=True)
ANGLE = st.floats(-MAX_STEERING, MAX_STEERING)


@given(st.sampled_from(DriveKind), ANY, ANY, ANY)
def test_no_command_is_faster_than_the_base_or_in_another_direction(kind, speed, turn, lateral):
    got = limit_velocity(kind, Velocity(speed, turn, lateral))
    assert math.hypot(got.speed, got.lateral) <= MAX_SPEED * (1 + 1e-9)
    assert abs(got.turn) <= MAX_TURN
    assert got.lateral == 0 or kind is DriveKind.HOLONOMIC
    if all(map(math.isfinite, (speed, turn, lateral))):
        assert got.speed * speed >= 0
        assert got.lateral * lateral >= 0


@given(st.floats(-MAX_SPEED, MAX_SPEED).filter(lambda speed: abs(speed) > 1e-3), ANGLE)
def test_a_twist_of_steered_wheels_is_driven_as_it_is_asked(speed, angle):
    turn = turn_of(speed, angle)
    assert steering_for(Velocity(speed, turn), 0.0) == pytest.approx(angle, abs=1e-9)


@given(ANGLE.filter(lambda angle: abs(angle) > 1e-3))
def test_both_steered_wheels_roll_about_the_same_point(angle):
    left, right = front_angles(angle)
    # To the point on the rear axle's line, to the left, that each stands at right angles to.
    assert WHEELBASE / math.tan(left) + TRACK / 2 == pytest.approx(
        WHEELBASE / math.tan(right) - TRACK / 2, rel=1e-6
    )


@given(
    st.floats(-MAX_SPEED, MAX_SPEED),
    st.floats(-MAX_TURN, MAX_TURN),
    st.floats(-MAX_SPEED, MAX_SPEED),
)
def test_wheels_that_move_sideways_say_how_the_base_moves(speed, turn, lateral):
    fl, fr, rl, rr = (rate * WHEEL_RADIUS for rate in mecanum_rates(Velocity(speed, turn, lateral)))
    assert (fl + fr + rl + rr) / 4 == pytest.approx(speed, abs=1e-9)
    assert (-fl + fr + rl - rr) / 4 == pytest.approx(lateral, abs=1e-9)
    assert (-fl + fr - rl + rr) / (2 * (TRACK + WHEELBASE)) == pytest.approx(turn, abs=1e-9)


def test_steered_wheels_do_not_turn_on_the_spot_and_keep_their_angle_when_it_stops() -> None:
    base = Base(drive=DriveKind.ACKERMANN)
    assert base.set_velocity(0, 0.0, 1.0) is not None
    assert (base.speed, base.turn) == (0, 0)
    base.steer_wheels(0, 0.1, 0.3)
    assert base.turn == pytest.approx(0.1 * math.tan(0.3) / WHEELBASE)
    stopped = base.latch_stop(engaged=True)
    assert stopped is not None
    assert (stopped.source, stopped.speed, stopped.turn) == (MotionSource.STOP, 0, 0)
    assert stopped.steering == 0.3


def test_a_base_that_cannot_turn_on_the_spot_does_not_wander() -> None:
    assert Base(drive=DriveKind.ACKERMANN).switch_wandering(on=True) == (False, None)
    assert Base(drive=DriveKind.HOLONOMIC).switch_wandering(on=True) == (True, None)


def test_a_holonomic_base_goes_sideways_and_does_not_turn() -> None:
    world = World(1, furnished=False)
    for _ in range(100):
        motion = world.step(0.02, 0.0, 0.0, lateral=0.1)
    assert motion.slip == pytest.approx(0.1, abs=0.002)
    assert motion.y == pytest.approx(0.2, abs=0.01)
    assert (motion.x, motion.yaw) == pytest.approx((0, 0), abs=1e-3)


def test_steered_wheels_turn_as_their_motors_do() -> None:
    drivetrain = Drivetrain(DriveKind.ACKERMANN)
    turn = turn_of(0.1, 0.4)
    motion = Motion(0, 0, 0, 0.1, 0, turn, 0, 0, 0)
    found = {joint.name: joint for joint in drivetrain.pass_time(0.5, motion, 0.4)}
    # All four roll about one point, each as far from it as its way is long.
    about = 0.1 / turn
    inner = math.hypot(about - TRACK / 2, WHEELBASE)
    assert found["wheel_front_left_joint"].velocity == pytest.approx(
        turn * inner / WHEEL_RADIUS, rel=1e-6
    )
    assert found["wheel_front_left_joint"].position == pytest.approx(
        found["wheel_front_left_joint"].velocity * 0.5
    )
    assert found["steering_left_joint"].position > found["steering_right_joint"].position > 0


@pytest.mark.parametrize("kind", DriveKind)
def test_all_joints_that_are_told_are_in_the_vehicles_form(kind: DriveKind) -> None:
    form = ElementTree.fromstring(make_urdf(kind, arm=True))  # noqa: S314 - our own
    known = {joint.get("name") for joint in form.iter("joint")}
    motion = Motion(0, 0, 0, 0, 0, 0, 0, 0, 0)
    told = [*Drivetrain(kind).pass_time(0.02, motion, 0.0), *JoggedArm().pass_time(0, 0.02)]
    assert {joint.name for joint in told} <= known


@given(st.lists(st.lists(ANY, min_size=3, max_size=3), max_size=20))
def test_an_arm_stays_within_its_ends_whatever_it_is_told(commands):
    arm = JoggedArm()
    for tick, wanted in enumerate(commands):
        arm.set_velocities(tick * 400 * MS, wanted)
        for joint, reading in zip(ARM_JOINTS, arm.pass_time(tick * 400 * MS, 0.4), strict=True):
            assert joint.low <= reading.position <= joint.high
            assert abs(reading.velocity) <= joint.max_speed


def test_an_arm_stands_half_a_second_after_the_last_command_and_when_it_is_stopped() -> None:
    arm = JoggedArm()
    assert arm.set_velocities(0, [0.5, 0, 0])
    assert arm.pass_time(400 * MS, 0.4)[0].velocity == 0.5
    assert arm.pass_time(500 * MS, 0.4)[0].velocity == 0
    arm.latch_stop(engaged=True)
    assert not arm.set_velocities(600 * MS, [0.5, 0, 0])
    arm.latch_stop(engaged=False)
    # A controller of three joints takes three numbers.
    assert not arm.set_velocities(700 * MS, [0.5])
