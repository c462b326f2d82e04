"""Boxes: fitting pictures, reading heads, and which boxes are one thing."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.objects.boxes import (
    as_picture_parts,
    boxes_from_centres,
    boxes_from_distances,
    fit_to_square,
    suppress_overlaps,
)
from talaia.objects.detector import Detector, OutputFormat, Setting
from talaia.objects.errors import DetectorError

pytestmark = pytest.mark.pure

sizes = st.integers(1, 120)


@given(sizes, sizes, st.sampled_from([32, 64]))
def test_any_picture_fits_with_its_shape_kept(width: int, height: int, side: int) -> None:
    square, frame = fit_to_square(np.full((height, width, 3), 7, np.uint8), side)
    assert square.shape == (side, side, 3)
    shown = np.argwhere((square == 7).all(axis=2))
    (top, left), (bottom, right) = shown.min(axis=0), shown.max(axis=0)
    assert (top, left) == (frame.top, frame.left)
    assert right - left + 1 == max(1, round(width * frame.scale))
    assert bottom - top + 1 == max(1, round(height * frame.scale))
    assert max(right - left, bottom - top) + 1 == side


@given(sizes, sizes, st.sampled_from([32, 64]), st.integers(0, 9), st.booleans())
def test_pixels_are_interpolated_linearly_between_their_centres(
    width, height, side, seed, exactly
) -> None:
    picture = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    square, frame = fit_to_square(picture, side, exactly=exactly)
    rows, columns = round(height * frame.scale) or 1, round(width * frame.scale) or 1
    y = np.clip((np.arange(rows) + 0.5) * height / rows - 0.5, 0, height - 1)
    x = np.clip((np.arange(columns) + 0.5) * width / columns - 0.5, 0, width - 1)
    low_y, low_x = np.floor(y).astype(int), np.floor(x).astype(int)
    part_y, part_x = (y - low_y)[:, None, None], (x - low_x)[None, :, None]
    high_y, high_x = np.minimum(low_y + 1, height - 1), np.minimum(low_x + 1, width - 1)
    exact = (
        picture[low_y][:, low_x] * (1 - part_y) * (1 - part_x)
        + picture[high_y][:, low_x] * part_y * (1 - part_x)
        + picture[low_y][:, high_x] * (1 - part_y) * part_x
        + picture[high_y][:, high_x] * part_y * part_x
    )
    shown = square[frame.top : frame.top + rows, frame.left : frame.left + columns]
    # Two roundings, and how far it lies is told in 256 parts.
    assert np.abs(shown - exact).max() < (0.51 if exactly else 2.5)


def test_smaller_picture_has_its_pixels_where_they_were() -> None:
    picture = np.zeros((40, 40, 3), np.uint8)
    picture[:, 20:] = 200
    square, _ = fit_to_square(picture, 20)
    assert (square[:, :10] == 0).all()
    assert (square[:, 10:] == 200).all()


def test_box_of_the_square_is_told_in_parts_of_the_picture() -> None:
    _, frame = fit_to_square(np.zeros((100, 200, 3), np.uint8), 400)
    (box,) = as_picture_parts([(3, 0.9, np.array([100, 100, 300, 300], np.float32))], frame)
    assert box == (3, 0.9, 0.25, 0.0, 0.75, 1.0)


def test_box_beside_the_picture_is_none() -> None:
    _, frame = fit_to_square(np.zeros((100, 200, 3), np.uint8), 400)
    assert as_picture_parts([(0, 0.9, np.array([0, 0, 400, 90], np.float32))], frame) == []


def test_distances_are_the_means_of_their_distributions() -> None:
    bins = np.full((16, 44), -50.0, np.float32)
    # Left one step, top two, right three, and below between four and five.
    for side, at in enumerate((1, 2, 3)):
        bins[:, side * 11 + at] = 50
    bins[:, 33 + 4] = bins[:, 33 + 5] = 50
    found = boxes_from_distances(bins, 32, 8)
    # The cell of the second line, third column: its centre is (20, 12).
    assert found[4 + 2] == pytest.approx([20 - 8, 12 - 16, 20 + 24, 12 + 36], abs=1e-4)


def test_centres_and_sizes_are_corners() -> None:
    assert boxes_from_centres(np.array([[10, 20, 4, 6]], np.float32)).tolist() == [[8, 17, 12, 23]]


coordinates = st.floats(0, 100, width=32)


@given(
    st.lists(st.tuples(coordinates, coordinates, coordinates, coordinates), max_size=30),
    st.data(),
)
def test_what_is_kept_is_sure_sorted_and_apart(places: list[tuple[float, ...]], data) -> None:
    boxes = np.array(
        [(min(a, c), min(b, d), max(a, c), max(b, d)) for a, b, c, d in places], np.float32
    ).reshape(-1, 4)
    score = st.floats(0, 1, width=32) | st.just(float("nan"))
    rows = data.draw(st.lists(st.tuples(score, score), min_size=len(boxes), max_size=len(boxes)))
    scores = np.array(rows, np.float32).reshape(-1, 2)
    found = suppress_overlaps(boxes, scores, 0.3, most=10)
    assert [each[1] for each in found] == sorted((each[1] for each in found), reverse=True)
    assert all(each[1] >= 0.3 for each in found)
    if (np.nan_to_num(scores) >= 0.3).any():
        assert found[0][1] == np.nan_to_num(scores).max()
    for first, (label, _, one) in enumerate(found):
        for other_label, _, other in found[first + 1 :]:
            if other_label == label:
                assert _shared(one, other) <= 0.5 + 1e-5


def _shared(one: np.ndarray, other: np.ndarray) -> float:
    width = max(0.0, float(min(one[2], other[2]) - max(one[0], other[0])))
    height = max(0.0, float(min(one[3], other[3]) - max(one[1], other[1])))
    areas = sum(float((box[2] - box[0]) * (box[3] - box[1])) for box in (one, other))
    return width * height / max(areas - width * height, 1e-9)


def test_things_of_two_classes_may_be_in_one_place() -> None:
    boxes = np.array([[0, 0, 10, 10], [0, 0, 10, 9]], np.float32)
    alike = suppress_overlaps(boxes, np.array([[0.9, 0], [0.8, 0]], np.float32), 0.3)
    apart = suppress_overlaps(boxes, np.array([[0.9, 0], [0, 0.8]], np.float32), 0.3)
    assert [each[0] for each in alike] == [0]
    assert [each[0] for each in apart] == [0, 1]


def test_yolo_tells_boxes_by_centre_and_size() -> None:
    told = np.zeros((1, 6, 3), np.float32)
    told[0, :, 1] = (32, 32, 16, 32, 0.1, 0.8)
    detector = Detector(Setting(OutputFormat.YOLO, 64), ["cat", "dog"], lambda _: [told])
    (box,) = detector.detect_objects(np.zeros((64, 64, 3), np.uint8), 0.5)
    assert box == pytest.approx((1, 0.8, 0.375, 0.25, 0.625, 0.75))


def test_colours_come_in_the_order_and_size_that_the_setting_says() -> None:
    given_to: list[np.ndarray] = []

    def run(shown: np.ndarray) -> list[np.ndarray]:
        given_to.append(shown)
        return [np.zeros((1, 5, 0), np.float32)]

    picture = np.zeros((8, 8, 3), np.uint8)
    picture[..., 0] = 100
    setting = Setting(OutputFormat.YOLO, 8, (1.0, 2.0, 50.0), (2.0, 2.0, 2.0), blue_first=True)
    Detector(setting, ["cat"], run).detect_objects(picture, 0.5)
    assert given_to[0].shape == (1, 3, 8, 8)
    assert given_to[0][0, :, 0, 0].tolist() == [-0.5, -1.0, 25.0]


@pytest.mark.parametrize("kind", OutputFormat)
def test_file_that_gives_other_numbers_is_named_with_what_it_gives(kind: OutputFormat) -> None:
    detector = Detector(Setting(kind, 64), ["cat"], lambda _: [np.zeros((1, 7, 3), np.float32)])
    with pytest.raises(DetectorError, match="this file gives 1 × 7 × 3: choose another kind"):
        detector.detect_objects(np.zeros((8, 8, 3), np.uint8), 0.5)
