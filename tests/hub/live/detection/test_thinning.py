"""Which samples of fast signals a detector is shown."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.hub.live.detection.thinning import Thinning
from talaia.wire.columns import Columns

pytestmark = pytest.mark.pure

NOW = 1_795_000_000_000_000
SECOND = 1_000_000
FAST, SLOW, ALL = 0, 1, 2


def thinning() -> Thinning:
    return Thinning(np.array([True, True, False]))


def picked(thin: Thinning, *rows: tuple[int, float]) -> list[float]:
    """Give the seconds of those samples of a batch that are looked at."""
    channel = np.array([row[0] for row in rows], np.uint16)
    time_us = np.array([NOW + round(row[1] * SECOND) for row in rows], np.int64)
    at = thin.pick_samples(Columns(channel, time_us, np.zeros(len(rows)), {}), np.arange(len(rows)))
    return [round((int(time_us[each]) - NOW) / SECOND, 3) for each in at]


@pytest.mark.parametrize("batch", [1, 5, 300], ids=["one by one", "live", "after a gap"])
def test_one_sample_a_second_is_taken_however_they_are_batched(batch) -> None:
    rows, thin = [(FAST, at / 100) for at in range(300)], thinning()
    taken = [each for at in range(0, 300, batch) for each in picked(thin, *rows[at : at + batch])]
    assert taken == [0.0, 0.9, 1.8, 2.7]


def test_a_signal_of_1_hz_whose_clock_trembles_loses_none() -> None:
    thin, times = thinning(), [0.0, 1.04, 1.97, 3.02, 3.95]
    assert [each for at in times for each in picked(thin, (SLOW, at))] == times


def test_channels_do_not_stand_in_each_others_way_and_order_stays() -> None:
    rows = [(FAST, 0.0), (ALL, 0.0), (SLOW, 0.01), (ALL, 0.02), (FAST, 0.03)]
    assert picked(thinning(), *rows) == [0.0, 0.0, 0.01, 0.02]


def test_what_comes_late_is_handed_on_for_counting() -> None:
    thin = thinning()
    assert picked(thin, (FAST, 10.0)) == [10.0]
    assert picked(thin, (FAST, 5.0), (FAST, 5.01)) == [5.0]
    assert picked(thin, (FAST, 10.5)) == []


def test_a_site_without_thinned_signals_is_handed_on_whole() -> None:
    assert picked(Thinning(np.zeros(3, bool)), (FAST, 0.0), (FAST, 0.01)) == [0.0, 0.01]
