"""What was seen from when to when."""

from hypothesis import given, strategies as st

from talaia.gateway.objects.boxes import Box
from talaia.gateway.objects.sightings import GONE_US, Sighting, Sightings

CLASSES = ("person", "dog", "chair")
STEP = 100_000


def box(label: str, score: float = 0.8) -> Box:
    return Box(CLASSES.index(label), score, 0.1, 0.1, 0.2, 0.2)


def watching() -> Sightings:
    return Sightings(CLASSES, ["person", "dog"], 0.5)


def test_something_is_in_sight_when_it_was_seen_three_times_and_gone_after_a_while() -> None:
    watch = watching()
    news = [watch.take([box("person")], at * STEP)[1] for at in range(3)]
    assert news == [[], [], [Sighting("person", 1, 0.8, 0, None)]]
    assert watch.take([box("person", 0.9), box("person")], 3 * STEP)[1] == []
    assert watch.take([], 3 * STEP + GONE_US)[1] == []
    assert watch.take([], 3 * STEP + GONE_US + 1)[1] == [Sighting("person", 2, 0.9, 0, 3 * STEP)]


def test_error_of_the_detector_on_single_pictures_is_no_sighting() -> None:
    watch = watching()
    for at in range(0, 60_000_000, 1_000_000):
        assert watch.take([box("dog")], at)[1] == []


def test_classes_nobody_asked_for_and_unsure_ones_are_not_counted() -> None:
    counts, news = watching().take([box("chair"), box("dog", 0.4), box("person")], 0)
    assert counts == {"person": 1, "dog": 0}
    assert news == []


def test_what_is_still_in_sight_ends_when_nobody_looks_any_more() -> None:
    watch = watching()
    for at in range(3):
        watch.take([box("dog")], at * STEP)
    assert watch.end() == [Sighting("dog", 1, 0.8, 0, 2 * STEP)]
    assert watch.end() == []


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
    news: list[Sighting] = []
    for later, labels in told:
        at += later
        news += watch.take([box(each) for each in labels], at)[1]
    news += watch.end()
    for label in ("person", "dog"):
        own = [each for each in news if each.label == label]
        assert [each.ended_us is None for each in own] == [True, False] * (len(own) // 2)
        times = [t for one in own[1::2] for t in (one.began_us, one.ended_us)]
        assert times == sorted(times)
        assert [one.began_us for one in own[::2]] == [one.began_us for one in own[1::2]]
