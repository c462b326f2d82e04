"""Detectors see one sample at a time, say why, learn, and survive a restart."""

import math
import random

import pytest

from talaia.hub.anomaly.base import (
    AnomalyDetector,
    dump_detector,
    format_duration,
    format_number,
    load_detector,
)
from talaia.hub.anomaly.baseline import Baseline, Quartiles, Sorted
from talaia.hub.anomaly.change import ChangePointDetector
from talaia.hub.anomaly.context import Context
from talaia.hub.anomaly.ensemble import Together
from talaia.hub.anomaly.episode_runner import AnomalyBegan
from talaia.hub.anomaly.episodes import Episodes, EpisodeTurn
from talaia.hub.anomaly.kinds import KINDS
from talaia.hub.anomaly.rarity import Rarity
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.hub.anomaly.seasonal import Season
from talaia.hub.anomaly.simple_rules import LimitsDetector, Missing, RateOfChange, Still
from talaia.model.alarms.anomaly import Watch

SECOND = 1_000_000
STEP = 60 * SECOND


def noise(count: int, level: float = 12.0, seed: int = 1) -> list[float]:
    chance = random.Random(seed)  # noqa: S311 - noise
    return [level + chance.gauss(0.0, 0.1) for _ in range(count)]


def feed(
    detector: AnomalyDetector, values: list[float], first_us: int = 0, step: int = STEP
) -> list[float]:
    return [detector.see(first_us + at * step, value) for at, value in enumerate(values)]


LEARNING = ["together", "change", "nearest", "baseline", "iqr", "rate"]


@pytest.mark.parametrize("name", LEARNING)
def test_a_spike_scores_above_the_bar_and_noise_hardly_ever_does(name):
    kind = KINDS[name]
    detector = kind.make(unit="V")
    usual = feed(detector, noise(1500))[200:]
    spike = max(feed(detector, [15.0] * 4, 1500 * STEP))
    assert spike >= kind.bar
    assert sum(score >= kind.bar for score in usual) <= 0.03 * len(usual)
    assert "V" in detector.why()


@pytest.mark.parametrize("name", list(KINDS))
def test_scores_lie_between_0_and_1_whatever_comes(name):
    detector = KINDS[name].make()
    hostile = [0.0, 1e300, -1e300, 1e-300, 0.0, 0.0, 5.0] * 30 + [7.0] * 300 + noise(200)
    for score in feed(detector, hostile):
        assert 0.0 <= score <= 1.0
    for when in (10**15, 5, 10**15):  # clocks that jump
        assert 0.0 <= detector.see(when, 1.0) <= 1.0
    assert detector.why()


@pytest.mark.parametrize("name", list(KINDS))
def test_a_detector_that_was_kept_goes_on_as_if_nothing_had_happened(name):
    kind = KINDS[name].make
    straight, stopped = kind(unit="V"), kind(unit="V")
    values = noise(700)
    feed(straight, values)
    feed(stopped, values)
    woken = load_detector(kind, dump_detector(stopped))
    later = [*noise(50, seed=2), 14.0, 14.0, 12.0]
    assert feed(woken, later, 700 * STEP) == feed(straight, later, 700 * STEP)


@pytest.mark.parametrize("name", list(KINDS))
def test_what_a_detector_keeps_is_bounded(name):
    detector = KINDS[name].make()
    feed(detector, noise(4000))
    feed(detector, noise(4000, seed=3), 4000 * STEP)
    assert len(dump_detector(detector)) < 300_000


@pytest.mark.parametrize("name", ["together", "change", "nearest", "baseline", "iqr", "rate"])
def test_what_a_person_called_no_anomaly_is_not_told_again(name):
    kind = KINDS[name]
    detector = kind.make()
    feed(detector, noise(1500))
    assert max(feed(detector, [15.0, 15.0, 15.0], 1500 * STEP)) >= kind.bar
    assert detector.forgive()
    feed(detector, noise(300, seed=4), 1510 * STEP)
    again = max(feed(detector, [15.0, 15.0, 15.0], 1810 * STEP))
    assert again < kind.bar


