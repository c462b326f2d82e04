"""How much of the cores pictures take, whose turn it is, and how large they are made."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.cores.core_budget import (
    GOOD_HZ,
    LARGEST_DIVISOR,
    LEAST_ROOM,
    CoreBudget,
    PictureSize,
    Turns,
)

pytestmark = pytest.mark.pure

COSTS = st.integers(500, 200_000)


def played(
    cost_us: int, room: float, seconds: float, size: PictureSize, camera_hz: float = 30
) -> float:
    """Play a camera within a room of cores; give the pictures a second of the last fifth."""
    period_us, now_us, came = 1e6 / camera_hz, 0.0, 0
    made: list[float] = []
    while now_us < seconds * 1e6:
        cost = cost_us / size.divisor**2
        sent = int(now_us / period_us)
        if sent <= came:
            now_us = (came + 1) * period_us
            sent = came + 1
        lost, came = sent - came - 1, sent
        size.note_picture(int(now_us) + 1, int(cost), lost=lost, room=room)
        made.append(now_us)
        now_us += cost / room
    return sum(at > seconds * 8e5 for at in made) / (seconds * 0.2)


@given(st.lists(COSTS, min_size=1, max_size=200), st.floats(0.5, 8), st.data())
def test_all_pictures_together_take_no_more_than_the_room(
    costs: list[int], cores: float, data: st.DataObject
) -> None:
    budget = CoreBudget(cores)
    now_us = began_us = 1_000_000
    spent = 0
    for cost_us in costs:
        now_us += budget.rest_us(now_us)
        # What may be made up for at once, and what is lost by whole microseconds.
        assert spent <= (now_us - began_us + 50_000 + len(costs)) * budget.room
        budget.spend(now_us, cost_us)
        spent += cost_us
        now_us += data.draw(st.integers(0, 2 * cost_us))


@given(st.lists(st.tuples(st.integers(0, 100_000), st.integers(1, 1_000_000)), max_size=200))
def test_the_room_stays_between_its_ends_whatever_the_loop_does(
    looks: list[tuple[int, int]],
) -> None:
    budget, now_us = CoreBudget(2), 0
    for late_us, later_us in looks:
        now_us += later_us
        budget.note_lateness(late_us, now_us)
        assert LEAST_ROOM <= budget.room <= 1.0


def test_a_late_loop_gets_room_from_pictures_and_a_punctual_one_gives_it_back() -> None:
    budget, now_us = CoreBudget(2), 10_000_000
    for _ in range(100):
        now_us += 50_000
        budget.note_lateness(30_000, now_us)
    assert budget.room == LEAST_ROOM
    for _ in range(1000):
        now_us += 50_000
        budget.note_lateness(1_000, now_us)
    assert budget.room == 1.0


@given(st.lists(COSTS, min_size=2, max_size=8), st.integers(50, 300))
def test_cameras_that_always_wait_have_had_the_same_but_for_a_picture_each(
    costs: list[int], turns: int
) -> None:
    row, had = Turns(), {f"cam/{at}": 0 for at in range(len(costs))}
    cost_of = dict(zip(had, costs, strict=True))
    for _ in range(turns):
        stream = row.choose(had)
        row.spend(stream, cost_of[stream])
        had[stream] += cost_of[stream]
    assert max(had.values()) - min(had.values()) <= max(costs)


def test_a_camera_that_was_away_has_saved_nothing_up() -> None:
    row = Turns()
    for _ in range(100):
        row.spend(row.choose(["cam/a"]), 1_000)
    chosen = []
    for _ in range(10):
        stream = row.choose(["cam/a", "cam/b"])
        row.spend(stream, 1_000)
        chosen.append(stream)
    assert chosen.count("cam/a") == 5


@given(st.integers(500, 30_000), st.floats(0.4, 1))
def test_what_the_cores_bear_at_a_good_rate_keeps_its_size(cost_us: int, room: float) -> None:
    size = PictureSize()
    if room * 1e6 / cost_us >= GOOD_HZ * 1.2:
        played(cost_us, room, 30, size)
        assert size.divisor == 1


@given(st.integers(120_000, 400_000), st.floats(0.3, 1))
def test_a_camera_that_is_too_dear_becomes_smaller_until_it_comes_often_enough(
    cost_us: int, room: float
) -> None:
    size = PictureSize()
    rate_hz = played(cost_us, room, 60, size)
    assert size.divisor == LARGEST_DIVISOR or rate_hz >= GOOD_HZ * 0.8


def test_it_becomes_larger_again_when_there_is_room() -> None:
    size = PictureSize()
    played(90_000, 0.3, 20, size)
    assert size.divisor > 1
    small = size.divisor
    now_us = 40_000_000
    for turn in range(30 * 30):
        size.note_picture(now_us + turn * 33_333, 90_000 // size.divisor**2, lost=0, room=2.0)
    assert size.divisor < small


def test_where_reading_is_dear_it_is_not_made_smaller_in_vain() -> None:
    size, now_us = PictureSize(), 0
    for _ in range(60):
        now_us += 200_000
        size.note_picture(now_us, 200_000, lost=5, room=1.0)
    assert size.divisor == 1
