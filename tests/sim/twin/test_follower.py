"""What the twin does next: it follows within bounds, is put back, and rehearses alone."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.clock import MS, SECOND
from talaia.model.twins.twin import Twin, TwinMode
from talaia.sim.twin.follower import TwinFollower, VehicleState, difference_of

pytestmark = pytest.mark.pure

PERIOD_S = 0.02
TWIN = Twin(of="base", follow_rate=1.0, reset_beyond=0.5, reset_turn=0.5, reset_after=1.0)

places = st.floats(-50, 50)
headings = st.floats(-math.pi, math.pi)
speeds = st.floats(-0.5, 0.5)
states = st.builds(VehicleState, places, places, headings, speeds, speeds)


class Body:
    """A twin's body that moves as told, and as fast as `gain` says: an imperfect model."""

    def __init__(self, twin: Twin = TWIN, gain: float = 1.0) -> None:  # noqa: D107
        self.follower = TwinFollower(twin)
        self.state = VehicleState(0.0, 0.0, 0.0)
        self.gain = gain
        self.now_ns = 10 * SECOND

    def live_on(self, real: VehicleState | None, periods: int = 1) -> None:
        for _ in range(periods):
            self.now_ns += 20 * MS
            if real is not None:
                self.follower.hear_robot(real, self.now_ns)
            speed, turn = self.follower.wanted_velocity(self.now_ns)
            speed, turn = speed * self.gain, turn * self.gain
            s = self.state
            moved = VehicleState(
                s.x + speed * math.cos(s.yaw) * PERIOD_S,
                s.y + speed * math.sin(s.yaw) * PERIOD_S,
                s.yaw + turn * PERIOD_S,
                speed,
                turn,
            )
            step = self.follower.correct_twin(moved, PERIOD_S, self.now_ns)
            self.state = VehicleState(
                moved.x + step.x, moved.y + step.y, moved.yaw + step.yaw, speed, turn
            )


@given(states)
@settings(max_examples=examples(100, many=5000))
def test_the_first_word_of_the_robot_puts_the_twin_there(real: VehicleState) -> None:
    body = Body()
    body.live_on(real)
    assert body.follower.mode is TwinMode.FOLLOWING
    error = difference_of(real, body.state)
    assert error.pose == pytest.approx(0, abs=1e-9)
    assert error.heading == pytest.approx(0, abs=1e-9)
    assert body.follower.resets == 0


@given(st.lists(st.tuples(places, places, headings, st.integers(1, 60)), min_size=1, max_size=8))
@settings(max_examples=examples(60, many=2000), deadline=None)
def test_the_error_is_never_beyond_its_bound_for_longer_than_it_is_borne(
    walk: list[tuple[float, float, float, int]],
) -> None:
    """Wherever the robot is put, and however often: the twin is there in time."""
    body, beyond = Body(), 0
    for x, y, yaw, periods in walk:
        real = VehicleState(x, y, yaw)
        for _ in range(periods):
            body.live_on(real)
            error = difference_of(real, body.state)
            far = error.pose > TWIN.reset_beyond or abs(error.heading) > TWIN.reset_turn
            beyond = beyond + 1 if far else 0
            # One period more: it is looked at once in each.
            assert beyond * PERIOD_S <= TWIN.reset_after + PERIOD_S + 1e-9


@given(states, st.floats(0.01, 0.3))
@settings(max_examples=examples(60, many=2000))
def test_a_small_error_is_drawn_in_and_is_no_reset(real: VehicleState, away: float) -> None:
    still = VehicleState(real.x, real.y, real.yaw)
    body = Body()
    body.live_on(still)
    body.state = VehicleState(still.x + away, still.y, still.yaw)
    before = difference_of(still, body.state).pose
    for _ in range(5):
        body.live_on(still, 10)
        after = difference_of(still, body.state).pose
        assert after < before or after < 1e-9
        before = after
    # A second of a rate of one leaves 1/e of it.
    assert after == pytest.approx(away * math.exp(-1), rel=0.05)
    assert body.follower.resets == 0