def test_the_baseline_says_how_many_spreads_from_the_usual_value():
    detector = Baseline(unit="V")
    feed(detector, noise(600, level=11.9), step=SECOND)
    detector.see(600 * SECOND, 12.7)
    words = detector.why()
    assert words.startswith("12.7 V is ")
    assert "times the usual spread above the usual 11." in words
    assert words.endswith("of the last 8 min")


def test_the_baseline_goes_with_a_drift():
    detector = Baseline()
    rising = [value + at * 0.002 for at, value in enumerate(noise(3000))]
    assert max(feed(detector, rising)[1000:]) < 0.5


def test_the_season_finds_a_day_that_does_not_move():
    detector = Season()
    day = [10.0 + 5.0 * math.sin(at / 288 * 2 * math.pi) for at in range(288)]
    days = [
        value + off
        for each in range(8)
        for value, off in zip(day, noise(288, 0, each), strict=True)
    ]
    usual = feed(detector, days, step=5 * STEP)
    still = feed(detector, [10.0] * 288, 8 * 288 * 5 * STEP, 5 * STEP)
    assert max(still) > 0.95
    assert sum(score > 0.95 for score in usual[288 * 3 :]) < 20
    assert "same hours" in detector.why()


def test_the_context_is_surprised_by_a_broken_order():
    detector = Context()
    feed(detector, [float(at % 4) for at in range(1200)])
    usual = max(feed(detector, [float(at % 4) for at in range(40)], 1200 * STEP))
    broken = max(feed(detector, [3.0, 3.0, 0.0], 1240 * STEP))
    assert broken >= KINDS["context"].bar > usual


def test_a_flat_line_is_told_by_its_length():
    detector = Still(unit="°C", after_s=60.0)
    feed(detector, noise(50), step=SECOND)
    scores = feed(detector, [12.0] * 100, 50 * SECOND, SECOND)
    assert scores[59] < 0.5 <= scores[61]
    assert detector.why() == "12 °C for 2 min; 60 s are allowed"


def test_data_that_do_not_come_are_told_while_they_do_not():
    detector = Missing()
    feed(detector, [1.0] * 60, step=SECOND)
    assert detector.idle(60 * SECOND) < 0.5
    assert detector.idle(65 * SECOND) > 0.5
    assert detector.why() == "no sample for 6 s; usually one comes every 1 s"


def test_a_rate_has_its_limit_in_units_a_second():
    detector = RateOfChange(unit="V", most=2.0)
    detector.see(0, 1.0)
    assert detector.see(SECOND, 2.9) < 0.5
    assert detector.see(2 * SECOND, 5.0) > 0.5
    assert detector.why() == "it changes by 2.1 V/s; up to 2 V/s are allowed"


def test_limits_are_those_of_a_person_and_learn_nothing():
    detector = LimitsDetector(unit="V", minimum=11.0, maximum=15.0)
    assert [detector.see(0, value) for value in (10.9, 11.0, 15.0, 15.1)] == [1.0, 0.0, 0.0, 1.0]
    assert detector.why() == "15.1 V is above the most of 15 V"
    assert not detector.forgive()


def test_quartiles_are_those_of_the_window():
    detector = Quartiles(k=1.5)
    feed(detector, [float(at % 5) for at in range(100)])
    # Quartiles 1 and 3: the fences stand at -2 and 6.
    assert detector.see(10**9, 5.9) < 0.5
    assert detector.see(10**9, 6.5) > 0.5


def test_a_change_of_level_is_told_in_words():
    detector = ChangePointDetector(unit="V")
    feed(detector, noise(1500))
    feed(detector, [15.0], 1500 * STEP)
    assert detector.why().startswith("15 V is ")
    assert "V above the 1" in detector.why()


def test_rarity_is_0_for_the_commonest_and_1_for_what_never_was():
    rarity = Rarity()
    for at in range(500):
        rarity.rate_magnitude(1.0 + at % 10)
    assert rarity.rate_magnitude(100.0) == pytest.approx(1.0)
    assert rarity.rate_magnitude(1.0) < 0.05
    rarity.learn_magnitude(100.0, 500.0)
    assert rarity.rate_magnitude(100.0) < 0.3


