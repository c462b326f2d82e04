"""Driving: limits, ramp, cap, watchdog and explicit zeros."""

import math

import pytest
from hypothesis import given, strategies as st
from msgspec import structs

from talaia.clock import MS, SECOND
from talaia.gateway.driving.velocity_limits import (
    STILL,
    STOP_BY_NS,
    VelocityLimiter,
    cap_of_loop,
    cap_of_picture,
)
from talaia.model.site import Drive as Rule
from talaia.wire.frames import DriveFrame as Frame

pytestmark = pytest.mark.pure

RULE = Rule(
    topic="/cmd_vel", max_speed=0.2, max_turn=2.0, max_acceleration=1.0, max_turn_acceleration=10.0
)


def frame(seq: int = 0, linear: float = 0.2, angular: float = 0.0, **more: float) -> Frame:
    values = {"epoch": 1, "tick": 0, **more}
    return Frame(device="base", session="tab", seq=seq, linear=linear, angular=angular, **values)


def driving() -> VelocityLimiter:
    return VelocityLimiter(RULE)


def test_nothing_is_said_before_the_first_frame() -> None:
    one = driving()
    assert one.due_ns() is None
    assert one.next_demand(0) is None


def test_accepted_wish_is_ramped_up_to_at_the_stated_acceleration() -> None:
    one = driving()
    assert one.offer_frame(frame(), 1, 0, 0) == ""
    assert one.next_demand(0).linear == pytest.approx(0.05)
    assert one.next_demand(50 * MS).linear == pytest.approx(0.10)


def test_zero_is_not_ramped() -> None:
    one = driving()
    for turn in range(4):
        one.offer_frame(frame(turn), 1, 0, turn * 50 * MS)
        one.next_demand(turn * 50 * MS)
    assert one.output.linear == pytest.approx(0.2)
    one.offer_frame(frame(9, linear=0.0), 1, 0, 200 * MS)
    assert one.is_prompt(200 * MS)
    assert one.next_demand(200 * MS) == STILL


def test_silent_driver_becomes_zeros_for_a_second_and_then_silence() -> None:
    one = driving()
    one.offer_frame(frame(), 1, 0, 0)
    one.next_demand(0)
    said, now = [], 0
    while (due := one.due_ns()) is not None:
        now = max(due, now + 1)
        said.append((now, one.next_demand(now)))
    zeros = [at for at, demand in said if demand == STILL]
    assert zeros[0] == 250 * MS
    assert len(zeros) >= 20
    assert said[-1] == (1250 * MS, None)


@pytest.mark.parametrize(
    ("bad", "epoch", "age_ms"),
    [
        (frame(5, linear=math.nan), 1, 0),
        (frame(5, angular=math.inf), 1, 0),
        (frame(5, held_ms=math.nan), 1, 0),
        (frame(5, picture_ms=math.nan), 1, 0),
        (frame(5, ttl_ms=math.nan), 1, 0),
        (frame(5), 2, 0),
        (frame(1), 1, 0),
        (frame(0), 1, 0),
        (frame(5), 1, 251),
        (frame(5), 1, -1),
        (frame(5, ttl_ms=100), 1, 101),
    ],
    ids=[
        "nan",
        "inf",
        "held",
        "picture",
        "ttl",
        "epoch",
        "same",
        "older",
        "age",
        "tick",
        "own-ttl",
    ],
)
def test_frame_that_breaks_a_rule_is_refused_and_changes_nothing(
    bad: Frame, epoch: int, age_ms: int
) -> None:
    one = driving()
    one.offer_frame(frame(1), 1, 0, 0)
    before = one.next_demand(0)
    assert one.offer_frame(bad, epoch, age_ms * MS, 10 * MS) != ""
    assert one.output == before
    assert one.due_ns() == 75 * MS
    assert one.next_demand(250 * MS) == STILL


def test_frame_cannot_lengthen_its_own_life() -> None:
    assert driving().offer_frame(frame(ttl_ms=60_000), 1, 251 * MS, 0) != ""


