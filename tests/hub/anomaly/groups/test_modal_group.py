"""A machine that runs in several ways is judged by what is usual in each of them."""

from __future__ import annotations

import random

import numpy as np
import pytest

from talaia.hub.anomaly.base import dump_detector, load_detector
from talaia.hub.anomaly.groups.modal_group import ModalGroup
from talaia.hub.anomaly.groups.mode_search import find_modes

pytestmark = pytest.mark.pure

SECOND = 1_000_000
DOCKED, DRIVING = 0, 1
# The machine drives for so many steps, docks for so many, and so on.
VISIT = 60


def robot_rows(count: int, seed: int = 1) -> list[tuple[int, list[float]]]:
    """Make steps of a robot: its state; voltage, current and speed, all of which depend on it."""
    chance = random.Random(seed)  # noqa: S311 - noise
    rows = []
    for at in range(count):
        state = (at // VISIT) % 2
        drawn = (6.0 if state == DRIVING else 0.3) + chance.gauss(0.0, 0.1)
        speed = 0.8 * state + chance.gauss(0.0, 0.02 if state == DRIVING else 0.001)
        rows.append((state, [25.0 - 0.1 * drawn + chance.gauss(0.0, 0.02), drawn, speed]))
    return rows


def new_group(**change) -> ModalGroup:
    asked = {"signals": ["voltage", "current", "speed"], "learn_rows": 400} | change
    return ModalGroup(**asked)


def feed(group: ModalGroup, rows, first: int = 0) -> list[bool]:
    said = []
    for at, (state, row) in enumerate(rows):
        group.see_row((first + at) * SECOND, row, state)
        said.append(group.anomalous)
    return said


def dragging(rows):
    """Let the wheels drag: it draws more while it drives, though less than nothing it ever drew."""
    return [(s, [v - 0.1 * s, c + 1.0 * s, w]) for s, (v, c, w) in rows]


@pytest.mark.parametrize("asked", [{"by_state": True}, {"most_modes": 4}], ids=["told", "found"])
def test_going_from_one_way_of_running_to_another_is_usual_and_a_fault_in_one_is_not(asked):
    group = new_group(**asked)
    rows = robot_rows(2400)
    assert not any(feed(group, rows[:1200]))
    assert group.learning == 0
    assert not any(feed(group, rows[1200:1800], 1200))
    assert any(feed(group, dragging(rows[1800:1920]), 1800))
    assert len(group.members) == 2


def test_a_state_that_comes_late_blunts_nothing():
    """The robot drives for three steps before its state says so, and stands as long before."""
    group = new_group(by_state=True)
    rows = robot_rows(1920)
    late = [(rows[max(0, at - 3)][0], row) for at, (_, row) in enumerate(rows)]
    assert not any(feed(group, late[:1800]))
    worse = [(state, row) for (state, _), (_, row) in zip(late, dragging(rows), strict=True)]
    assert any(feed(group, worse[1800:], 1800))


def test_what_leads_is_named_in_the_way_of_running_that_it_is_in():
    group = new_group(by_state=True)
    rows = robot_rows(2000)
    feed(group, rows[:1900])
    feed(group, dragging(rows[1900:1920]), 1900)
    assert group.list_shares()[0].name in {"current", "voltage"}
    assert group.list_shares()[0].place in {0, 1}


def test_one_notion_of_usual_calls_what_is_small_beside_its_changes_nothing():
    """What the others are for: the same fault, and one notion for all ways of running."""
    group = new_group()
    rows = robot_rows(1920)
    feed(group, rows[:1800])
    assert not any(feed(group, dragging(rows[1800:]), 1800))


def test_a_state_that_was_never_met_is_learned_and_not_called_anomalous():
    group = new_group(by_state=True)
    feed(group, robot_rows(1200))
    charging = [(2, [29.0, -8.0, 0.0])] * 300
    assert not any(feed(group, charging, 1200))
    assert group.learning > 0
    # The others are as they were.
    assert not any(feed(group, robot_rows(120, seed=2), 1500))
    assert group.learning == 0


@pytest.mark.parametrize("asked", [{"by_state": True}, {"most_modes": 4}, {}])
@pytest.mark.parametrize("stopped_at", [100, 405, 900])
def test_a_restart_changes_nothing(asked, stopped_at):
    rows = dragging(robot_rows(1000))
    whole, first = new_group(**asked), new_group(**asked)
    expected = feed(whole, rows)
    feed(first, rows[:stopped_at])
    second = load_detector(ModalGroup, dump_detector(first))
    assert feed(second, rows[stopped_at:], stopped_at) == expected[stopped_at:]
    assert second.score == pytest.approx(whole.score)
    assert second.why() == whole.why()


@pytest.mark.parametrize("asked", [{"by_state": True}, {"most_modes": 4}])
def test_rows_that_are_all_there_are_learned_at_once(asked):
    rows = robot_rows(1200)
    group = new_group(learn_rows=len(rows), **asked)
    group.expect_states([state for state, _ in rows] if "by_state" in asked else [])
    feed(group, rows)
    while group.pass_rows_on():
        pass
    assert [member.learning for member in group.members.values()] == [0, 0]


def test_what_runs_in_one_way_has_one_and_a_drift_is_not_two():
    chance = np.random.default_rng(1)
    steady = chance.normal(size=(500, 3))
    assert len(find_modes(steady, 4, 60)) == 1
    drift = np.linspace(0.0, 30.0, 500)[:, np.newaxis] + steady
    assert len(find_modes(drift, 4, 60)) == 1
    two = steady + 20.0 * (np.arange(500) % 100 < 40)[:, np.newaxis]
    assert len(find_modes(two, 4, 60)) == 2
    # Too seldom to be learned from.
    assert len(find_modes(steady + 20.0 * (np.arange(500) < 30)[:, np.newaxis], 4, 60)) == 1


def test_bounds_are_told():
    with pytest.raises(ValueError, match="expected 1 to 16 modes, found 17"):
        new_group(most_modes=17)


def observatory_rows(count: int, *, warmer: float = 0.0) -> list[tuple[int, list[float]]]:
    """Make steps of a mirror's temperature and of what guiding is off, by day and at night.

    By day guiding hardly moves; at night it does, and it is colder.
    """
    chance = random.Random(3)  # noqa: S311 - noise
    rows = []
    for at in range(count):
        night = (at // 400) % 2
        slow = 1.5 * np.sin(at / 90)
        guiding = 0.45 + chance.gauss(0.0, 0.08) if night else 0.02 + chance.gauss(0.0, 0.002)
        rows.append((night, [15.0 + warmer - 8.0 * night + slow + chance.gauss(0, 0.05), guiding]))
    return rows


def test_a_night_as_warm_as_a_day_is_a_night():
    """In which way it runs, is told by what is steady in one of them, however near the rest is."""
    group = new_group(signals=["mirror", "guiding"], learn_rows=1_600, most_modes=4)
    feed(group, observatory_rows(3_200))
    assert len(group.members) == 2
    rows = observatory_rows(3_900)
    feed(group, rows[3_200:3_700], 3_200)
    at_night = group.mode
    for at, (_, (mirror, guiding)) in enumerate(rows[3_700:]):
        # As guiding is by day it never is, but the mirror gets as warm as it is by day.
        group.see_row((3_700 + at) * SECOND, [mirror + 0.05 * at, guiding - 0.0002 * at])
        assert group.mode == at_night


def test_a_group_of_an_older_version_goes_on_by_the_middles_alone():
    group = new_group(signals=["mirror", "guiding"], learn_rows=1_600, most_modes=4)
    rows = observatory_rows(3_600)
    feed(group, rows[:3_200])
    group.widths = np.empty(0)
    older = load_detector(ModalGroup, dump_detector(group))
    assert not any(feed(older, rows[3_200:], 3_200))
    assert older.mode in older.members


@pytest.mark.parametrize("asked", [{"by_state": True}, {"most_modes": 4}, {}])
@pytest.mark.parametrize("gaps", [False, True])
def test_many_rows_at_once_are_judged_as_one_by_one(asked, gaps):
    rows = dragging(robot_rows(1_500))
    if gaps:
        rows = [(s, [np.nan if at % 7 == 0 else v, *r]) for at, (s, (v, *r)) in enumerate(rows)]
    one, many = new_group(**asked), new_group(**asked)
    expected = []
    for at, (state, row) in enumerate(rows):
        one.see_row(at * SECOND, row, state)
        current = one.current
        judged = current is not None and one.score > 0.0
        expected.append((one.score, current.distance if current is not None and judged else 0.0))
    times, values = np.arange(len(rows)) * SECOND, np.array([row for _, row in rows])
    states = [state for state, _ in rows]
    found = []
    for first in range(0, len(rows), 130):
        part = slice(first, first + 130)
        found += zip(*many.see_rows(times[part], values[part], states[part]), strict=True)
    assert found == expected
    assert any(distance > 0.0 for _, distance in found)
    assert dump_detector(many) == dump_detector(one)
