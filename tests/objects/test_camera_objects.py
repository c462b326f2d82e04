"""One camera that sees: counts, parts of the picture, and thumbnails."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.model.connection import DetectionSource
from talaia.model.detection import Detect
from talaia.objects.camera_objects import MOST_THUMBNAIL, CameraObjects, cut_out, jpeg_of, least_of
from talaia.objects.detection import Detection

STEP = 100_000
GREY = np.full((480, 640, 3), 120, np.uint8)


def person(score: float = 0.8, left: float = 0.4, bottom: float = 0.9) -> Detection:
    return Detection("person", score, left, 0.2, left + 0.2, bottom)


def eyes(**counted: DetectionSource) -> CameraObjects:
    return CameraObjects(Detect(classes=("person",), confidence=0.5), counted)


def source(
    within: tuple[float, float, float, float] | None = None, sees: str = "person"
) -> DetectionSource:
    return DetectionSource(stream="front", sees=sees, within=within)


def test_only_those_are_counted_whose_feet_are_in_the_part() -> None:
    path = source((0.3, 0.6, 0.7, 1.0))
    one = eyes(all=source(), path=path, dogs=source(sees="dog"))
    assert one.count_things([person(), person(left=0.0), person(bottom=0.5)]) == {
        "all": 3, "path": 1, "dogs": 0,
    }  # fmt: skip
    assert one.count_things([person(score=0.4)]) == {"all": 0, "path": 0, "dogs": 0}
    one.apply_counts({"path": path})
    assert one.count_things([person()]) == {"path": 1}


def test_boxes_are_told_that_count_for_nothing_but_are_fairly_sure() -> None:
    assert least_of(Detect(confidence=0.8)) == 0.3
    assert least_of(Detect(confidence=0.2)) == 0.2


def test_thumbnail_is_of_the_surest_moment_before_it_is_told() -> None:
    simplejpeg = pytest.importorskip("simplejpeg")
    one = eyes()
    news = []
    for at, (score, light) in enumerate([(0.6, 40), (0.9, 200), (0.7, 90)]):
        picture = np.full((480, 640, 3), light, np.uint8)
        news += one.add_picture([person(score)], picture, at * STEP)
    (told,) = news
    assert told.sighting.score == 0.9
    assert abs(int(simplejpeg.decode_jpeg(told.thumbnail).mean()) - 200) < 5
    # Told of the same again without a surer moment: it is there already.
    (more,) = one.add_picture([person(0.8), person(0.8)], GREY, 4 * STEP)
    assert more.thumbnail == b""
    (over,) = one.end_sightings()
    assert (over.sighting.most, over.thumbnail) == (2, b"")


def test_thumbnail_of_noise_is_no_larger_than_it_may_be() -> None:
    pytest.importorskip("simplejpeg")
    noise = np.random.default_rng(1).integers(0, 255, (3000, 4000, 3), np.uint8)
    cut = cut_out(noise, Detection("person", 1, 0, 0, 1, 1))
    assert max(cut.shape[:2]) <= 240
    data = jpeg_of(cut)
    assert data[:2] == b"\xff\xd8"
    assert len(data) <= MOST_THUMBNAIL


shares = st.floats(0, 1)


@given(st.integers(1, 50), st.integers(1, 50), shares, shares, shares, shares)
def test_surroundings_are_never_empty(
    height: int, width: int, left: float, top: float, right: float, bottom: float
) -> None:
    picture = np.zeros((height, width, 3), np.uint8)
    low, high = sorted((left, right))
    cut = cut_out(picture, Detection("a", 1, low, min(top, bottom), high, max(top, bottom)))
    assert cut.shape[0] > 0
    assert cut.shape[1] > 0
