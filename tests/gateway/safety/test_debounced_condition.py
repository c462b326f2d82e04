"""Limits that let go elsewhere, limits that must be passed for a while, ladders of dwell times."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.condition_judge import judge_reading
from talaia.gateway.safety.debounced_condition import BadTimeWindow, DebouncedCondition
from talaia.gateway.safety.interlock_state import InterlockStateMachine, InterlockVerdict
from talaia.model.connection import RosSource
from talaia.model.interlocks.interlock import Condition, Interlock
from talaia.model.site import Signal

pytestmark = pytest.mark.pure

WIND = Signal(name="Wind", max_age=5.0, source=RosSource(topic="/w"))


def look(
    wire: DebouncedCondition, value: float | None, second: float, age: float = 0.0
) -> InterlockVerdict:
    reading = None if value is None else ChannelReading(value, 0)
    return wire.judge_condition(
        lambda each: judge_reading(
            condition=each, signal=WIND, reading=reading, age_ns=round(age * SECOND)
        ),
        round(second * SECOND),
    )


def test_it_trips_at_one_limit_and_lets_go_at_the_other() -> None:
    wire = DebouncedCondition(Condition(signal="w/w", above=45, until_below=35))
    said = [bool(look(wire, value, at).why) for at, value in enumerate([40, 46, 40, 36, 34, 40])]
    assert said == [False, True, True, True, False, False]


def test_below_works_the_same_the_other_way_round() -> None:
    wire = DebouncedCondition(Condition(signal="w/w", below=10, until_above=20))
    said = [bool(look(wire, value, at).why) for at, value in enumerate([15, 9, 15, 21, 15])]
    assert said == [False, True, True, False, False]


def test_a_limit_passed_for_a_moment_is_no_matter_but_silence_is_at_once() -> None:
    wire = DebouncedCondition(Condition(signal="w/w", above=45, lasting=10))
    assert not look(wire, 50, 0).why
    assert not look(wire, 50, 9.9).why
    assert not look(wire, 40, 9.95).why
    assert not look(wire, 50, 10).why
    assert look(wire, 50, 20).why
    silent = look(
        DebouncedCondition(Condition(signal="w/w", above=45, lasting=10, dwell=9)), 1, 0, age=6
    )
    assert silent.unknown
    assert silent.dwell is None


@pytest.mark.parametrize(("bad_s", "good_s"), [(1, 1), (5, 1), (2, 2), (9, 9)])
def test_weather_that_comes_and_goes_locks(bad_s: int, good_s: int) -> None:
    wire = DebouncedCondition(Condition(signal="w/w", above=45, lasting=10))
    tenths = [(at / 10, 50 if at / 10 % (bad_s + good_s) < bad_s else 40) for at in range(400)]
    tripped = [at for at, value in tenths if look(wire, value, at).why]
    assert tripped
    assert 10 <= tripped[0] <= 20.2


def test_what_is_mostly_good_does_not_lock() -> None:
    wire = DebouncedCondition(Condition(signal="w/w", above=45, lasting=10))
    tenths = [(at / 10, 50 if at / 10 % 3 < 1 else 40) for at in range(2000)]
    assert not any(look(wire, value, at).why for at, value in tenths)


@given(
    st.lists(st.tuples(st.integers(1, 4000), st.booleans()), max_size=80),
    st.integers(1, 100).map(lambda each: each * 1000),
)
def test_the_time_that_was_bad_is_counted_to_a_hundredth_of_the_window(
    looks: list[tuple[int, bool]], window: int
) -> None:
    counted, now, history = BadTimeWindow(window), 0, list[tuple[int, int]]()
    was = False
    for passed, bad in looks:
        if was:
            history.append((now, now + passed))
        now += passed
        found = counted.add_reading(now, bad=bad)
        exactly = sum(max(0, to - max(since, now - window)) for since, to in history)
        assert exactly <= found <= exactly + window // BadTimeWindow.PARTS
        was = bad


@given(st.lists(st.tuples(st.floats(0, 100), st.floats(0.1, 5)), max_size=60))
def test_between_the_limits_it_stays_as_it_was(values: list[tuple[float, float]]) -> None:
    wire = DebouncedCondition(Condition(signal="w/w", above=45, until_below=35))
    now, before = 0.0, False
    for value, seconds in values:
        now += seconds
        unsafe = bool(look(wire, value, now).why)
        if value > 45:
            assert unsafe
        elif value <= 35:
            assert not unsafe
        else:
            assert unsafe == before
        before = unsafe


def test_the_longest_dwell_time_of_all_that_was_unsafe_counts() -> None:
    latch = InterlockStateMachine("w", Interlock(name="W", when=(), dwell=1), 0)
    latch.update_state(InterlockVerdict("humid", dwell=30), 0)
    latch.update_state(InterlockVerdict("very humid", dwell=90), 1 * SECOND)
    latch.update_state(InterlockVerdict("humid", dwell=30), 2 * SECOND)
    latch.update_state(InterlockVerdict(), 3 * SECOND)
    assert latch.locked
    latch.update_state(InterlockVerdict(), 92 * SECOND)
    assert latch.locked
    latch.update_state(InterlockVerdict(), 94 * SECOND)
    assert not latch.locked
    latch.update_state(InterlockVerdict("windy", dwell=10), 100 * SECOND)
    latch.update_state(InterlockVerdict(), 101 * SECOND)
    latch.update_state(InterlockVerdict(), 112 * SECOND)
    assert not latch.locked


def test_it_wants_the_roof_closed_from_the_first_certain_word_until_it_lets_go() -> None:
    latch = InterlockStateMachine("w", Interlock(name="W", when=(), dwell=10), 0)
    latch.update_state(InterlockVerdict("no value yet", certain=False), 0)
    assert not latch.demands
    latch.update_state(InterlockVerdict("rain"), 1 * SECOND)
    assert latch.demands
    latch.update_state(InterlockVerdict(), 2 * SECOND)
    assert latch.demands
    latch.update_state(InterlockVerdict(), 13 * SECOND)
    assert not latch.demands
