"""What a block is worth that begins later, or that takes long, under a roof that may close."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.planner.outlook import CERTAIN, WeatherOutlook

pytestmark = pytest.mark.pure

BLOCKS = np.array([60, 600, 3600])


def test_a_long_block_is_less_likely_to_be_completed_than_a_short_one():
    likely = WeatherOutlook(open_s=10_000.0, lost=0.5).completion(BLOCKS)
    assert (np.diff(likely) < 0.0).all()
    assert likely[-1] == pytest.approx(np.exp(-0.18))


def test_under_a_roof_that_stays_open_every_block_is_completed():
    assert (CERTAIN.completion(BLOCKS) == 1.0).all()


def test_what_is_always_completed_later_loses_nothing_by_its_length():
    assert (WeatherOutlook(lost=0.0).completion(BLOCKS) == 1.0).all()
