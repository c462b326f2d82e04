"""What is acknowledged to a gateway: all below the first hole."""

import pytest
from hypothesis import given, strategies as st

from talaia.hub.live.gateways.acknowledged_sequence import StoredRun

pytestmark = pytest.mark.pure

spans = st.lists(st.tuples(st.integers(0, 60), st.integers(1, 12)), max_size=30)


@given(st.integers(0, 10), spans)
def test_acknowledged_is_what_lies_below_the_first_hole(below, batches) -> None:
    run = StoredRun(below)
    stored = set(range(below))
    for first, count in batches:
        run.add_stored(first, first + count)
        stored.update(range(first, first + count))
        hole = next(number for number in range(10_000) if number not in stored)
        assert run.below == hole
