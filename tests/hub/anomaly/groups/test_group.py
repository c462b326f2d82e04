"""Several signals are judged together: what is unusual, which of them, whatever comes."""

import math
import random

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.hub.anomaly.base import dump_detector, load_detector
from talaia.hub.anomaly.groups.group import MOST_SIGNALS, GroupDetector
from talaia.hub.anomaly.groups.modal_group import ModalGroup

pytestmark = pytest.mark.pure

SECOND = 1_000_000
LEARNED = 200


def plant_rows(count: int, seed: int = 1) -> list[list[float]]:
    """Make rows of a pump: current and flow follow the load together, the heat by itself."""
    chance = random.Random(seed)  # noqa: S311 - noise
    rows, load = [], 0.0
    for _ in range(count):
        load = 0.8 * load + chance.gauss(0.0, 1.0)
        flow, current = 30 + 2 * load, 5 + 0.3 * load
        rows.append(
            [
                flow + chance.gauss(0.0, 0.2),
                current + chance.gauss(0.0, 0.03),
                60 + chance.gauss(0.0, 1.0),
            ]
        )
    return rows


def new_group(learned: int = LEARNED) -> GroupDetector:
    return GroupDetector(signals=["flow", "current", "heat"], learn_rows=learned)


def feed(group: GroupDetector, rows: list[list[float]], first: int = 0) -> list[float]:
    return [group.see_row((first + at) * SECOND, row) for at, row in enumerate(rows)]


def learned_group() -> GroupDetector:
    group = new_group()
    feed(group, plant_rows(LEARNED))
    return group


def test_nothing_is_told_while_it_learns_and_hardly_anything_of_what_it_knows():
    group = new_group()
    assert feed(group, plant_rows(LEARNED)) == [0.0] * LEARNED
    assert group.learning == 0
    assert max(feed(group, plant_rows(400, seed=2), LEARNED)) < 0.5


def test_a_signal_that_departs_is_anomalous_and_is_named_with_its_share():
    group = learned_group()
    hot = [[flow, current, heat + 8] for flow, current, heat in plant_rows(60, seed=3)]
    assert feed(group, hot, LEARNED)[-1] > 0.5
    first = group.list_shares()[0]
    assert first.name == "heat"
    assert first.share > 0.8
    assert first.spreads > 3
    assert sum(signal.share for signal in group.list_shares()) == pytest.approx(1.0)
    assert "heat (" in group.why()
    assert "above its level" in group.why()


def test_signals_that_go_apart_are_anomalous_though_each_is_where_it_often_is():
    def rows(sign: float) -> list[list[float]]:
        return [
            [flow + 3, current + sign * 0.45, heat]
            for flow, current, heat in plant_rows(60, seed=4)
        ]

    together, apart = learned_group(), learned_group()
    assert max(feed(together, rows(1.0), LEARNED)) < 0.5
    assert feed(apart, rows(-1.0), LEARNED)[-1] > 0.5
    assert {signal.name for signal in apart.list_shares()[:2]} == {"flow", "current"}


def test_a_slow_drift_is_followed():
    group = new_group(600)
    rows = plant_rows(3600, seed=5)
    drifting = [[a, b, heat + max(0, at - 600) * 0.001] for at, (a, b, heat) in enumerate(rows)]
    assert max(feed(group, drifting)) < 0.5


def test_what_follows_a_great_anomaly_is_no_second_one_until_it_has_faded():
    group = learned_group()
    rows = plant_rows(3000, seed=6)
    # Far away for a while, and then back to near where it was.
    hit = [[a + 200.0, b, c] for a, b, c in rows[:100]]
    after = [[a, b, c + 2.5] for a, b, c in rows[100:500]]
    later = [[a, b, c + 9] for a, b, c in rows[500:600]]
    feed(group, hit, LEARNED)
    assert group.anomalous
    assert feed(group, after, LEARNED + 100)[-1] < 0.5
    feed(group, rows[600:2600], LEARNED + 500)
    assert feed(group, later, LEARNED + 2500)[40] > 0.5


def test_what_was_forgiven_is_usual_and_other_things_are_not():
    group = learned_group()
    rows = plant_rows(3000, seed=7)
    hot = [[a, b, heat + 8] for a, b, heat in rows[:60]]
    assert feed(group, hot, LEARNED)[-1] > 0.5
    assert group.forgive()
    feed(group, rows[60:1060], LEARNED + 60)
    assert max(feed(group, hot, LEARNED + 1060)) < 0.5
    feed(group, rows[1060:2060], LEARNED + 1120)
    blocked = [[flow - 25, b, c] for flow, b, c in rows[:60]]
    assert feed(group, blocked, LEARNED + 2120)[-1] > 0.5
    assert not new_group().forgive()


def test_a_row_is_judged_by_itself_and_those_before_it():
    rows = plant_rows(400, seed=8)
    changed = rows[:300] + [[0.0, 0.0, 0.0]] * 100
    assert feed(new_group(), rows)[:300] == feed(new_group(), changed)[:300]


