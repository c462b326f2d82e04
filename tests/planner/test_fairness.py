"""What a proposal's minutes count for, by what it lacks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.planner.fairness import EVEN_HANDED, INDIFFERENT, adjust_merits

pytestmark = pytest.mark.pure

DUE = np.array([0.5, 0.5, 0.0])


def test_who_lacks_counts_for_more_and_who_has_too_much_less():
    shutter = np.array([9000.0, 1000.0, 500.0])
    merits = adjust_merits(EVEN_HANDED, np.ones(3), due=DUE, shutter_s=shutter)
    assert merits[0] < 1.0 < merits[1]
    # Rapid requests: nothing is due to them, and their priority alone counts.
    assert merits[2] == 1.0


def test_shares_that_agree_well_enough_let_it_fade():
    shutter = np.array([5000.0, 4900.0, 0.0])
    merits = adjust_merits(EVEN_HANDED, np.array([1.5, 0.5, 1.0]), due=DUE, shutter_s=shutter)
    assert 1.0 < merits[0] < 1.5
    assert 0.5 < merits[1] < 1.0


def test_without_the_rule_priorities_alone_count():
    shutter = np.array([9000.0, 0.0, 0.0])
    merits = adjust_merits(INDIFFERENT, np.ones(3), due=DUE, shutter_s=shutter)
    assert (merits == 1.0).all()


@given(st.lists(st.floats(0, 1e6), min_size=3, max_size=3))
def test_no_merit_grows_beyond_its_limit(shutter):
    merits = np.ones(3)
    for _ in range(100):
        merits = adjust_merits(EVEN_HANDED, merits, due=DUE, shutter_s=np.array(shutter))
    assert 1.0 / EVEN_HANDED.most <= merits.min() <= merits.max() <= EVEN_HANDED.most