def test_driver_who_echoes_one_old_tick_is_stopped_450_ms_after_it() -> None:
    one = driving()
    for at in range(0, 251, 50):
        assert one.offer_frame(frame(at), 1, at * MS, at * MS) == ""
        one.next_demand(at * MS)
    assert one.offer_frame(frame(300), 1, 300 * MS, 300 * MS) == "the frame is too old (300 ms)"
    assert one.next_demand(449 * MS) != STILL
    assert one.due_ns() == 450 * MS
    assert one.next_demand(450 * MS) == STILL


def test_no_time_to_live_that_may_be_described_lets_a_frame_move_after_450_ms() -> None:
    one = VelocityLimiter(structs.replace(RULE, ttl=0.5))
    assert one.offer_frame(frame(0), 1, 449 * MS, 449 * MS) == ""
    one.next_demand(449 * MS)
    assert one.next_demand(450 * MS) == STILL
    assert one.offer_frame(frame(1), 1, 450 * MS, 450 * MS) == "the frame is too old (450 ms)"


# How long each frame is under way and how long after the one before it was sent (ms); which of the
# ticks, one each 50 ms, the page has seen by then: all, or none after a certain one.
ways = st.tuples(st.integers(0, 400), st.integers(0, 120))


@given(
    st.lists(ways, min_size=1, max_size=40),
    st.integers(0, 2000),
    st.sampled_from([0.05, 0.25, 0.5]),
)
def test_velocity_is_zero_by_450_ms_after_the_tick_of_the_last_frame(
    journeys: list[tuple[int, int]], dark_ms: int, ttl: float
) -> None:
    """Nothing sent after `dark_ms` from the gateway reaches the page, which presses on."""
    one = VelocityLimiter(structs.replace(RULE, ttl=ttl))
    arrivals, sent_ms = [], 0
    for seq, (under_way, wait) in enumerate(journeys):
        sent_ms += wait
        tick_ms = min(sent_ms, dark_ms) // 50 * 50
        arrivals.append((sent_ms + under_way, seq, tick_ms))
    last_tick_ms, moved = -1, False
    for at, seq, tick_ms in [*sorted(arrivals), (10**6, -1, 0)]:
        # Until it comes, the gateway's timer calls exactly when it was asked to.
        while (due := one.due_ns()) is not None and due < at * MS:
            said = one.next_demand(due)
            if said not in {None, STILL}:
                assert due < last_tick_ms * MS + STOP_BY_NS
        if seq < 0:
            break
        age_ms = at - tick_ms
        if one.offer_frame(frame(seq), 1, age_ms * MS, at * MS) == "":
            assert age_ms <= ttl * 1000
            assert age_ms < 450
            last_tick_ms, moved = tick_ms, True
        one.next_demand(at * MS)
        if one.output != STILL:
            assert moved
            assert at < last_tick_ms + 450
    assert one.silent


def test_cap_falls_with_the_loop() -> None:
    assert [cap_of_loop(ms) for ms in (0, 150, 151, 300, 400, 500, 501, math.nan)] == [
        1, 1, 0.5, 0.5, 0.25, 0, 0, 0,
    ]  # fmt: skip


def test_waiting_in_the_page_does_not_count_as_loop() -> None:
    one = driving()
    one.offer_frame(frame(held_ms=40), 1, 180 * MS, 0)
    assert one.loop_ms == pytest.approx(140)
    assert one.cap == 1.0


def test_old_picture_slows_and_a_dead_one_stops() -> None:
    assert [cap_of_picture(ms, has_picture=True) for ms in (0, 500, 501, 1001, -1)] == [
        1, 1, 0.5, 0, 0.5,
    ]  # fmt: skip
    assert cap_of_picture(-1, has_picture=False) == 1
    one = driving()
    one.offer_frame(frame(picture_ms=2000), 1, 0, 0)
    assert one.next_demand(0) == STILL


def test_flood_of_frames_does_not_raise_the_rate_to_the_robot() -> None:
    one, said = driving(), 0
    for ms in range(1000):
        one.offer_frame(frame(ms), 1, 0, ms * MS)
        if one.is_prompt(ms * MS):
            one.next_demand(ms * MS)
            said += 1
    assert said <= 2 * RULE.rate + 3


