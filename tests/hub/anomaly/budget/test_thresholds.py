"""Thresholds for so many false alarms a week: counted where they can be, carried on else."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from talaia.hub.anomaly.budget.score_tail import BLOCK_US, MOST_PEAKS, WEEK_BLOCKS, Peak, ScoreTail
from talaia.hub.anomaly.budget.thresholds import Basis, site_thresholds

FIRST = 20_000 * 144
BEGAN = FIRST * BLOCK_US


def tails_of(
    seed: int, weeks: float, count: int, *, tail: str = "normal"
) -> dict[tuple[str, str], ScoreTail]:
    """Make detectors whose magnitudes are of one kind, each in a unit of its own."""
    rng = np.random.default_rng(seed)
    blocks = int(weeks * WEEK_BLOCKS)
    found = {}
    for at in range(count):
        sizes = {
            "normal": lambda: rng.normal(size=blocks) ** 2,
            "exponential": lambda: rng.exponential(size=blocks),
            "heavy": lambda: rng.pareto(3.0, size=blocks) + 1.0,
        }[tail]()
        there = np.flatnonzero(rng.random(blocks) < 0.15)
        greatest = np.sort(there[np.argsort(-sizes[there])[:MOST_PEAKS]])
        first = FIRST + greatest
        peaks = [
            Peak(block, block, size * 10.0**at)
            for block, size in zip(first.tolist(), sizes[greatest].tolist(), strict=True)
        ]
        days = {FIRST // 144 + day: 144 for day in range(blocks // 144)}
        days[FIRST // 144 + blocks // 144] = blocks % 144
        found[f"device/signal{at}", "change"] = ScoreTail(peaks=[peaks], days=days)
    return found


def alarms_of(tails, thresholds) -> int:
    """Count what would be told: peaks above, those of neighbouring blocks once."""
    blocks = sorted(
        (peak.first, peak.last)
        for key, tail in tails.items()
        for peaks, need in zip(tail.peaks, thresholds.of[key], strict=True)
        for peak in peaks
        if peak.greatest >= need
    )
    alarms, end = 0, -10
    for first, last in blocks:
        alarms += first > end + 1
        end = max(end, last)
    return alarms


@pytest.mark.parametrize("kind", ["normal", "exponential", "heavy"])
@pytest.mark.parametrize("count", [1, 8])
@pytest.mark.parametrize("weeks", [1, 3])
def test_a_week_to_come_has_as_many_false_alarms_as_asked_for(kind, count, weeks):
    found = 0
    for seed in range(24):
        thresholds = site_thresholds(tails_of(seed, weeks, count, tail=kind), 1.0)
        coming = tails_of(1000 + seed, 1.0, count, tail=kind)
        found += alarms_of(coming, thresholds)
    # Weeks in which 24 are due. After one week it is estimated, after three they are counted.
    assert 12 <= found <= 48


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.1, 10.0), st.floats(1.1, 5.0))
def test_who_bears_fewer_gets_higher_thresholds(seed, a_week, times):
    tails = tails_of(seed, 2.0, 3)
    few, many = site_thresholds(tails, a_week), site_thresholds(tails, a_week * times)
    for key, needs in few.of.items():
        assert all(one >= other for one, other in zip(needs, many.of[key], strict=True))


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10_000), st.floats(1e-6, 1e6))
def test_the_unit_of_a_signal_does_not_matter(seed, unit):
    tails, scaled = tails_of(seed, 1.0, 2), tails_of(seed, 1.0, 2)
    for tail in scaled.values():
        for peak in tail.peaks[0]:
            peak.greatest *= unit
    one, other = site_thresholds(tails, 1.0), site_thresholds(scaled, 1.0)
    for key, needs in one.of.items():
        assert other.of[key] == pytest.approx(tuple(need * unit for need in needs), rel=1e-6)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10_000))
def test_each_detector_gets_a_fair_share(seed):
    # In the mean of five sites: of one, chance alone leaves a detector with one in a hundred times.
    told = np.zeros(4)
    for site in range(5):
        tails = tails_of(seed + 10_001 * site, 8.0, 4)
        thresholds = site_thresholds(tails, 4.0)
        told += [
            sum(peak.greatest >= thresholds.of[key][0] for peak in tail.peaks[0]) / 5
            for key, tail in tails.items()
        ]
    assert min(told) >= 2
    # 32 are due; what falls into neighbouring blocks is one alarm and several peaks.
    assert 16 <= sum(told) <= 64


def test_before_a_day_was_seen_nothing_is_set_and_it_is_said():
    thresholds = site_thresholds(tails_of(1, 0.1, 3), 1.0)
    assert thresholds.basis is Basis.LEARNING
    assert thresholds.of == {}
    assert thresholds.needed == 3 * WEEK_BLOCKS


def test_it_is_said_whether_false_alarms_could_be_counted():
    assert site_thresholds(tails_of(1, 2.0, 3), 1.0).basis is Basis.SHORT
    assert site_thresholds(tails_of(1, 3.0, 3), 1.0).basis is Basis.COUNTED
    assert site_thresholds(tails_of(1, 2.0, 3), 2.0).basis is Basis.COUNTED


def test_a_fault_that_nobody_confirmed_does_not_make_the_site_deaf():
    tails = tails_of(3, 1.0, 3)
    before = site_thresholds(tails, 1.0)
    key = "device/signal0", "change"
    tails[key].record_magnitudes(BEGAN + int(0.99 * WEEK_BLOCKS) * BLOCK_US + 1, [1e9])
    after = site_thresholds(tails, 1.0)
    assert after.of[key][0] < 2 * before.of[key][0]


def test_a_machine_that_stands_still_half_of_the_time_does_not_make_the_site_deaf():
    tails = tails_of(3, 1.0, 3)
    peaks = tails["device/signal0", "change"].peaks[0]
    # While it stands a change of nothing at all is a rare one, but no great one.
    for at, peak in enumerate(peaks):
        peak.greatest *= 1e-30 if at % 2 else 1.0
    for key, needs in site_thresholds(tails, 1.0).of.items():
        assert needs[0] < 10 * max(peak.greatest for peak in tails[key].peaks[0])


def test_a_site_without_a_single_peak_has_finite_thresholds():
    tail = ScoreTail()
    for block in range(WEEK_BLOCKS):
        tail.see_time(BEGAN + block * BLOCK_US)
    tail.record_magnitudes(BEGAN + WEEK_BLOCKS * BLOCK_US, [0.0])
    (needs,) = site_thresholds({("a/b", "change"): tail}, 1.0).of.values()
    assert all(math.isfinite(need) for need in needs)


def test_peaks_next_to_nothing_beside_great_ones_leave_thresholds_finite():
    tail = ScoreTail(days=dict(tails_of(3, 1.0, 1)["device/signal0", "change"].days))
    # As far apart as numbers can be.
    tail.peaks = [
        [Peak(FIRST + 6 * at, FIRST + 6 * at, 10.0 ** (-320 + 16 * at)) for at in range(23)]
    ]
    (needs,) = site_thresholds({("a/b", "change"): tail}, 1.0).of.values()
    assert all(math.isfinite(need) and need > 0.0 for need in needs)


def test_a_detector_that_is_silent_on_every_other_day_leaves_thresholds_finite():
    tails = tails_of(3, 1.0, 3)
    before = site_thresholds(tails, 1.0)
    tail = ScoreTail(days=dict(tails["device/signal0", "change"].days))
    # Six peaks on the days of one side, and nothing at all on those between.
    for at in range(12):
        day, magnitude = (2 * (at % 3), 11.0) if at < 6 else (2 * (at % 3) + 1, 0.0)
        block = FIRST + 144 * day + 10 + 6 * at
        tail.peaks = tail.peaks or [[]]
        tail.peaks[0].append(Peak(block, block, magnitude))
    tail.peaks[0].sort(key=lambda peak: peak.first)
    tails["device/still", "still"] = tail
    after = site_thresholds(tails, 1.0)
    for needs in after.of.values():
        assert all(math.isfinite(need) and need > 0.0 for need in needs)
    key = "device/signal0", "change"
    assert after.of[key][0] < 10 * before.of[key][0]


def test_one_long_fault_is_one_alarm_and_not_one_for_each_hour():
    tails = tails_of(3, 4.0, 3)
    key = "device/signal0", "change"
    before = site_thresholds(tails, 1.0)
    for block in range(60):
        tails[key].record_magnitudes(BEGAN + (5 * WEEK_BLOCKS + block) * BLOCK_US, [1e9])
    after = site_thresholds(tails, 1.0)
    assert after.of[key][0] < 3 * before.of[key][0]