def test_the_newest_values_stay_sorted():
    chance = random.Random(5)  # noqa: S311 - noise
    recent, all_of_them = Sorted(most=50), []
    for _ in range(300):
        all_of_them.append(chance.choice([1.0, 2.0, chance.random()]))
        recent.add_value(all_of_them[-1])
        assert recent.sorted == sorted(all_of_them[-50:])
        assert recent.newest_values(50) == all_of_them[-50:]


def test_one_anomaly_is_told_once():
    episodes = Episodes(bar=0.5, rest=20, calm=3)
    told = [(at, episodes.update_score(at, 0.9 if at in (5, 6, 8) else 0.1)) for at in range(11)]
    assert [each for each in told if each[1]] == [(5, EpisodeTurn.BEGAN)]
    assert episodes.update_score(11, 0.1) is EpisodeTurn.ENDED
    assert episodes.end_episode() == (5, 8, 0.9)
    assert episodes.update_score(12, 0.9) is None, "it rests"
    assert [episodes.update_score(at, 0.9) for at in range(13, 26)].count(EpisodeTurn.BEGAN) == 1


def test_together_hears_its_parts():
    detector = Together(unit="V")
    feed(detector, noise(600))
    assert detector.change.unit == "V"
    assert detector.see(601 * STEP, 20.0) >= KINDS["together"].bar


def test_numbers_and_spans_are_written_as_people_read_them():
    assert [format_number(each) for each in (12.70001, 0.0, 1234567.0, 0.00123456)] == [
        "12.7", "0", "1234567", "0.001235",
    ]  # fmt: skip
    assert [format_duration(each) for each in (0.02, 40.0, 300.0, 7200.0, 300000.0)] == [
        "20 ms", "40 s", "5 min", "2 h", "3 days",
    ]  # fmt: skip


def drifting(count: int, seed: int) -> list[float]:
    """Make a battery that empties slowly, with a reading that trembles."""
    return [value - 1.5 * at / 14_400 for at, value in enumerate(noise(count, 12.6, seed))]


def begun(watched: DetectorRunner, values: list[float], first: int = 0) -> list[int]:
    """Tell at which samples an anomaly began, one sample a second."""
    turns = [
        watched.score_sample((first + at) * SECOND + 1, value) for at, value in enumerate(values)
    ]
    return [first + at for at, turn in enumerate(turns) if isinstance(turn, AnomalyBegan)]


@pytest.mark.parametrize("name", ["together", "change"])
def test_a_signal_that_drifts_slowly_is_left_alone_while_it_is_learned(name):
    for seed in range(4):
        watched = DetectorRunner("power/voltage", "V", Watch(detector=name))
        assert begun(watched, drifting(700, seed)) == []
        assert watched.learning == 300


def test_what_is_clear_is_told_before_all_is_learned():
    watched = DetectorRunner("power/voltage", "V", Watch(detector="together"))
    assert begun(watched, drifting(500, 1)) == []
    (when,) = begun(watched, [9.0] * 5, 500)
    assert when < 503
    assert " V" in watched.why


def test_nothing_begins_while_all_is_quiet_and_only_the_clear_while_it_learns():
    episodes = Episodes(bar=0.5, quiet=3, learning=6)
    # Quiet for three samples, then 0.58 is the bar for three more.
    turns = [
        episodes.update_score(at, score) for at, score in enumerate([0.9, 0.9, 0.9, 0.57, 0.57])
    ]
    assert turns == [None] * 5
    assert Episodes(bar=0.5, learning=6).update_score(0, 0.59) is EpisodeTurn.BEGAN
    assert episodes.update_score(5, 0.57) is None
    assert episodes.learning == 0
    assert episodes.update_score(6, 0.5) is EpisodeTurn.BEGAN


def test_what_is_left_to_learn_is_kept_over_a_restart():
    watch = Watch(detector="together")
    watched = DetectorRunner("power/voltage", "V", watch)
    begun(watched, drifting(400, 1))
    again = DetectorRunner("power/voltage", "V", watch, watched.dump_state())
    assert (again.learning, again.episodes.quiet) == (600, 0)
    # Of another watch nothing is known.
    other = DetectorRunner(
        "power/voltage", "V", Watch(detector="together", rest=7), watched.dump_state()
    )
    assert (other.learning, other.episodes.quiet) == (1_000, 250)
