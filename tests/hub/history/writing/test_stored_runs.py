"""Which numbers of a boot are stored: many rows of the journal at once as each by itself."""

import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.writing.stored_runs import StoredRuns

pytestmark = pytest.mark.pure

row = st.tuples(st.integers(1, 3), st.integers(0, 30), st.integers(0, 5))


@given(st.lists(row, max_size=30))
def test_rows_at_once_count_as_rows_one_by_one(rows) -> None:
    together, one_by_one = StoredRuns(), StoredRuns()
    together.add_rows(*(zip(*rows, strict=True) if rows else ((), (), ())))
    for boot, first, samples in rows:
        one_by_one.add_stored(boot, first, first + samples)
    for boot in (1, 2, 3):
        assert [*together.stored_of(boot)] == [*one_by_one.stored_of(boot)]
        assert together.settled_below(boot) == one_by_one.settled_below(boot)