def test_a_wrong_model_shows_as_an_error_that_stays() -> None:
    body, real = Body(gain=0.8), VehicleState(0, 0, 0, 0.2)
    body.live_on(real)
    for number in range(1, 500):
        real = VehicleState(0.2 * PERIOD_S * number, 0, 0, 0.2)
        body.follower.hear_command(0.2, 0.0, body.now_ns)
        body.live_on(real)
    # 0.04 m/s that the model lacks, over a rate of 1/s.
    assert difference_of(real, body.state).pose == pytest.approx(0.04, rel=0.1)
    assert difference_of(real, body.state).speed == pytest.approx(0.04, rel=0.01)


@given(states, states)
def test_headings_are_compared_the_short_way_round(one: VehicleState, other: VehicleState) -> None:
    assert abs(difference_of(one, other).heading) <= math.pi + 1e-9
    turned = VehicleState(one.x, one.y, one.yaw + 2 * math.pi)
    assert difference_of(turned, one).heading == pytest.approx(0, abs=1e-9)


def test_a_rehearsal_is_free_and_no_difference_is_told() -> None:
    body, real = Body(), VehicleState(1, 1, 0)
    body.live_on(real)
    for _ in range(50):
        body.follower.drive_alone(0.2, 0.0, body.now_ns)
        body.live_on(real)
    assert body.follower.mode is TwinMode.REHEARSING
    assert body.state.x == pytest.approx(1.2, abs=0.01)
    assert body.follower.difference(body.state) is None
    body.follower.follow_robot()
    body.live_on(real)
    assert body.follower.mode is TwinMode.FOLLOWING
    assert body.state.x == pytest.approx(1.0)
    assert body.follower.resets == 0


def test_zeros_begin_no_rehearsal() -> None:
    body = Body()
    body.live_on(VehicleState(0, 0, 0))
    body.follower.drive_alone(0.0, 0.0, body.now_ns)
    body.live_on(VehicleState(0, 0, 0))
    assert body.follower.mode is TwinMode.FOLLOWING


def test_a_rehearsal_stands_half_a_second_after_the_last_word() -> None:
    body, real = Body(), VehicleState(0, 0, 0)
    body.live_on(real)
    body.follower.drive_alone(0.2, 0.0, body.now_ns)
    body.live_on(real, 100)
    assert body.state.x == pytest.approx(0.1, abs=0.01)


def test_a_robot_that_moves_ends_a_rehearsal_that_nobody_drives() -> None:
    body, real = Body(), VehicleState(0, 0, 0)
    body.live_on(real)
    body.follower.drive_alone(0.2, 0.0, body.now_ns)
    moving = VehicleState(0.5, 0, 0, 0.2)
    body.live_on(moving, 60)
    # The zeros after a hold are no driving.
    body.follower.drive_alone(0.0, 0.0, body.now_ns)
    body.live_on(moving, 30)
    assert body.follower.mode is TwinMode.REHEARSING
    body.live_on(moving, 30)
    assert body.follower.mode is TwinMode.FOLLOWING


def test_a_robot_that_is_silent_is_waited_for_standing() -> None:
    body = Body()
    body.live_on(VehicleState(0, 0, 0, 0.2))
    body.live_on(None, 55)
    assert body.follower.mode is TwinMode.WAITING
    assert body.follower.wanted_velocity(body.now_ns) == (0.0, 0.0)
    # It comes back elsewhere: no model was wrong.
    body.live_on(VehicleState(9, 9, 1))
    assert body.follower.mode is TwinMode.FOLLOWING
    assert body.follower.resets == 0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_not_heard(bad: float) -> None:
    body = Body()
    body.live_on(VehicleState(1, 1, 0))
    body.follower.hear_robot(VehicleState(bad, 0, 0), body.now_ns)
    body.follower.hear_command(bad, 0.0, body.now_ns)
    body.follower.drive_alone(bad, 0.0, body.now_ns)
    body.live_on(None)
    assert body.follower.mode is TwinMode.FOLLOWING
    assert math.isfinite(body.state.x)
