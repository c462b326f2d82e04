"""Pairs that cost least in all."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.objects.assignment import assign_pairs

pytestmark = pytest.mark.pure
costs = st.integers(1, 5).flatmap(
    lambda columns: st.lists(
        st.lists(
            st.one_of(st.integers(0, 20).map(float), st.just(np.inf)),
            min_size=columns, max_size=columns,
        ),
        min_size=1, max_size=5,
    )
)  # fmt: skip


def best(table: np.ndarray) -> tuple[int, float]:
    """Try all: most pairs first, then the least cost."""
    if not len(table):
        return 0, 0.0
    found = [best(table[1:])]
    for column in np.flatnonzero(np.isfinite(table[0])):
        pairs, cost = best(np.delete(table[1:], column, axis=1))
        found.append((pairs + 1, cost + table[0, column]))
    return min(found, key=lambda one: (-one[0], one[1]))


@given(costs)
def test_as_many_pairs_as_may_be_cost_as_little_as_trying_all_finds(told) -> None:
    table = np.array(told)
    pairs = assign_pairs(table)
    assert len({row for row, _ in pairs}) == len({column for _, column in pairs}) == len(pairs)
    assert (len(pairs), sum(table[pair] for pair in pairs)) == pytest.approx(best(table))


def test_an_empty_table_has_no_pairs() -> None:
    assert assign_pairs(np.zeros((0, 3))) == []
    assert assign_pairs(np.full((2, 2), np.inf)) == []
