"""Driving sideways, by steered wheels and by joints: limits, ramp, cap, ends and zeros."""

import math

import pytest
from hypothesis import given, strategies as st
from msgspec import structs

from talaia.clock import MS, SECOND
from talaia.gateway.driving.velocity_limits import VelocityLimiter, room_of_joint
from talaia.model.site import Drive as Rule, DriveMessage, DrivenJoint
from talaia.wire.frames import DriveFrame as Frame

pytestmark = pytest.mark.pure

SIDEWAYS = Rule(
    topic="/cmd_vel", max_speed=0.4, max_reverse=0.1, max_sideways=0.2, max_turn=2.0, rate=20
)
STEERED = Rule(
    topic="/drive",
    message=DriveMessage.ACKERMANN_STAMPED,
    max_speed=1.0,
    max_steering=0.4,
    max_steering_speed=0.8,
)
ARM = Rule(
    topic="/jog",
    message=DriveMessage.JOINT_VELOCITIES,
    joints={
        "shoulder": DrivenJoint(max_speed=0.5),
        "elbow": DrivenJoint(max_speed=0.2, position="arm/elbow", minimum=-1.0, maximum=1.0),
    },
    max_joint_acceleration=100.0,
)


def frame(seq: int, **more: float | list[float]) -> Frame:
    values = {"linear": 0.0, "angular": 0.0, "epoch": 1, "tick": 0, **more}
    return Frame(device="base", session="tab", seq=seq, **values)


def hold(one: VelocityLimiter, times: int, **more: float | list[float]) -> None:
    """Hold for so many frames, from the beginning."""
    for turn in range(times):
        assert one.offer_frame(frame(turn, **more), 1, 0, turn * 50 * MS) == ""
        one.next_demand(turn * 50 * MS)


def test_a_base_that_moves_sideways_is_told_so_and_another_is_not() -> None:
    one = VelocityLimiter(SIDEWAYS)
    hold(one, 20, lateral=-0.15)
    assert one.output.lateral == pytest.approx(-0.15)
    other = VelocityLimiter(structs.replace(SIDEWAYS, max_sideways=0.0))
    hold(other, 20, lateral=-0.15)
    assert other.output.lateral == 0.0
    assert not other.output.moves


def test_aslant_is_no_faster_than_the_ellipse_of_both_limits_and_keeps_its_direction() -> None:
    one = VelocityLimiter(SIDEWAYS)
    hold(one, 30, linear=9.0, lateral=9.0)
    assert one.output.linear / 0.4 == pytest.approx(math.sqrt(0.5))
    assert one.output.lateral / 0.2 == pytest.approx(math.sqrt(0.5))


def test_an_interlock_that_slows_slows_sideways_as_well() -> None:
    one = VelocityLimiter(SIDEWAYS)
    one.share = 0.25
    hold(one, 30, lateral=0.2)
    assert one.output.lateral == pytest.approx(0.05)


def test_a_silent_driver_who_moved_sideways_becomes_zeros() -> None:
    one = VelocityLimiter(SIDEWAYS)
    hold(one, 10, lateral=0.2)
    at = 9 * 50 * MS + 250 * MS
    assert one.next_demand(at) == one.zero
    assert not one.output.moves


def test_wheels_turn_no_faster_than_they_may_and_no_further() -> None:
    one = VelocityLimiter(STEERED)
    hold(one, 2, linear=0.5, steering=9.0)
    assert one.output.steering == pytest.approx(0.08)
    hold(one := VelocityLimiter(STEERED), 20, linear=0.5, steering=9.0)
    assert one.output.steering == pytest.approx(0.4)


