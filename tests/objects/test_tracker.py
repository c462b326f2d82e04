"""Which boxes of one picture after the other are the same thing."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.objects.detection import Detection
from talaia.objects.tracker import FORGOTTEN_US, Tracker, TrackerRule, colours_of

pytestmark = pytest.mark.pure
STEP = 100_000


def person(x: float, *, score: float = 0.8, bottom: float = 0.8, high: float = 0.4) -> Detection:
    return Detection("person", score, x - 0.05, bottom - high, x + 0.05, bottom)


class Watched:
    """A tracker that is shown ten pictures a second."""

    def __init__(self) -> None:
        """Have seen nothing yet."""
        self.tracker, self.at = Tracker(), 0

    def show(self, *things: Detection, colours: list | None = None) -> list[int]:
        self.at += 1
        return [
            one.track for one in self.tracker.add_picture(list(things), self.at * STEP, colours)
        ]

    def walk(self, start: float, to: float, pictures: int) -> list[int]:
        return [self.show(person(x))[0] for x in np.linspace(start, to, pictures)]


def test_one_who_walks_past_is_one() -> None:
    assert set(Watched().walk(0.1, 0.9, 60)) == {1}


def test_two_who_cross_keep_their_numbers() -> None:
    watched = Watched()
    for x in np.linspace(0.1, 0.9, 60):
        numbers = watched.show(person(x), person(1 - x, bottom=0.7, high=0.3))
    assert numbers == [1, 2]


def test_two_one_behind_the_other_are_two() -> None:
    watched = Watched()
    told = [watched.show(person(x), person(x - 0.08)) for x in np.linspace(0.2, 0.9, 50)]
    assert set(map(tuple, told)) == {(1, 2)}


def test_one_who_hides_for_four_seconds_is_the_same_once_seen_three_times_again() -> None:
    watched = Watched()
    watched.walk(0.1, 0.4, 30)
    for _ in range(40):
        watched.show()
    assert watched.walk(0.5, 0.6, 10)[2:] == [1] * 8


def test_one_who_comes_after_it_was_forgotten_or_from_elsewhere_is_another() -> None:
    watched = Watched()
    watched.walk(0.4, 0.5, 20)
    for _ in range(FORGOTTEN_US // STEP + 1):
        watched.show()
    assert 1 not in watched.walk(0.5, 0.6, 10)
    watched = Watched()
    watched.walk(0.1, 0.1, 20)
    for _ in range(10):
        watched.show()
    assert 1 not in watched.walk(0.9, 0.9, 10)


def test_one_in_other_clothes_is_another() -> None:
    red, blue = np.zeros(27), np.zeros(27)
    red[1] = blue[13] = 1.0
    watched = Watched()
    for _ in range(20):
        watched.show(person(0.5), colours=[red])
    for _ in range(10):
        watched.show()
    assert [watched.show(person(0.5), colours=[blue]) for _ in range(5)][-1] != [1]


def test_a_single_false_box_is_not_taken_for_who_is_lost() -> None:
    watched = Watched()
    watched.walk(0.5, 0.5, 20)
    for _ in range(10):
        watched.show()
    assert watched.show(person(0.6)) != [1]
    for _ in range(5):
        watched.show()
    assert watched.walk(0.5, 0.5, 5)[-1] == 1


def test_weak_boxes_go_on_with_a_track_and_begin_none() -> None:
    watched = Watched()
    assert watched.show(person(0.5, score=0.4)) == [0]
    watched.walk(0.5, 0.5, 5)
    assert watched.show(person(0.5, score=0.4)) == [1]


def test_classes_are_never_mixed() -> None:
    watched = Watched()
    watched.walk(0.5, 0.5, 5)
    assert watched.show(person(0.5)._replace(label="dog")) == [2]


def test_where_pictures_are_rare_things_are_kept_for_some_pictures() -> None:
    tracker = Tracker(rate=0.5)
    told = [
        tracker.add_picture([person(0.5)] if at != 3 else [], at * 4_000_000) for at in range(1, 7)
    ]
    assert {one.track for each in told for one in each} == {1}


def test_a_clock_that_is_set_back_ends_nothing() -> None:
    tracker = Tracker()
    for at in range(1, 6):
        tracker.add_picture([person(0.5)], 10_000_000 + at * STEP)
    assert tracker.add_picture([person(0.5)], STEP)[0].track == 1
    assert tracker.add_picture([person(0.5)], 2 * STEP)[0].track == 1


def test_where_it_stands_trembles_less_than_its_box() -> None:
    rng = np.random.default_rng(3)
    tracker, feet = Tracker(), []
    for at in range(1, 200):
        thing = person(0.5, bottom=0.8 + float(rng.normal(0, 0.01)))
        feet.append(tracker.add_picture([thing], at * STEP)[0].foot[1])
    assert np.std(feet[20:]) < 0.007


boxes = st.builds(
    lambda x, y, w, h, score: Detection("person", score, x, y, x + w, y + h),
    st.floats(0, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1),
)  # fmt: skip


@given(st.lists(st.tuples(st.integers(-(10**7), 10**8), st.lists(boxes, max_size=5)), max_size=20))
def test_whatever_comes_no_two_boxes_of_a_picture_are_one_thing(told) -> None:
    tracker, at = Tracker(TrackerRule(sure=0.5)), 10**9
    for later, things in told:
        at += later
        numbers = [one.track for one in tracker.add_picture(things, at)]
        given_numbers = [number for number in numbers if number]
        assert len(set(given_numbers)) == len(given_numbers)


def test_colours_tell_shirts_apart_and_are_none_of_what_is_tiny() -> None:
    red = np.full((100, 100, 3), (200, 30, 30), np.uint8)
    green = np.full((100, 100, 3), (30, 200, 30), np.uint8)
    one, other = colours_of(red, person(0.5)), colours_of(green, person(0.5))
    assert one.sum() == other.sum() == 1
    assert one @ other == 0
    assert colours_of(red[:5, :5], person(0.5)) is None


def came_of(tracker: Tracker, pictures: list[list[Detection]]) -> list[tuple[float, float] | None]:
    told = [tracker.add_picture(things, at * STEP) for at, things in enumerate(pictures)]
    return [one.came for picture in told for one in picture if one.track]


def test_one_who_comes_in_is_traced_back_to_where_an_unsure_box_showed_them_first() -> None:
    walk = np.linspace(0.05, 0.30, 13)
    # Hardly seen at the edge, missed on some pictures, then sure.
    coming = [[person(x, score=0.35)] for x in walk[:8:2]] + [[person(x)] for x in walk[8:]]
    told = came_of(Tracker(), coming)
    # Told once, on the third sure picture.
    assert [one is not None for one in told] == [False, False, True, False, False]
    assert told[2] == pytest.approx((0.05, 0.8))


@pytest.mark.parametrize(
    "before",
    [
        [person(0.9, score=0.35)],
        [person(0.30, score=0.35, high=0.1)],
        [Detection("dog", 0.35, 0.25, 0.4, 0.35, 0.8)],
    ],
    ids=["far away", "of another size", "of another class"],
)
def test_an_unsure_box_of_something_else_says_nothing_of_where_one_came_from(before) -> None:
    told = came_of(Tracker(), [before, *([person(0.3)] for _ in range(3))])
    assert told[-1] == pytest.approx((0.3, 0.8))


def test_one_who_is_found_again_came_from_where_they_were_lost() -> None:
    there = [[person(0.4)] for _ in range(10)]
    lost: list[list[Detection]] = [[] for _ in range(30)]
    told = came_of(Tracker(), there + lost + [[person(0.45)] for _ in range(5)])
    assert [one for one in told if one is not None] == [pytest.approx((0.4, 0.8))]
