"""Many samples at once are judged as one by one."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from talaia.hub.anomaly.base import copy_detector, dump_detector
from talaia.hub.anomaly.kinds import KINDS
from talaia.hub.anomaly.rarity import Rarity, rate_together
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.model.alarms.anomaly import DetectorKind, Watch

BEGAN = 1_700_000_000_000_000
SECOND = 1_000_000


def signal(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Make a signal with noise, steps, a stretch that stands still, a spike and gaps."""
    rng = np.random.default_rng(seed)
    steps = rng.choice([1, 1, 1, 1, 2, 400], count) * SECOND
    times = BEGAN + np.cumsum(steps)
    values = 20 + 3 * np.sin(np.arange(count) / 300) + rng.normal(0, 0.2, count)
    values[count // 2 : count // 2 + 40] += 6
    values[2 * count // 3 : 2 * count // 3 + 60] = 21.5
    values[-count // 5] = 1e9
    values[: count // 4] = np.round(values[: count // 4], 1)
    return times, values


def in_parts(times: np.ndarray, values: np.ndarray, seed: int):
    """Cut samples into parts of many lengths."""
    rng = np.random.default_rng([seed, 1])
    cuts = np.cumsum(rng.choice([1, 3, 64, 128, 500], len(times)))
    edges = [0, *cuts[cuts < len(times)].tolist(), len(times)]
    for first, upto in itertools.pairwise(edges):
        yield times[first:upto], values[first:upto]


@pytest.mark.parametrize("kind", ["change", "nearest", "season", "together", "baseline", "iqr"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_detector_scores_many_samples_as_one_by_one_and_knows_the_same_afterwards(kind, seed):
    times, values = signal(seed, 3_000)
    one, many = KINDS[kind].make(), KINDS[kind].make()
    expected = [one.see(int(at), float(value)) for at, value in zip(times, values, strict=True)]
    found = np.concatenate([many.see_many(*part) for part in in_parts(times, values, seed)])
    assert np.abs(found - expected).max() < 1e-9
    assert one.why() == many.why()
    # And goes on alike.
    at, value = int(times[-1]) + SECOND, 22.0
    assert many.see(at, value) == pytest.approx(one.see(at, value), abs=1e-9)


@pytest.mark.parametrize("kind", ["change", "nearest", "season", "together"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_many_samples_are_judged_by_is_that_of_one_by_one_to_the_last_bit(kind, seed):
    times, values = signal(seed, 4_000)
    one, many = KINDS[kind].make(), KINDS[kind].make()
    expected = []
    for at, value in zip(times.tolist(), values.tolist(), strict=True):
        one.see(at, value)
        expected.append(one.magnitudes())
    found = np.concatenate([many.rate_many(*part)[1] for part in in_parts(times, values, seed)])
    assert (found == np.array(expected)).all()


def test_rarities_found_together_are_those_of_each_by_itself():
    rng = np.random.default_rng(8)
    magnitudes = np.abs(rng.normal(0, 1, (3, 2_000))) * [[1.0], [1e-9], [1e6]]
    # Of the second there is none now and then.
    magnitudes[1, rng.random(2_000) < 0.1] = -1.0
    # And of a fourth there is none for long.
    magnitudes = np.vstack((magnitudes, magnitudes[0]))
    magnitudes[3, :1_000] = -1.0
    alone, joined = ([Rarity(), Rarity(), Rarity(memory=50.0), Rarity()] for _ in range(2))
    found = [
        rate_together(joined, part) for part in np.array_split(magnitudes, [7, 900, 903], axis=1)
    ]
    for place, one in enumerate(alone):
        expected = [
            one.rate_magnitude(each) if each >= 0 else 0.0 for each in magnitudes[place].tolist()
        ]
        assert np.abs(np.hstack(found)[place] - expected).max() < 1e-9
        assert (one.weight, one.seen) == (joined[place].weight, joined[place].seen)
        assert (one.bins == joined[place].bins).all()


def test_rarities_keep_their_state_to_the_last_bit_over_a_rescaling():
    rng = np.random.default_rng(3)
    # A short memory grows its weights so fast that they are scaled down many times.
    one, many = Rarity(memory=3.0), Rarity(memory=3.0)
    magnitudes = np.abs(rng.normal(0, 1, 5_000)) * 10.0 ** rng.integers(-18, 4, 5_000)
    expected = [one.rate_magnitude(float(each)) for each in magnitudes]
    found = many.rate_many(magnitudes)
    assert np.abs(found - expected).max() < 1e-9
    assert (one.weight, one.seen) == (many.weight, many.seen)
    assert (one.bins == many.bins).all()


@pytest.mark.parametrize("kind", ["together", "change", "iqr", "limits"])
def test_anomalies_begin_and_end_at_the_same_samples_with_the_same_words(kind):
    times, values = signal(4, 4_000)
    watch = Watch(detector=DetectorKind(kind), maximum=25.0 if kind == "limits" else None)
    one, many = (DetectorRunner("base/speed", "m/s", watch) for _ in range(2))
    expected = [
        turn
        for at, value in zip(times, values, strict=True)
        if (turn := one.score_sample(int(at), float(value))) is not None
    ]
    found = [turn for part in in_parts(times, values, 4) for turn in many.score_many(*part)[1]]
    assert len(expected) > 0
    assert [type(each) for each in found] == [type(each) for each in expected]
    for ours, theirs in zip(found, expected, strict=True):
        assert ours.why == theirs.why
        assert ours.score == pytest.approx(theirs.score, abs=1e-9)
    whole = [getattr(each, "began_us", 0) or each.time_us for each in expected]
    assert [getattr(each, "began_us", 0) or each.time_us for each in found] == whole
    assert (one.episodes.since, one.learning) == (many.episodes.since, many.learning)


def test_where_nobody_asks_why_the_same_anomalies_have_no_words():
    times, values = signal(4, 4_000)
    watch = Watch(detector=DetectorKind("together"))
    told, silent = (DetectorRunner("base/speed", "m/s", watch) for _ in range(2))
    silent.says_why = False
    expected, found = [], []
    for part in in_parts(times, values, 4):
        scores, turns = told.score_many(*part)
        expected += turns
        again, turns = silent.score_many(*part)
        found += turns
        assert np.abs(scores - again).max() < 1e-12
    assert len(found) == len(expected) > 0
    for ours, theirs in zip(found, expected, strict=True):
        assert theirs.why
        assert not ours.why
        assert type(ours) is type(theirs)
        assert ours.score == pytest.approx(theirs.score, abs=1e-12)
    assert dump_detector(silent.detector) == dump_detector(told.detector)


def test_a_copy_of_a_detector_knows_the_same_and_learns_nothing_from_the_other():
    times, values = signal(6, 1_500)
    detector = KINDS["together"].make(unit="V")
    detector.see_many(times[:1_400], values[:1_400])
    before = dump_detector(detector)
    copied = copy_detector(detector)
    assert dump_detector(copied) == before
    detector.see_many(times[1_400:], values[1_400:])
    detector.forgive()
    assert dump_detector(detector) != before
    assert dump_detector(copied) == before


@pytest.mark.parametrize("unit", [1e-200, 1e-9, 1.0, 1e140])
def test_stretches_are_compared_alike_in_every_unit_and_beside_a_spike(unit):
    times, values = signal(7, 2_500)
    values[1_800] = 1e6
    one, many = KINDS["nearest"].make(), KINDS["nearest"].make()
    pairs = zip(times.tolist(), (values * unit).tolist(), strict=True)
    expected = [one.see(at, value) for at, value in pairs]
    found = np.concatenate([many.see_many(*part) for part in in_parts(times, values * unit, 7)])
    assert np.abs(found - expected).max() < 1e-9