def test_letting_go_stops_a_steered_vehicle_and_leaves_its_wheels_as_they_stand() -> None:
    one = VelocityLimiter(STEERED)
    hold(one, 20, linear=0.5, steering=0.3)
    one.offer_frame(frame(99), 1, 0, SECOND)
    assert one.is_prompt(SECOND)
    assert one.next_demand(SECOND) == (0.0, 0.0, 0.0, pytest.approx(0.3), ())
    one.halt_motion(SECOND)
    assert one.next_demand(2 * SECOND + SECOND // 2) is None
    assert one.zero.steering == pytest.approx(0.3)


def test_a_line_too_slow_for_driving_moves_no_wheels_either() -> None:
    one = VelocityLimiter(STEERED)
    one.share = 0.0
    hold(one, 10, linear=0.5, steering=0.3)
    assert one.output == (0.0, 0.0, 0.0, 0.0, ())


def test_a_frame_for_other_joints_than_there_are_is_refused() -> None:
    one = VelocityLimiter(ARM)
    assert one.offer_frame(frame(0, joints=[0.1]), 1, 0, 0) == "the frame is for 1 joints, not 2"
    assert one.offer_frame(frame(0, joints=[0.1, math.nan]), 1, 0, 0) != ""
    assert one.silent


def test_a_joint_goes_on_by_itself_while_another_rests_at_its_end() -> None:
    one = VelocityLimiter(ARM)
    one.joint_places = (math.nan, 1.0)
    hold(one, 3, joints=[0.3, 0.2])
    assert one.output.joints == (pytest.approx(0.3), 0.0)
    assert one.joint_reason == "elbow: it comes to its end"
    hold(one := VelocityLimiter(ARM), 3, joints=[0.3, -0.2])
    assert one.output.joints == (pytest.approx(0.3), 0.0)
    assert one.joint_reason == "elbow: where it stands is not known"


def test_a_joint_at_its_end_may_go_back() -> None:
    one = VelocityLimiter(ARM)
    one.joint_places = (0.0, 1.0)
    hold(one, 3, joints=[0.0, -0.2])
    assert one.output.joints[1] == pytest.approx(-0.2)
    assert one.joint_reason == ""


def test_a_frame_that_names_no_joint_lets_go_of_all() -> None:
    one = VelocityLimiter(ARM)
    hold(one, 3, joints=[0.3, 0.0])
    one.offer_frame(frame(9), 1, 0, 200 * MS)
    assert one.next_demand(200 * MS) == one.zero
    assert one.zero.joints == (0.0, 0.0)


@given(
    st.floats(-1.2, 1.2),
    st.lists(st.floats(-0.5, 0.5), min_size=1, max_size=120),
    st.integers(0, 5),
)
def test_no_press_brings_a_joint_past_its_end(start: float, wishes: list[float], late: int) -> None:
    """As read up to 250 ms ago, and moved as told."""
    one = VelocityLimiter(ARM)
    place, seen = start, [start] * (late + 1)
    for turn, wish in enumerate(wishes):
        one.joint_places = (0.0, seen[-late - 1])
        now = turn * 50 * MS
        one.offer_frame(frame(turn, joints=[0.0, wish]), 1, 0, now)
        demand = one.next_demand(now)
        place += demand.joints[1] * 0.05
        seen.append(place)
        assert min(start, -1.0) - 1e-9 <= place <= max(start, 1.0) + 1e-9


numbers = st.floats(allow_nan=True, allow_infinity=True)
pushes = st.lists(
    st.tuples(
        *(numbers for _ in range(4)),
        st.lists(numbers, min_size=2, max_size=2),
        st.integers(0, 120),
        st.floats(0, 1),
    ),
    max_size=50,
)


@pytest.mark.parametrize("rule", [SIDEWAYS, STEERED, ARM], ids=["sideways", "steered", "arm"])
@given(pushes)
def test_no_history_of_pushes_breaks_a_limit_or_a_ramp(rule: Rule, history: list[tuple]) -> None:
    one = VelocityLimiter(rule)
    one.joint_places = (0.0, 0.0)[: len(rule.joints)]
    now = 0
    for number, (linear, angular, lateral, steering, joints, wait, share) in enumerate(history):
        now += wait * MS
        one.share = share
        before = one.output
        sent = frame(
            number,
            linear=linear,
            angular=angular,
            lateral=lateral,
            steering=steering,
            joints=joints if rule.joints else [],
        )
        one.offer_frame(sent, 1, 0, now)
        demand = one.next_demand(now)
        if demand is None:
            continue
        assert all(map(math.isfinite, (*demand[:4], *demand.joints)))
        ahead = rule.max_speed if demand.linear >= 0 else rule.reverse
        reach = math.hypot(
            demand.linear / (ahead or 1.0), demand.lateral / (rule.max_sideways or 1.0)
        )
        assert reach <= one.cap + 1e-9
        assert abs(demand.angular) <= rule.max_turn * one.cap + 1e-9
        assert abs(demand.steering) <= rule.max_steering
        # The longest that a late turn may count for is two control periods.
        gained = math.hypot(demand.linear - before.linear, demand.lateral - before.lateral)
        if abs(demand.linear) >= abs(before.linear) and abs(demand.lateral) >= abs(before.lateral):
            assert gained <= rule.max_acceleration * 0.1 + 1e-9
        assert abs(demand.steering - before.steering) <= rule.max_steering_speed * 0.1 + 1e-9
        for speed, joint in zip(demand.joints, rule.joints.values(), strict=True):
            assert abs(speed) <= joint.max_speed * one.cap + 1e-9


def test_a_joint_without_a_position_or_an_end_has_its_limit_alone() -> None:
    free = DrivenJoint(max_speed=0.5)
    assert room_of_joint(free, 0.3, math.nan) == 0.3
    endless = DrivenJoint(max_speed=0.5, position="arm/wrist")
    assert room_of_joint(endless, 0.3, 7.0) == 0.3
    assert room_of_joint(endless, 0.3, math.nan) == 0.0
