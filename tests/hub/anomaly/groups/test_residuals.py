"""Each signal of a group is judged by what the others make of it, with a threshold of its own."""

from __future__ import annotations

import copy
import random

import msgspec
import numpy as np
import pytest

from talaia.hub.anomaly.base import dump_detector, load_detector
from talaia.hub.anomaly.budget.score_tail import ScoreTail
from talaia.hub.anomaly.budget.thresholds import site_thresholds
from talaia.hub.anomaly.episode_runner import AnomalyBegan
from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.hub.anomaly.groups.level_scatter import LevelScatter
from talaia.hub.anomaly.groups.residuals import SignalResiduals
from talaia.model.alarms.anomaly import SignalGroup
from talaia.model.alarms.signal_groups import GroupSignals

pytestmark = pytest.mark.pure

# So long that a day has fewer than the fewest rows that are learned from.
STEP_US = 100_000_000
LEARNED = 1_088
NAMES = ("left", "right", "heat")
# Of each signal: residuals at three paces, scatter, stillness; after these of all: its steps.
BY_SIGNAL, KINDS = 5, 6
SCATTER, STILL, STEPS = 3, 4, 5


def wheel_rows(count: int, seed: int = 1) -> np.ndarray:
    """Make rows: two wheels that turn alike, a heat by itself, and a current beside the group."""
    chance = random.Random(seed)  # noqa: S311 - noise
    rows, speed = [], 0.0
    for at in range(count):
        if at % 20 == 0:
            speed = chance.choice([0.3, 0.6, 0.9, 1.2])
        rows.append(
            [
                speed + chance.gauss(0.0, 0.01),
                speed + chance.gauss(0.0, 0.01),
                40.0 + chance.gauss(0.0, 0.5),
                5.0 * speed + chance.gauss(0.0, 0.1),
            ]
        )
    return np.array(rows)


def feed(residuals: SignalResiduals, rows: np.ndarray, first: int = 0) -> np.ndarray:
    """Show rows; give the magnitudes after each (rows, signals, kinds)."""
    flat = feed_flat(residuals, rows, first)
    most = BY_SIGNAL * residuals.own
    by_signal = flat[:, :most].reshape(len(rows), -1, BY_SIGNAL)
    return np.concatenate((by_signal, flat[:, most:, np.newaxis]), axis=2)


def feed_flat(residuals: SignalResiduals, rows: np.ndarray, first: int = 0) -> np.ndarray:
    found = []
    for at, row in enumerate(rows.tolist()):
        residuals.see_row((first + at) * STEP_US, row)
        found.append(residuals.magnitudes())
    return np.array(found)


def learned_residuals() -> SignalResiduals:
    residuals = SignalResiduals(own=3, beside=1, step_us=STEP_US)
    feed(residuals, wheel_rows(LEARNED))
    return residuals


def test_nothing_is_judged_before_it_has_learned():
    residuals = SignalResiduals(own=3, beside=1, step_us=STEP_US)
    found = feed(residuals, wheel_rows(900))
    assert found[:, :, : SCATTER + 1].max() == 0.0
    assert not residuals.trusted


def test_a_wheel_that_turns_otherwise_than_the_other_is_far_from_what_is_expected_of_it():
    residuals = learned_residuals()
    usual = feed(residuals, wheel_rows(400, seed=2), LEARNED).max(axis=0)
    rows = wheel_rows(400, seed=3)
    # Much less than both change together at any time.
    rows[:, 0] -= 0.12
    found = feed(residuals, rows[:40], LEARNED + 400).max(axis=0)
    assert found[0, :SCATTER].max() > 10 * usual[0, :SCATTER].max()
    assert found[2, :SCATTER].max() < 3 * usual[2, :SCATTER].max()


def test_a_signal_beside_the_group_explains_and_is_not_judged():
    both = learned_residuals()
    rows = wheel_rows(60, seed=4)
    # Both wheels turn alike, and the current is another one.
    rows[:, :2] *= 0.3
    usual = feed(both, wheel_rows(400, seed=2), LEARNED).max(axis=0)
    found = feed(both, rows, LEARNED + 400).max(axis=0)
    assert found.shape == (3, KINDS)
    assert found[:2].max() > 3 * usual[:2].max()


