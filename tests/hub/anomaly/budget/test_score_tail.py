"""The greatest magnitudes of the past, in blocks of ten minutes."""

from __future__ import annotations

import msgspec
import numpy as np
from hypothesis import given, settings, strategies as st

from talaia.hub.anomaly.budget.score_tail import BLOCK_US, MOST_PEAKS, ScoreTail

DAY_US = 86_400_000_000
BEGAN = 20_000 * DAY_US


def tail_of(*peaks: tuple[int, float]) -> ScoreTail:
    """Record a magnitude in each of these blocks."""
    tail = ScoreTail()
    for block, magnitude in peaks:
        tail.record_magnitudes(BEGAN + block * BLOCK_US, [magnitude])
    return tail


def test_blocks_next_to_each_other_are_one_peak_with_the_greatest_of_them():
    tail = tail_of((0, 1.0), (1, 3.0), (2, 2.0), (4, 5.0))
    first = BEGAN // BLOCK_US
    assert [(one.first - first, one.last - first, one.greatest) for one in tail.peaks[0]] == [
        (0, 2, 3.0),
        (4, 4, 5.0),
    ]
    assert tail.blocks == 4


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.integers(1, 400), st.floats(0.01, 1e6)), min_size=1, max_size=120),
)
def test_it_is_bounded_and_holds_the_greatest_that_came(samples):
    tail, block = ScoreTail(), 0
    for step, magnitude in samples:
        block += step
        tail.record_magnitudes(BEGAN + block * BLOCK_US, [magnitude])
    assert len(tail.peaks[0]) <= MOST_PEAKS
    assert len(tail.days) <= 57
    days = {BEGAN // DAY_US + at for at in range(56)}
    if block * BLOCK_US < len(days) * DAY_US:
        assert max(one.greatest for one in tail.peaks[0]) == max(size for _, size in samples)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 400))
def test_many_samples_at_once_leave_the_same_as_one_by_one(seed, length):
    rng = np.random.default_rng(seed)
    times = BEGAN + np.cumsum(rng.integers(1, 900_000_000, length))
    sizes, eligible = rng.random((length, 3)), rng.random(length) < 0.3
    one, many = ScoreTail(), ScoreTail()
    for time_us, some, counts in zip(times.tolist(), sizes.tolist(), eligible, strict=True):
        one.see_time(time_us)
        if counts:
            one.record_magnitudes(time_us, some)
    for first in range(0, length, 37):
        part = slice(first, first + 37)
        many.record_many(times[part], eligible[part], sizes[part])
    assert msgspec.to_builtins(one) == msgspec.to_builtins(many)


def test_what_is_older_than_eight_weeks_is_forgotten():
    tail = tail_of((0, 9.0), *((day * 144, 1.0) for day in range(1, 60)))
    assert max(one.greatest for one in tail.peaks[0]) == 1.0
    assert tail.blocks == 56


def test_a_confirmed_stretch_is_no_false_alarm():
    tail = tail_of((0, 1.0), (10, 8.0), (20, 2.0))
    at = BEGAN + 10 * BLOCK_US
    tail.forget_stretch(at, at + 1_000_000)
    assert [one.greatest for one in tail.peaks[0]] == [1.0, 2.0]


def test_the_past_is_put_before_what_was_seen_live_and_not_counted_twice():
    live = tail_of((300, 2.0), (310, 4.0))
    past = tail_of((0, 1.0), (100, 6.0), (300, 2.0))
    live.add_past(past)
    assert [one.greatest for one in live.peaks[0]] == [1.0, 6.0, 2.0, 4.0]
    assert live.blocks == 4
    assert live.filled


def test_a_detector_that_always_says_something_has_a_peak_for_each_hour():
    tail = tail_of(*((block, 1.0 + block % 6) for block in range(24)))
    assert [one.greatest for one in tail.peaks[0]] == [6.0, 6.0, 6.0, 6.0]
