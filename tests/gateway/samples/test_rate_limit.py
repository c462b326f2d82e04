"""Sampling: what is kept, what is held back, and that the last word is never lost."""

from itertools import pairwise
from math import nan

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.samples.rate_limit import Sampler, SamplingRule, rule_of
from talaia.model.connection import RosSource
from talaia.model.site import Signal

pytestmark = pytest.mark.pure

SECOND = 1_000_000


def test_signal_without_limits_needs_no_sampler() -> None:
    source = RosSource(topic="/t", type="p/msg/T", field="data")
    assert rule_of(Signal(name="S", source=source)) is None
    rule = rule_of(Signal(name="S", source=source, max_rate=10, deadband=0.5, max_age=4))
    assert rule == SamplingRule(100_000, 0.5, 2 * SECOND)


def test_small_change_is_held_back_until_silence_is_too_long() -> None:
    sampler = Sampler(SamplingRule(deadband=0.5, max_silence_us=10 * SECOND))
    assert sampler.accept_sample(0, (3.0,))
    assert not sampler.accept_sample(9 * SECOND, (3.1,))
    assert sampler.accept_sample(10 * SECOND, (3.1,))


def test_sensor_that_starts_to_say_nan_is_heard_once() -> None:
    sampler = Sampler(SamplingRule(deadband=0.5))
    assert sampler.accept_sample(0, (3.0,))
    assert sampler.accept_sample(1, (nan,))
    assert not sampler.accept_sample(2, (nan,))


def test_last_value_of_a_burst_comes_out_when_its_turn_has_come() -> None:
    sampler = Sampler(SamplingRule(min_interval_us=SECOND))
    assert sampler.accept_sample(0, (1.0,))
    assert not sampler.accept_sample(1, (2.0,))
    assert not sampler.accept_sample(2, (3.0,))
    assert sampler.due_values(SECOND - 1) is None
    assert sampler.due_values(SECOND) == (3.0,)
    assert not sampler.holding
    assert sampler.due_values(2 * SECOND) is None


def test_clock_that_was_set_back_does_not_silence_a_signal() -> None:
    sampler = Sampler(SamplingRule(min_interval_us=SECOND))
    assert sampler.accept_sample(3600 * SECOND, (1.0,))
    assert sampler.accept_sample(0, (2.0,))


waits_and_values = st.tuples(st.integers(0, 3 * SECOND), st.floats(-50, 50))


@given(st.lists(waits_and_values, max_size=60))
def test_two_kept_samples_are_never_closer_than_the_interval(
    steps: list[tuple[int, float]],
) -> None:
    sampler = Sampler(SamplingRule(min_interval_us=SECOND, max_silence_us=5 * SECOND))
    now, kept, last = 0, [], None
    for wait, value in steps:
        now += wait
        if sampler.due_values(now) is not None:
            kept.append(now)
        if sampler.accept_sample(now, (value,)):
            kept.append(now)
        last = value
    assert all(later - earlier >= SECOND for earlier, later in pairwise(kept))
    # Whatever came last is out, or comes out.
    if last is not None and sampler.holding:
        assert sampler.due_values(now + SECOND) == (last,)