def test_a_signal_that_scatters_more_shows_it_though_no_value_of_it_is_far_away():
    residuals = learned_residuals()
    usual = feed(residuals, wheel_rows(400, seed=2), LEARNED)
    rows = wheel_rows(100, seed=5)
    chance = random.Random(6)  # noqa: S311 - noise
    rows[:, 2] = [40.0 + chance.choice([-1.4, 1.4]) for _ in rows]
    found = feed(residuals, rows, LEARNED + 400)
    assert found[:, 2, SCATTER].max() > 5 * usual[:, 2, SCATTER].max()


def motor_rows(count: int, seed: int) -> np.ndarray:
    """Make rows of a motor that is quiet while it stands, and noisy while it turns."""
    chance = random.Random(seed)  # noqa: S311 - noise
    turns = [at // 10 % 3 == 2 for at in range(count)]
    return np.array([[chance.gauss(4.2, 0.3) if on else chance.gauss(0.2, 0.02)] for on in turns])


def test_a_motor_that_is_noisy_only_while_it_stands_shows_it_beside_its_steps_there():
    residuals = SignalResiduals(own=1, step_us=STEP_US)
    feed(residuals, motor_rows(2 * LEARNED, seed=1))
    usual = feed(residuals, motor_rows(600, seed=2), 2 * LEARNED)[:, 0].max(axis=0)
    rows = motor_rows(18, seed=3)
    # A third of what it changes from one step to the next while it turns.
    rows[:, 0] += np.random.default_rng(4).normal(0.0, 0.1, 18)
    found = feed(residuals, rows, 2 * LEARNED + 600)[:, 0].max(axis=0)
    assert found[STEPS] > 10 * usual[STEPS]
    assert found[: SCATTER + 1].max() < 2 * usual[: SCATTER + 1].max()
    needs = np.full(KINDS, 1e9)
    needs[STEPS] = 1e-9
    (strange,) = residuals.list_strange(needs, ["motor"])
    assert "times as much from step to step as is usual there" in strange.why


def test_a_signal_that_comes_seldom_steps_from_its_newest_sample():
    thinned = motor_rows(3 * LEARNED, seed=5)
    thinned[1::2] = np.nan
    levels = LevelScatter(count=1)
    found = levels.see_rows(thinned)
    assert found[-100:].max() > 0.0
    again = LevelScatter(count=1)
    assert np.array_equal(
        found[:50], np.vstack([again.see_rows(row[None]) for row in thinned[:50]])
    )


def test_a_signal_that_stands_still_is_counted_in_samples_and_silence_is_none():
    residuals = learned_residuals()
    rows = wheel_rows(40, seed=7)
    rows[:, 2] = rows[0, 2]
    found = feed(residuals, rows, LEARNED)
    assert found[-1, 2, STILL] == 39
    assert found[8, 2, STILL] == 0.0
    silent = wheel_rows(40, seed=8)
    silent[:, 1] = np.nan
    assert feed(residuals, silent, LEARNED + 40)[:, 1, STILL].max() == 0.0


def test_a_signal_that_comes_back_after_a_silence_begins_anew():
    residuals = learned_residuals()
    rows = wheel_rows(900, seed=9)
    rows[:, 2] += 30.0
    rows[:800, 2] = np.nan
    found = feed(residuals, rows, LEARNED)
    usual = feed(learned_residuals(), wheel_rows(900, seed=9), LEARNED)
    assert found[:, 2, :SCATTER].max() < 3 * usual[:, 2, :SCATTER].max()
    assert found[:, 0, :SCATTER].max() < 3 * usual[:, 0, :SCATTER].max()


def test_what_it_has_learned_is_kept_without_what_can_be_reckoned():
    one = learned_residuals()
    feed(one, wheel_rows(300, seed=2), LEARNED)
    kept = dump_detector(msgspec.structs.replace(one, weights=np.empty(0)))
    other = load_detector(SignalResiduals, kept)
    rows = wheel_rows(100, seed=3)
    mine, its = feed(one, rows, LEARNED + 300), feed(other, rows, LEARNED + 300)
    # The weights of one are some rows older; magnitudes are fourth powers of spreads.
    assert np.allclose(mine**0.25, its**0.25, atol=0.5)
    assert its[:, 0, :SCATTER].max() > 1.0


def test_samples_make_the_same_of_it_as_rows():
    rows = wheel_rows(LEARNED + 100)
    by_row, by_sample = (SignalResiduals(own=3, beside=1, step_us=STEP_US) for _ in range(2))
    feed(by_row, rows)
    for at, row in enumerate([*rows.tolist(), rows[-1].tolist()]):
        for place, value in enumerate(row):
            by_sample.see(at * STEP_US + place, place, value)
    assert np.array_equal(by_row.magnitudes(), by_sample.magnitudes())


def test_many_rows_at_once_are_judged_as_one_by_one():
    rows = wheel_rows(LEARNED + 500, seed=14)
    # One is away for a while, and one stands still.
    rows[LEARNED + 300 : LEARNED + 303, 1] = np.nan
    rows[LEARNED + 100 : LEARNED + 140, 2] = 41.0
    times = np.arange(len(rows)) * STEP_US
    one, many = (SignalResiduals(own=3, beside=1, step_us=STEP_US) for _ in range(2))
    wanted = feed_flat(one, rows)
    parts = [many.see_rows(times[at : at + 150], rows[at : at + 150]) for at in range(0, 1588, 150)]
    found = np.vstack(parts)
    assert np.allclose(found, wanted, rtol=1e-6, atol=1e-9)
    assert found[:, : SCATTER + 1].max() > 1.0
    assert found[LEARNED + 139, 2 * BY_SIGNAL + STILL] == 39
    assert found[:, 3 * BY_SIGNAL :].max() > 1.0
    assert np.allclose(one.levels.squares, many.levels.squares, rtol=1e-9)
    assert np.allclose(one.moments, many.moments, rtol=1e-9)
    assert np.allclose(one.peaks, many.peaks, rtol=1e-6)
    assert (one.heard, one.judged, one.waiting) == (many.heard, many.judged, many.waiting)
    assert np.array_equal(one.held.came, many.held.came)


def new_runner() -> GroupRunner:
    group = SignalGroup(device="base", learn=400, step=STEP_US / 1e6)
    members = tuple(f"base/{name}" for name in NAMES)
    asked = GroupSignals("base", group, members, NAMES, "base", beside=("battery/current",))
    return GroupRunner(asked)


@pytest.fixture(scope="module")
def kept_runner() -> GroupRunner:
    """Give a runner that has learned for some days, with thresholds for one false alarm a week."""
    runner = new_runner()
    runner.tail = ScoreTail()
    for at, row in enumerate(wheel_rows(4 * LEARNED, seed=11).tolist()):
        runner.score_row(at * STEP_US, row, -1)
    found = site_thresholds({("/base", "group"): runner.tail}, 1.0)
    runner.set_needs(found.of["/base", "group"])
    return runner


@pytest.fixture
def runner(kept_runner: GroupRunner) -> GroupRunner:
    """Give one of its own to each test."""
    return copy.deepcopy(kept_runner)


def slipping_rows(count: int) -> list[list[float]]:
    rows = wheel_rows(count, seed=12)
    rows[:, 0] += 0.1
    return rows.tolist()


def show(runner: GroupRunner, rows: list[list[float]]) -> list[AnomalyBegan]:
    turns = [runner.score_row((4 * LEARNED + at) * STEP_US, row, -1) for at, row in enumerate(rows)]
    return [turn for turn in turns if isinstance(turn, AnomalyBegan)]


def test_a_fault_that_only_shows_against_the_other_signals_is_told_with_a_budget(runner):
    (began,) = show(runner, slipping_rows(12))
    assert "left is" in began.why or "right is" in began.why
    assert {share.name for share in runner.shares[:2]} == {"left", "right"}
    assert sum(share.share for share in runner.shares) == pytest.approx(1.0)


def test_what_is_usual_is_not_told(runner):
    assert not show(runner, wheel_rows(400, seed=13).tolist())


def test_the_past_is_rated_as_what_is_live():
    live, past, tail = new_runner(), new_runner(), ScoreTail()
    live.tail = ScoreTail()
    rows = wheel_rows(LEARNED + 200, seed=11)
    times = np.arange(len(rows)) * STEP_US
    for time_us, row in zip(times.tolist(), rows.tolist(), strict=True):
        live.score_row(time_us, row, -1)
    for at in range(0, len(rows), 32):
        part = slice(at, at + 32)
        past.rate_past(times[part], rows[part], [-1] * len(rows[part]), tail=tail)
    assert tail.days == live.tail.days
    for mine, its in zip(tail.peaks, live.tail.peaks, strict=True):
        greatest = [peak.greatest for peak in its]
        assert [peak.greatest for peak in mine] == pytest.approx(greatest, rel=1e-6)
    assert max(peak.greatest for peak in tail.peaks[0]) > 0.0
    assert max(peak.greatest for peak in tail.peaks[1]) > 0.0


def test_without_a_budget_residuals_cost_nothing_and_say_nothing():
    runner = new_runner()
    for at, row in enumerate(wheel_rows(2 * LEARNED, seed=11).tolist()):
        runner.score_row(at * STEP_US, row, -1)
    assert runner.residuals.heard == 0


def test_what_a_person_calls_usual_is_told_no_more(runner):
    assert show(runner, slipping_rows(12))
    assert runner.dismiss_peak()
    runner.end_anomaly()
    show(runner, wheel_rows(400, seed=13).tolist())
    again = [
        runner.score_row((4 * LEARNED + 400 + at) * STEP_US, row, -1)
        for at, row in enumerate(slipping_rows(12))
    ]
    assert not any(isinstance(turn, AnomalyBegan) for turn in again)


def test_a_runner_goes_on_with_the_residuals_that_it_kept(runner):
    kept = runner.dump_state()
    again = GroupRunner(runner.group, kept)
    again.set_needs(runner.needs)
    assert show(again, slipping_rows(12))
    # Beside other signals it has learned nothing of them, and of its own what it knew.
    other = GroupRunner(runner.group._replace(beside=()), kept)
    assert other.residuals.heard == 0
    assert other.detector.heard == runner.detector.heard


def test_what_an_older_version_kept_is_gone_on_with(runner):
    asked, state, since, *_ = msgspec.msgpack.decode(runner.dump_state())
    again = GroupRunner(runner.group, msgspec.msgpack.encode((asked, state, since)))
    assert again.detector.heard == runner.detector.heard
    assert again.residuals.heard == 0


def test_residuals_that_an_older_version_kept_learn_of_levels_besides():
    residuals = learned_residuals()
    kept = msgspec.msgpack.decode(dump_detector(residuals))
    del kept["levels"]
    for name in ("rated", "peaks", "excused"):
        kept[name] = np.zeros(3 * BY_SIGNAL).tobytes()
    again = load_detector(SignalResiduals, msgspec.msgpack.encode(kept))
    assert again.heard == residuals.heard
    rows = wheel_rows(100, seed=3)
    mine, its = (feed(one, rows, LEARNED)[:, :, :BY_SIGNAL] for one in (residuals, again))
    assert np.allclose(mine, its)
    assert again.levels.seen == 100


def test_the_only_number_of_a_device_is_judged_against_the_others_and_by_no_distance():
    runner = single_runner()
    rows = mains_rows(4 * LEARNED, seed=1).tolist()
    for at, row in enumerate(rows):
        assert runner.score_row(at * STEP_US, row[:1], -1) is None
    assert runner.score == 0.0
    assert runner.reason() == ""
    runner = single_runner()
    runner.tail = ScoreTail()
    for at, row in enumerate(rows):
        runner.score_row(at * STEP_US, row, -1)
    found = site_thresholds({("/mains", "group"): runner.tail}, 1.0)
    runner.set_needs(found.of["/mains", "group"])
    assert not show(runner, mains_rows(200, seed=2).tolist())
    # As low as it often is, and not where the other one stands.
    sagged = mains_rows(12, seed=3)
    sagged[:, 0] -= 4.0
    turns = [
        runner.score_row((4 * LEARNED + 200 + at) * STEP_US, row, -1)
        for at, row in enumerate(sagged.tolist())
    ]
    (began,) = [turn for turn in turns if isinstance(turn, AnomalyBegan)]
    assert "mains is" in began.why
    assert runner.dismiss_peak()


def single_runner() -> GroupRunner:
    group = SignalGroup(device="mains", learn=400, step=STEP_US / 1e6)
    beside = ("other/mains",)
    asked = GroupSignals("mains", group, ("mains/v",), ("mains",), "mains", beside=beside)
    return GroupRunner(asked)


def mains_rows(count: int, seed: int) -> np.ndarray:
    """Make rows of a voltage, and of another one that swings with it."""
    chance = random.Random(seed)  # noqa: S311 - noise
    swings = [chance.gauss(230.0, 3.0) for _ in range(count)]
    return np.array([[swing + chance.gauss(0.0, 0.2), swing] for swing in swings])
