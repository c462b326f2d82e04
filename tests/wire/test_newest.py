"""Newest samples on the wire: columns that cannot be are refused."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.wire.columns import Columns
from talaia.wire.errors import PeerError
from talaia.wire.newest import NewestSamples, newest_frame, newest_of

pytestmark = pytest.mark.pure


def sample_at(time_us: int) -> NewestSamples:
    columns = Columns(
        np.array([0], np.uint16), np.array([time_us], np.int64), np.array([1.0], np.float64), {}
    )
    return NewestSamples(columns, np.array([0], np.int64), np.array([0.0], np.float64))


@pytest.mark.parametrize("time_us", [-(2**63), -(2**62), 2**62, 2**63 - 1])
def test_time_that_cannot_be_is_refused(time_us: int) -> None:
    with pytest.raises(PeerError, match="a time"):
        newest_of(newest_frame(sample_at(time_us), "boot-a", "cat"))


@pytest.mark.parametrize("time_us", [-(2**62) + 1, 0, 2**62 - 1])
def test_time_within_the_range_is_read_back(time_us: int) -> None:
    known = newest_of(newest_frame(sample_at(time_us), "boot-a", "cat"))
    assert known.columns.time_us.tolist() == [time_us]
