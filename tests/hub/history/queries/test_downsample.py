"""Thinning: fewer points, and nothing lost that can be seen."""

import numpy as np
from hypothesis import given, strategies as st

from talaia.hub.history.queries.downsample import (
    bucket_extremes,
    bucket_starts,
    distinct_positions,
    edges_of,
    pixel_width,
)

values = st.floats(width=64, allow_nan=True, allow_infinity=True)
samples = st.lists(st.tuples(st.integers(-1000, 1000), values), min_size=1, max_size=80)


def columns(pairs):
    pairs = sorted(pairs, key=lambda pair: pair[0])
    return np.array([t for t, _ in pairs], np.int64), np.array([v for _, v in pairs])


@given(samples, st.integers(1, 300))
def test_extremes_are_the_least_and_the_greatest_of_each_pixel(pairs, pixel) -> None:
    time_us, value = columns(pairs)
    starts = bucket_starts(time_us, pixel)
    low, high = bucket_extremes(value, starts)
    for at, start in enumerate(starts):
        inside = value[time_us // pixel == time_us[start] // pixel]
        numbers = inside[~np.isnan(inside)]
        if numbers.size:
            assert value[low[at]] == numbers.min()
            assert value[high[at]] == numbers.max()
        else:
            assert low[at] == high[at] == start


@given(st.integers(-(2**40), 2**40), st.integers(0, 2**40), st.integers(2, 50), st.integers(1, 99))
def test_a_window_never_covers_more_pixels_than_the_chart_has(start, span, width, multiple) -> None:
    pixel = pixel_width(span + 1, width, multiple)
    assert pixel % multiple == 0
    assert (start + span) // pixel - start // pixel + 1 <= width


@given(samples, st.integers(1, 300))
def test_first_and_last_of_each_pixel_are_its_edges(pairs, pixel) -> None:
    time_us, _ = columns(pairs)
    kept = edges_of(bucket_starts(time_us, pixel), time_us.size)
    buckets = (time_us // pixel).tolist()
    wanted = {buckets.index(b) for b in buckets}
    wanted |= {len(buckets) - 1 - buckets[::-1].index(b) for b in buckets}
    assert kept.tolist() == sorted(wanted)


def test_one_pixel_takes_all() -> None:
    assert pixel_width(1000, 1) == 0
    assert bucket_starts(np.array([1, 500, 999]), 0).tolist() == [0]
    assert bucket_starts(np.empty(0, np.int64), 0).size == 0


@given(st.lists(st.lists(st.integers(0, 50))))
def test_positions_of_several_lists_stand_once_and_in_order(lists) -> None:
    arrays = [np.array(one, np.intp) for one in [[], *lists]]
    assert distinct_positions(arrays).tolist() == sorted({at for one in lists for at in one})
