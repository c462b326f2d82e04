"""Which time samples have: a message's stamp, or its arrival."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.samples.header_times import LATE_US, HeaderTimes

pytestmark = pytest.mark.pure
NOW_US = 1_800_000_000_000_000


def stamped(time_us: int) -> object:
    stamp = SimpleNamespace(sec=time_us // 10**6, nanosec=time_us % 10**6 * 1000)
    return SimpleNamespace(header=SimpleNamespace(stamp=stamp))


def test_a_stamp_just_before_the_arrival_is_the_time_of_its_samples() -> None:
    times = HeaderTimes()
    assert times.time_of(stamped(NOW_US - 250_000), NOW_US) == NOW_US - 250_000
    assert times.lag_us == 250_000


@pytest.mark.parametrize(
    "stamp_us",
    [0, 12_300_000, NOW_US - LATE_US - 1, NOW_US + 1, NOW_US + 10**12],
    ids=["none", "a simulation's", "too old", "a little ahead", "far ahead"],
)
def test_a_stamp_that_cannot_be_true_leaves_the_arrival(stamp_us: int) -> None:
    times = HeaderTimes()
    assert times.time_of(stamped(stamp_us), NOW_US) == NOW_US
    assert times.lag_us == 0


def test_messages_without_a_stamp_have_the_time_of_arrival() -> None:
    for message in (
        SimpleNamespace(data=1.0),
        SimpleNamespace(header="words"),
        SimpleNamespace(header=SimpleNamespace(stamp="noon")),
    ):
        assert HeaderTimes().time_of(message, NOW_US) == NOW_US


def test_a_clock_at_the_limit_does_not_jump_to_and_fro() -> None:
    times = HeaderTimes()
    late = [times.time_of(stamped(NOW_US + at - LATE_US - 1 + at % 3), NOW_US + at) - at
            for at in range(0, 9_000_000, 100_000)]  # fmt: skip
    assert set(late) == {NOW_US}
    # Ten seconds after the last doubt it is believed again.
    later = NOW_US + 20_000_000
    assert times.time_of(stamped(later - 1000), later) == later - 1000


@given(st.lists(st.tuples(st.integers(0, 3_000_000), st.integers(-(10**7), 10**7)), max_size=50))
def test_no_time_is_after_the_arrival_or_long_before_it(
    rows: list[tuple[int, int]],
) -> None:
    times, now_us = HeaderTimes(), NOW_US
    for passed_us, late_us in rows:
        now_us += passed_us
        assert 0 <= now_us - times.time_of(stamped(now_us - late_us), now_us) <= LATE_US


def test_stamps_of_a_robot_with_a_clock_of_its_own_are_moved_to_our_time() -> None:
    """A simulation's time begins with 0; how late its messages came is all the same."""
    shift: list[int | None] = [None]
    times = HeaderTimes(lambda: shift[0])
    assert times.time_of(stamped(12_000_000), NOW_US) == NOW_US
    shift[0] = NOW_US - 12_500_000
    assert times.time_of(stamped(12_000_000), NOW_US) == NOW_US - 500_000
    assert times.lag_us == 500_000
    # From before the simulation was begun anew.
    assert times.time_of(stamped(900_000_000), NOW_US) == NOW_US


def test_a_class_without_a_header_is_told_and_one_that_holds_anything_never() -> None:
    @dataclass
    class Plain:
        data: float

    @dataclass
    class Stamped:
        header: object

    times = HeaderTimes()
    # What rosbridge sends has one class for all messages.
    times.time_of(SimpleNamespace(data=1.0), NOW_US)
    assert times.headless is None
    assert times.time_of(Stamped(None), NOW_US) == NOW_US
    assert times.headless is None
    assert times.time_of(Plain(1.0), NOW_US) == NOW_US
    assert times.headless is Plain
    # Another version of the type, by another publisher, has one.
    late = stamped(NOW_US - 250_000).header
    assert times.time_of(Stamped(late), NOW_US) == NOW_US - 250_000
