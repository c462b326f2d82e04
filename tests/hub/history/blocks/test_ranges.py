"""Ranges: a set of sequence numbers."""

from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.blocks.ranges import Ranges

pytestmark = pytest.mark.pure

spans = st.lists(st.tuples(st.integers(0, 40), st.integers(0, 40)), max_size=20)


@given(spans, st.integers(0, 40), st.integers(0, 40))
def test_a_range_set_is_the_set_of_its_numbers(added, first, past) -> None:
    ranges, numbers = Ranges(added), {n for a, b in added for n in range(a, b)}
    assert {n for a, b in ranges for n in range(a, b)} == numbers
    missing = [n for a, b in ranges.missing_ranges(first, past) for n in range(a, b)]
    assert missing == [n for n in range(first, past) if n not in numbers]
    assert ranges.contiguous_end() == next(n for n in range(99) if n not in numbers)


@given(spans)
def test_ranges_neither_touch_nor_overlap(added) -> None:
    ranges = list(Ranges(added))
    assert all(end < start for (_, end), (start, _) in pairwise(ranges))
    assert all(first < past for first, past in ranges)
