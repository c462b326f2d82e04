"""Quantiles of more numbers than are held are exact, or are known to be missed."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from many_examples import examples

from talaia.hub.history.queries.quantiles import Ranks

PARTS = (0.25, 0.75)


def asked(pieces, kept):
    ranks = Ranks(PARTS, kept)
    for piece in pieces:
        ranks.add_values(np.asarray(piece, float))
    return ranks


def linear(values):
    return [float(each) for each in np.quantile(np.asarray(values, float), PARTS)]


@settings(max_examples=examples(75, many=3000), deadline=None)
@given(
    st.lists(
        st.lists(st.floats(-1e6, 1e6) | st.sampled_from([0.0, 1.0, 1.5]), max_size=60), max_size=30
    ),
    st.sampled_from([4, 16, 64, 10_000]),
)
def test_quantiles_are_those_of_all_numbers_or_none_are_given(pieces, kept) -> None:
    ranks = asked(pieces, kept)
    every = [each for piece in pieces for each in piece]
    found = ranks.quantiles()
    assert ranks.count == len(every)
    if not every:
        assert all(math.isnan(each) for each in found)
    elif found is not None:
        assert found == pytest.approx(linear(every), rel=1e-12, abs=1e-9)
    else:
        assert kept < len(every)


# A signal that drifts: each piece lies somewhere else than the one before, by much or by nothing.
drifting = st.lists(
    st.tuples(
        st.sampled_from([0, 0, 0, 50, -50, 1_000]),
        st.lists(st.integers(-9, 9), min_size=1, max_size=60),
    ),
    min_size=2,
    max_size=15,
).map(lambda steps: [
    [float(sum(step for step, _ in steps[: at + 1]) + each) for each in piece]
    for at, (_, piece) in enumerate(steps)
])  # fmt: skip


@settings(max_examples=examples(50, many=2000), deadline=None)
@given(drifting, st.sampled_from([1, 4, 16, 64]))
@example([[0.0] * 20, [1000.0] * 300, [1001.0] * 300], 4)
def test_a_signal_that_drifts_gives_exact_quantiles_or_says_that_they_were_missed(
    pieces, kept
) -> None:
    found = asked(pieces, kept).quantiles()
    every = [each for piece in pieces for each in piece]
    if found is not None:
        assert found == pytest.approx(linear(every), rel=1e-12, abs=1e-9)
    # Who looks again holds four times as much each time, so that it is found in the end.
    while found is None:
        assert kept < len(every)
        kept *= 4
        found = asked(pieces, kept).quantiles()
    assert found == pytest.approx(linear(every), rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("decimals", [15, 2, 0])
def test_pieces_in_any_order_give_exact_quantiles_of_far_more_numbers_than_are_held(
    decimals,
) -> None:
    random = np.random.default_rng(5)
    every = np.round(random.normal(0.0, 3.0, 400_000), decimals)
    ranks = asked(np.array_split(every, 100), 20_000)
    assert ranks.quantiles() == linear(every)


def test_what_is_no_finite_number_does_not_count() -> None:
    ranks = asked([[1.0, math.nan, 2.0], [math.inf, 3.0, -math.inf]], 100)
    assert ranks.count == 3
    assert ranks.quantiles() == [1.5, 2.5]


def test_a_quantile_that_the_first_pieces_misled_about_is_not_given() -> None:
    # All low numbers come first, so that the bracket closes around them.
    ranks = asked([np.arange(at, at + 1_000.0) for at in range(0, 100_000, 1_000)], 1_000)
    assert ranks.quantiles() is None
