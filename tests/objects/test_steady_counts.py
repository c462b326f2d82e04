"""Counts for interlocks stay while somebody is in view, and follow at once when more come."""

from talaia.model.connection import DetectionSource
from talaia.model.detection import Detect
from talaia.objects.detection import Detection
from talaia.objects.steady_counts import SteadyCounts

STEP = 200_000
PERSON = {"path": DetectionSource(stream="front", sees="person")}


def person(score: float = 0.8, left: float = 0.4) -> Detection:
    return Detection("person", score, left, 0.2, left + 0.2, 0.9)


def told(pictures: list[list[Detection]], hold: float = 2.0) -> list[int]:
    counts = SteadyCounts(Detect(confidence=0.5, hold=hold))
    return [
        counts.count_things(things, PERSON, at * STEP)["path"] for at, things in enumerate(pictures)
    ]


def test_a_person_whom_the_detector_misses_for_a_moment_is_still_there() -> None:
    assert told([[], [person()], [], [], [person(0.6)], []]) == [0, 1, 1, 1, 1, 1]


def test_who_is_gone_for_longer_than_the_hold_time_is_gone() -> None:
    assert told([[person()], *[[]] * 12]) == [*[1] * 11, 0, 0]


def test_a_weak_box_counts_on_where_a_sure_one_was_and_nowhere_else() -> None:
    weak = [[person(0.36, 0.41)]] * 20
    assert told([[person()], *weak])[-1] == 1
    assert told([[person(0.8, 0.0)], *weak])[-1] == 0
    assert told(weak)[-1] == 0


def test_a_weak_box_does_not_stand_for_a_person_for_ever() -> None:
    assert told([[person()], *[[person(0.4)]] * 100])[-1] == 0


def test_more_count_at_once_and_without_hold_time_each_picture_counts() -> None:
    assert told([[person()], [person(), person(left=0.0)]]) == [1, 2]
    assert told([[person()], [], [person()], []], hold=0.0) == [1, 0, 1, 0]


def test_a_clock_that_is_put_back_begins_anew() -> None:
    counts = SteadyCounts(Detect(confidence=0.5))
    assert counts.count_things([person()], PERSON, 10_000_000)["path"] == 1
    assert counts.count_things([], PERSON, 5_000_000)["path"] == 0
