"""Characters to a robot that adds them up: one for a press, never beyond the limit."""

import math

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.driving.drive_keys import KeyCounter, strongest_key
from talaia.model.site import Drive, DriveMessage, KeyMode, Keys

pytestmark = pytest.mark.pure


def rule(**keys: object) -> Drive:
    return Drive(
        topic="/control",
        message=DriveMessage.KEYS,
        max_speed=0.5,
        max_turn=1.0,
        keys=Keys(**keys),  # type: ignore[arg-type]
    )


class AddingRobot:
    """The founding design's vehicle: each letter adds 0.1, ``s`` stops it."""

    def __init__(self) -> None:  # noqa: D107
        self.speed = 0.0
        self.turn = 0.0
        self.heard = ""

    def hear(self, key: str) -> None:
        self.heard += key
        match key:
            case "w":
                self.speed += 0.1
            case "x":
                self.speed -= 0.1
            case "a":
                self.turn += 0.1
            case "d":
                self.turn -= 0.1
            case "s":
                self.speed = self.turn = 0.0


def test_a_press_is_one_character_however_long_it_is_held() -> None:
    counter = KeyCounter(rule())
    assert [counter.next_key((0.5, 0.0)) for _ in range(25)] == ["w", *[""] * 24]
    assert counter.sent == "w"
    assert counter.next_key((0.0, 0.0)) == "s"
    assert counter.sent == "s"


def test_a_turn_that_is_let_go_first_ends_with_s_where_the_step_is_not_known() -> None:
    counter = KeyCounter(rule())
    said = [counter.next_key(wish) for wish in [(0.5, 0.0), (0.5, 1.0), (0.5, 0.0), (0.5, 0.0)]]
    assert said == ["w", "a", "s", "w"]


def test_counted_characters_reach_the_wish_and_stop_at_the_limit() -> None:
    counter, robot = KeyCounter(rule(speed_step=0.1, turn_step=0.1)), AddingRobot()
    for _ in range(40):
        robot.hear(counter.next_key((0.5, 0.0)))
    assert robot.heard == "wwwww"
    assert counter.velocity == (pytest.approx(0.5), 0.0)
    assert counter.sent == "w × 5"
    robot.hear(counter.next_key((0.3, 0.0)))
    assert robot.heard == "wwwwwx"


def test_a_lower_cap_takes_back_what_was_sent() -> None:
    counter = KeyCounter(rule(speed_step=0.1, turn_step=0.1))
    for _ in range(5):
        counter.next_key((0.5, 0.0))
    assert [counter.next_key((0.5, 0.0), share=0.5) for _ in range(4)] == ["x", "x", "x", ""]
    assert counter.next_key((0.5, 0.0), share=0.0) == "s"


def test_a_robot_that_says_it_is_as_fast_as_it_may_gets_no_more() -> None:
    counter = KeyCounter(rule(speed_step=0.1, turn_step=0.1))
    assert counter.next_key((0.5, 0.0), measured=(0.45, math.nan)) == "s"
    assert counter.next_key((0.5, 0.0), measured=(0.35, math.nan)) == "w"
    assert counter.next_key((0.5, 0.0), measured=(0.7, math.nan)) == "s"


def test_repeating_says_the_stronger_direction_each_time() -> None:
    counter = KeyCounter(rule(mode=KeyMode.REPEAT))
    assert [counter.next_key((0.5, 0.2)) for _ in range(3)] == ["w", "w", "w"]
    assert all(map(math.isnan, counter.velocity))
    assert counter.next_key((0.1, -1.0)) == "d"
    assert counter.next_key((0.0, 0.0)) == "s"


wishes = st.tuples(
    st.sampled_from([0.0, 0.05, 0.1, 0.3, 0.5, -0.2, -0.5]),
    st.sampled_from([0.0, 0.1, 0.5, 1.0, -0.4, -1.0]),
    st.sampled_from([1.0, 1.0, 0.5, 0.0]),
)


@given(st.lists(wishes, max_size=60))
def test_no_order_of_wishes_drives_a_robot_that_adds_up_beyond_its_limits(
    asked: list[tuple[float, float, float]],
) -> None:
    counter, robot = KeyCounter(rule(speed_step=0.1, turn_step=0.1)), AddingRobot()
    for linear, angular, share in asked:
        robot.hear(counter.next_key((linear, angular), share))
        assert abs(robot.speed) <= 0.5 + 1e-9
        assert abs(robot.turn) <= 1.0 + 1e-9
        assert counter.velocity == (pytest.approx(robot.speed), pytest.approx(robot.turn))
    robot.hear(counter.next_key((0.0, 0.0)))
    assert (robot.speed, robot.turn) == (0.0, 0.0)


KEYS = Drive(topic="/control", message=DriveMessage.KEYS, max_speed=0.2, max_turn=2.0)


@pytest.mark.parametrize(
    ("linear", "angular", "key"),
    [(0.1, 0, "w"), (-0.1, 0, "x"), (0, 1, "a"), (0, -1, "d"), (0, 0, "s"), (0.05, 1.9, "a")],
)
def test_velocity_becomes_the_key_of_its_stronger_direction(
    linear: float, angular: float, key: str
) -> None:
    assert strongest_key(KEYS, linear, angular) == key
