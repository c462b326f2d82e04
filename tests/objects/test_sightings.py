"""What was seen from when to when."""

import pytest
from hypothesis import given, strategies as st

from talaia.objects.detection import Detection
from talaia.objects.sightings import GONE_US, ObjectSighting, Sightings

pytestmark = pytest.mark.pure

STEP = 100_000


def box(label: str, score: float = 0.8) -> Detection:
    return Detection(label, score, 0.1, 0.1, 0.2, 0.2)


def watching() -> Sightings:
    return Sightings(["person", "dog"], 0.5)


def test_something_is_in_sight_when_it_was_seen_three_times_and_gone_after_a_while() -> None:
    watch = watching()
    news = [watch.add_picture([box("person")], at * STEP) for at in range(3)]
    assert news == [[], [], [ObjectSighting("person", 1, 0.8, 0, None)]]
    assert watch.add_picture([box("person", 0.82)], 3 * STEP) == []
    assert watch.pass_time(3 * STEP + GONE_US) == []
    assert watch.pass_time(3 * STEP + GONE_US + 1) == [
        ObjectSighting("person", 1, 0.82, 0, 3 * STEP)
    ]


def test_more_of_them_or_surer_ones_are_told_before_the_end() -> None:
    watch = watching()
    for at in range(3):
        watch.add_picture([box("person")], at * STEP)
    assert watch.add_picture([box("person"), box("person")], 3 * STEP) == [
        ObjectSighting("person", 2, 0.8, 0, None)
    ]
    assert watch.add_picture([box("person", 0.9)], 4 * STEP) == [
        ObjectSighting("person", 2, 0.9, 0, None)
    ]
    assert watch.add_picture([box("person", 0.9)], 5 * STEP) == []


def test_where_pictures_are_rare_a_sighting_takes_as_many_of_them() -> None:
    watch = Sightings(["person"], 0.5, rate=1.0)
    news = [watch.add_picture([box("person")], at * 1_000_000) for at in range(4)]
    assert news[2:] == [[ObjectSighting("person", 1, 0.8, 0, None)], []]
    gone = [watch.add_picture([], at * 1_000_000) for at in range(4, 12)]
    assert gone[:6] == [[]] * 6
    assert gone[6] == [ObjectSighting("person", 1, 0.8, 0, 3_000_000)]


def test_error_of_the_detector_on_single_pictures_is_no_sighting() -> None:
    watch = watching()
    for at in range(0, 60_000_000, 1_000_000):
        assert watch.add_picture([box("dog")] if at % 6_000_000 == 0 else [], at) == []


def test_classes_nobody_asked_for_and_unsure_ones_are_no_sighting() -> None:
    watch = watching()
    for at in range(5):
        assert watch.add_picture([box("chair"), box("dog", 0.4)], at * STEP) == []
    assert watch.end_sightings() == []


def test_what_is_still_in_sight_ends_when_nobody_looks_any_more() -> None:
    watch = watching()
    for at in range(3):
        watch.add_picture([box("dog")], at * STEP)
    assert watch.end_sightings() == [ObjectSighting("dog", 1, 0.8, 0, 2 * STEP)]
    assert watch.end_sightings() == []


pictures = st.lists(
    st.tuples(
        st.integers(0, 2_000_000),
        st.lists(st.sampled_from(["person", "dog", "chair"]), max_size=3),
    ),
    max_size=80,
)


@given(pictures)
def test_sightings_of_a_class_follow_each_other_and_each_ends_once(told) -> None:
    watch = watching()
    at = 0
    news: list[ObjectSighting] = []
    for later, labels in told:
        at += later
        news += watch.add_picture([box(each) for each in labels], at)
    news += watch.end_sightings()
    for label in ("person", "dog"):
        own = [each for each in news if each.label == label]
        # What is told again of one that goes on is no beginning.
        own = [
            each
            for index, each in enumerate(own)
            if each.ended_us is not None or not index or own[index - 1].ended_us is not None
        ]
        assert [each.ended_us is None for each in own] == [True, False] * (len(own) // 2)
        times = [t for one in own[1::2] for t in (one.began_us, one.ended_us)]
        assert times == sorted(times)
        assert [one.began_us for one in own[::2]] == [one.began_us for one in own[1::2]]
