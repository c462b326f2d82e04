"""What was seen from when to when: one sighting for each thing that is followed."""

import pytest
from hypothesis import given, strategies as st

from talaia.objects.detection import Detection
from talaia.objects.sightings import ObjectSighting, Sightings
from talaia.objects.tracker import TrackedThing

pytestmark = pytest.mark.pure

STEP, GONE = 100_000, 8_000_000


def one(track: int, label: str = "person", score: float = 0.8) -> TrackedThing:
    return TrackedThing(track, 1, Detection(label, score, 0.1, 0.1, 0.2, 0.2), (0.15, 0.2))


class Watching:
    """Sightings of persons and dogs, on pictures that come ten times a second."""

    def __init__(self, between_us: float = STEP) -> None:
        """Have seen nothing yet."""
        self.sightings, self.between_us = Sightings(["person", "dog"], 0.5), between_us

    def picture(self, at_us: int, *tracked: TrackedThing) -> list[ObjectSighting]:
        return self.sightings.add_picture(tracked, at_us, self.between_us, GONE)


def test_something_is_in_sight_when_it_was_seen_three_times_and_gone_after_a_while() -> None:
    watch = Watching()
    news = [watch.picture(at * STEP, one(1)) for at in range(3)]
    assert news == [[], [], [ObjectSighting("person", 1, 0.8, 0, None, 1)]]
    assert watch.picture(3 * STEP, one(1, score=0.82)) == []
    assert watch.sightings.pass_time(3 * STEP + GONE, GONE) == []
    assert watch.sightings.pass_time(3 * STEP + GONE + 1, GONE) == [
        ObjectSighting("person", 1, 0.82, 0, 3 * STEP, 1)
    ]


def test_two_that_come_on_one_picture_are_two_and_begin_a_microsecond_apart() -> None:
    watch = Watching()
    news = [watch.picture(at * STEP, one(1), one(2)) for at in range(3)]
    assert news[2] == [
        ObjectSighting("person", 2, 0.8, 0, None, 1),
        ObjectSighting("person", 2, 0.8, 1, None, 2),
    ]


def test_one_that_was_hidden_goes_on_with_its_sighting() -> None:
    watch = Watching()
    for at in range(3):
        watch.picture(at * STEP, one(1))
    for at in range(3, 43):
        assert watch.picture(at * STEP) == []
    assert watch.picture(43 * STEP, one(1)) == []
    assert watch.sightings.end_sightings() == [ObjectSighting("person", 1, 0.8, 0, 43 * STEP, 1)]


def test_more_of_them_or_surer_ones_are_told_before_the_end() -> None:
    watch = Watching()
    for at in range(3):
        watch.picture(at * STEP, one(1))
    assert watch.picture(3 * STEP, one(1), one(2)) == [ObjectSighting("person", 2, 0.8, 0, None, 1)]
    assert watch.picture(4 * STEP, one(1, score=0.9)) == [
        ObjectSighting("person", 2, 0.9, 0, None, 1)
    ]
    assert watch.sightings.fresh == {1}
    assert watch.picture(5 * STEP, one(1, score=0.9)) == []
    assert watch.sightings.fresh == frozenset()


def test_where_pictures_are_rare_three_of_them_may_take_longer() -> None:
    watch = Watching(between_us=1_000_000)
    news = [watch.picture(at * 1_000_000, one(1)) for at in range(3)]
    assert news == [[], [], [ObjectSighting("person", 1, 0.8, 0, None, 1)]]


def test_single_pictures_classes_nobody_asked_for_and_unsure_ones_are_no_sighting() -> None:
    watch = Watching()
    for at in range(0, 60_000_000, 2_000_000):
        assert watch.picture(at, one(1, "dog")) == []
    for at in range(5):
        assert watch.picture(70_000_000 + at * STEP, one(2, "chair"), one(0)) == []
    for at in range(2):
        watch.picture(80_000_000 + at * STEP, one(3))
    assert watch.picture(80_000_000 + 2 * STEP, one(3, score=0.4)) == []
    assert watch.sightings.end_sightings() == []


pictures = st.lists(
    st.tuples(
        st.integers(0, 2_000_000),
        st.dictionaries(st.integers(1, 6), st.floats(0.3, 1), max_size=3),
    ),
    max_size=80,
)


@given(pictures)
def test_each_sighting_begins_and_ends_once_and_no_two_have_the_same_begin(told) -> None:
    watch = Watching()
    at = 0
    news: list[ObjectSighting] = []
    for later, scores in told:
        at += later
        news += watch.picture(at, *(one(track, score=score) for track, score in scores.items()))
    news += watch.sightings.end_sightings()
    begins = {each.began_us for each in news}
    for began_us in begins:
        own = [each for each in news if each.began_us == began_us]
        assert len({each.track for each in own}) == 1
        assert [each.ended_us is None for each in own] == [True] * (len(own) - 1) + [False]
        assert own[-1].ended_us >= began_us
