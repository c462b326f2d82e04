"""Rollups: sums of many samples."""

import math

import numpy as np
from hypothesis import given, settings, strategies as st

from talaia.hub.history.blocks.rollup import (
    WIDTHS,
    cover_window,
    finest_width,
    join_cells,
    merge_cells,
    summarise_samples,
    tier_for,
)
from talaia.hub.history.blocks.rows import SUMMARY, cells_to_rows, rows_to_cells

numbers = st.one_of(
    st.integers(-5, 5).map(float), st.sampled_from([math.nan, math.inf, -math.inf, -0.0, 1e300])
)
runs = st.lists(st.lists(st.tuples(st.integers(-50, 50), numbers), min_size=1), min_size=1)


def columns(pairs):
    pairs = sorted(pairs, key=lambda pair: pair[0])
    return np.array([t for t, _ in pairs], np.int64), np.array([v for _, v in pairs])


@settings(deadline=None)
@given(runs, st.integers(1, 40))
def test_merged_sums_are_the_sums_of_all(parts, width) -> None:
    merged = merge_cells(join_cells([summarise_samples(*columns(part), width) for part in parts]))
    whole = summarise_samples(*columns([pair for part in parts for pair in part]), width)
    assert merged.bucket_us.tolist() == whole.bucket_us.tolist()
    for name in ("samples", "numbers", "low", "high", "last_us"):
        np.testing.assert_array_equal(getattr(merged, name), getattr(whole, name), name)
    np.testing.assert_allclose(merged.total, whole.total, rtol=1e-12)


@settings(deadline=None)
@given(runs, st.integers(1, 40))
def test_extremes_and_last_stand_at_their_own_time(parts, width) -> None:
    pairs = [pair for part in parts for pair in part]
    there = {(t, v if v == v else None) for t, v in pairs}
    cells = summarise_samples(*columns(pairs), width)
    for name in ("low", "high", "last"):
        for t, v in zip(getattr(cells, name + "_us"), getattr(cells, name), strict=True):
            assert (t, v if v == v else None) in there


@settings(deadline=None)
@given(runs, st.integers(1, 40))
def test_a_row_gives_back_its_cell(parts, width) -> None:
    cells = summarise_samples(*columns(parts[0]), width)
    rows = cells_to_rows(cells, channel_id=1)
    assert all(value is None or math.isfinite(value) for row in rows for value in row.values()), (
        "MariaDB keeps neither NaN nor infinity"
    )
    back = rows_to_cells([[row["bucket_us"], *(row[n] for n in SUMMARY)] for row in rows])
    for mine, other in zip(cells, back, strict=True):
        np.testing.assert_array_equal(mine, other)


@settings(deadline=None)
@given(st.integers(-(2**50), 2**50), st.integers(0, 2**48), st.sampled_from((0, *WIDTHS)))
def test_a_cover_fills_the_window_without_overlap(start, span, width) -> None:
    pieces = cover_window(start, start + span, width)
    at = start
    for piece in pieces:
        assert piece.from_us == at < piece.past_us
        at = piece.past_us
        if piece.width_us:
            assert piece.from_us % piece.width_us == piece.past_us % piece.width_us == 0
    assert at == start + span or not span
    narrow = [piece for piece in pieces if piece.width_us < width]
    assert sum(piece.past_us - piece.from_us for piece in narrow) < 2 * max(width, 1)


def test_rows_are_written_where_they_save_work() -> None:
    second = 1_000_000
    assert finest_width(np.arange(4096) * 10_000) == 5 * second
    assert finest_width(np.arange(4096) * second) == 120 * second
    assert finest_width(np.arange(4096) * 3600 * second) == 0


def test_a_day_a_week_and_a_month_have_buckets_that_fit_a_pixel() -> None:
    day = 86_400_000_000
    assert [tier_for(n * day // 999) // 1_000_000 for n in (1, 7, 30, 365)] == [30, 120, 600, 3600]
    assert tier_for(1_000_000) == 0