def test_key_pressed_between_two_frames_is_not_held_back() -> None:
    one = driving()
    for at, seq in ((0, 1), (50, 2), (57, 3), (100, 4)):
        one.offer_frame(frame(seq), 1, 0, at * MS)
        assert one.is_prompt(at * MS)
        one.next_demand(at * MS)


def test_quick_taps_are_not_held_back_by_the_zeros_of_each_release() -> None:
    one, seq = driving(), 0
    for tap in range(20):
        at = tap * 60
        one.offer_frame(frame(seq), 1, 0, at * MS)
        assert one.is_prompt(at * MS)
        one.next_demand(at * MS)
        for zero in (1, 2, 3):
            one.offer_frame(frame(seq + zero, linear=0.0), 1, 0, (at + 55) * MS)
            if one.is_prompt((at + 55) * MS):
                assert one.next_demand((at + 55) * MS) == STILL
        assert one.output == STILL
        seq += 4


def test_turn_fills_in_only_for_a_missing_frame() -> None:
    one = driving()
    one.offer_frame(frame(1), 1, 0, 0)
    one.next_demand(0)
    assert one.due_ns() == 75 * MS


def test_a_wish_that_came_late_is_not_said_again_when_it_is_old() -> None:
    one = driving()
    one.offer_frame(frame(1), 1, 200 * MS, 0)
    assert one.next_demand(0) != STILL
    # It is 275 ms old then: nothing is said before the zeros.
    assert one.due_ns() == 250 * MS
    assert one.next_demand(75 * MS) is None
    assert one.due_ns() == 250 * MS
    assert one.next_demand(250 * MS) == STILL


def test_after_a_reset_the_driver_must_let_go_first() -> None:
    one = driving()
    one.offer_frame(frame(0), 1, 0, 0)
    one.halt_motion(0)
    one.demand_rest(0)
    assert one.offer_frame(frame(1), 1, 0, 50 * MS) != ""
    assert one.offer_frame(frame(2), 1, 0, 100 * MS) != ""
    assert one.offer_frame(frame(3, linear=0.0), 1, 0, 150 * MS) == ""
    assert one.offer_frame(frame(4), 1, 0, 200 * MS) == ""


numbers = st.floats(allow_nan=True, allow_infinity=True)
moves = st.one_of(
    st.tuples(
        st.just("frame"), st.integers(0, 120), numbers, numbers, numbers, st.integers(-5, 600)
    ),
    st.tuples(st.just("step"), st.integers(0, 120)),
    st.tuples(st.just("halt"), st.integers(0, 120)),
)


@given(st.lists(moves, max_size=60))
def test_no_history_ever_breaks_limit_ramp_or_watchdog(history: list[tuple]) -> None:
    one = driving()
    now, last_good, halted, last_said, dead, pressed = 0, -(10**12), 0, 0, 0, 0
    for number, (what, wait, *more) in enumerate(history):
        now += wait * MS
        before = one.output
        if what == "frame":
            linear, angular, picture, age = more
            sent = frame(number, linear=linear, angular=angular, picture_ms=picture)
            if one.offer_frame(sent, 1, age * MS, now) == "":
                last_good, pressed = now, now - age * MS
                dead = now + min(250 * MS, STOP_BY_NS - age * MS)
        elif what == "halt":
            one.halt_motion(now)
            halted, last_good, dead = now, -(10**12), now
        demand = one.next_demand(now)
        if demand is None:
            ended = now - max(last_good + 250 * MS, halted) >= SECOND or last_good < 0
            # An old wish is not said again, and its zeros are still to come.
            assert ended or (now - pressed > 250 * MS and now < dead)
            continue
        assert demand == STILL or now - pressed <= 250 * MS
        assert all(map(math.isfinite, demand[:4]))
        assert abs(demand.linear) <= RULE.max_speed
        assert abs(demand.angular) <= RULE.max_turn
        if now - last_good >= 250 * MS or now >= dead:
            assert demand == STILL
        # Faster only by the ramp; slower may be at once.
        gain = abs(demand.linear) - abs(before.linear)
        assert gain <= RULE.max_acceleration * 0.1 + 1e-9
        last_said = now
    assert last_said <= now