@pytest.mark.parametrize("stopped_at", [50, LEARNED, 230])
def test_a_restart_changes_nothing(stopped_at):
    rows = plant_rows(300, seed=9)
    rows[240:] = [[a, b, c + 9] for a, b, c in rows[240:]]
    whole = new_group()
    expected = feed(whole, rows)
    first = new_group()
    feed(first, rows[:stopped_at])
    second = load_detector(GroupDetector, dump_detector(first))
    assert feed(second, rows[stopped_at:], stopped_at) == pytest.approx(expected[stopped_at:])
    assert second.why() == whole.why()


def test_samples_of_different_rates_come_to_the_same_as_their_rows():
    """The heat comes every fifth second, the flow four times a second."""
    by_rows = new_group()
    by_samples = ModalGroup(signals=by_rows.signals, learn_rows=LEARNED)
    rows = plant_rows(300, seed=10)
    for at, (flow, current, heat) in enumerate(rows):
        came = heat if at % 5 == 0 else math.nan
        by_rows.see_row(at * SECOND, [flow, current, came])
        for part in (3, 2, 1, 0):
            by_samples.see(at * SECOND + 200_000 * (3 - part), 0, flow + part)
        by_samples.see(at * SECOND + 700_000, 1, current)
        if at % 5 == 0:
            by_samples.see(at * SECOND + 900_000, 2, heat)
    # The last step is judged once the next one has begun.
    by_samples.see(300 * SECOND, 0, 30.0)
    assert by_samples.score == by_rows.score > 0.0
    # What comes for a step that is over is passed over, and is nothing of the step that is on.
    assert not by_samples.see(299 * SECOND, 0, 1e9)
    assert by_samples.see(301 * SECOND, 0, 30.0)
    assert by_samples.score < 0.5


def test_a_signal_that_stops_coming_is_held_for_a_bounded_time_and_then_left_out():
    group = learned_group()
    rows = plant_rows(40, seed=11)
    gone = [[flow, current, math.nan] for flow, current, _ in rows]
    feed(group, gone[:8], LEARNED)
    assert group.known[2] == 1.0
    feed(group, gone[8:], LEARNED + 8)
    assert group.known[2] == 0.0
    assert {signal.name: signal.share for signal in group.list_shares()}["heat"] == 0.0
    feed(group, rows[:1], LEARNED + 40)
    assert group.known[2] == 1.0


def test_after_a_long_silence_what_was_before_and_one_wild_row_are_no_anomaly():
    group = learned_group()
    assert feed(group, [[a, b, c + 9] for a, b, c in plant_rows(60, seed=3)], LEARNED)[-1] > 0.5
    row = [*plant_rows(1, seed=12)[0][:2], 64.0]
    assert group.see_row((LEARNED + 5000) * SECOND, row) < 0.5


def test_constant_signals_harm_nothing_and_a_flag_that_never_moved_is_seen_to_move():
    group = GroupDetector(signals=["flag", "level"], learn_rows=100)
    feed(group, [[0.0, 24.0]] * 300)
    assert group.score < 0.5
    # A hair's breadth is rounding.
    assert feed(group, [[0.0, 24.000_01]] * 100, 300)[-1] < 0.5
    assert feed(group, [[1.0, 24.0]] * 10, 400)[-1] > 0.5
    assert group.list_shares()[0].name == "flag"


HOSTILE = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True, width=64),
    st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 1.0, 1e300, -1e300, 5e-324]),
)


@settings(max_examples=examples(25, many=2_000))
@given(
    rows=st.lists(st.lists(HOSTILE, min_size=3, max_size=3), min_size=1, max_size=12),
    gaps=st.lists(st.integers(1, 10**12), min_size=1, max_size=5),
    constant=st.booleans(),
)
def test_scores_are_numbers_from_0_to_1_and_the_state_stays_small_whatever_comes(
    rows, gaps, constant
):
    group = new_group(60)
    usual = [[1.0, 2.0, 3.0]] if constant else plant_rows(70, seed=13)
    now = -5 * SECOND
    for at in range(100):
        # Half of the learning stretch is hostile as well.
        row = rows[at % len(rows)] if at % 2 else usual[at % len(usual)]
        score = group.see_row(now, row)
        assert 0.0 <= score <= 1.0
        now += gaps[at % len(gaps)]
    group.forgive()
    assert np.isfinite(group.whitening).all()
    assert 0.0 <= group.see_row(now, usual[0]) <= 1.0
    assert all(0.0 <= signal.share <= 1.0 for signal in group.list_shares())
    assert isinstance(group.why(), str)
    assert len(dump_detector(group)) < 2000


def test_groups_have_bounds_that_are_told():
    with pytest.raises(ValueError, match=f"1 to {MOST_SIGNALS} signals in a group, found 0"):
        GroupDetector(signals=[])
    with pytest.raises(ValueError, match="60 to 30000 rows to learn from, found 5"):
        GroupDetector(signals=["a"], learn_rows=5)


def test_who_learned_for_longer_knows_better_how_signals_go_together():
    peaks = []
    for learned in (400, 4_000):
        group, rows = new_group(learned), plant_rows(learned + 100, seed=5)
        for at, (flow, current, heat) in enumerate(rows):
            # A sensor that is off by twice what it usually moves, at once and for good.
            off = 1.0 if at >= learned else 0.0
            group.see_row(at * SECOND, [flow, current + off, heat])
        peaks.append(group.peak)
    assert peaks[1] > 2 * peaks[0]
