"""The hand-moved clock that every test of time stands on."""

import pytest

from talaia.clock import SECOND, HandClock, SystemClock


def test_a_hand_clock_stands_still_until_it_is_moved() -> None:
    clock = HandClock(wall_ns=5 * SECOND)
    assert clock.wall_ns() == 5 * SECOND
    clock.advance(2 * SECOND)
    assert (clock.wall_ns(), clock.monotonic_ns()) == (7 * SECOND, 2 * SECOND)


def test_a_wall_clock_may_jump_and_the_monotonic_one_does_not() -> None:
    clock = HandClock()
    clock.jump_wall(-3600 * SECOND)
    assert clock.monotonic_ns() == 0


def test_time_does_not_go_back() -> None:
    with pytest.raises(ValueError, match="does not go back"):
        HandClock().advance(-1)


def test_the_system_clock_gives_nanoseconds_since_1970() -> None:
    assert SystemClock().wall_ns() > 1_700_000_000 * SECOND
    assert SystemClock().monotonic_ns() <= SystemClock().monotonic_ns()
