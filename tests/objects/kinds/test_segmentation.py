"""Segmentation: what files of other programs give is read as classes, and nothing else is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from picture_model_files import colour_segmenter, constant_file

from talaia.model.detection import DetectionSource, Measured, ModelKind, ObjectModel, PictureZone
from talaia.model.picture_models.picture_model import PictureModel
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.picture_input import InputSetting
from talaia.objects.kinds.segmentation import (
    NO_CLASS,
    UNKNOWN,
    ClassMap,
    SegmentationReader,
    measure_class_map,
)
from talaia.objects.network import open_network
from talaia.objects.providers import parse_provider

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

COLOURS = ("red", "green", "blue")
MODEL = ObjectModel(file="a.onnx", kind=ModelKind.SEGMENTATION, classes=COLOURS)
# Blue above; below, red with a quarter of green at the right.
PICTURE = np.zeros((48, 64, 3), np.uint8)
PICTURE[:24] = (0, 0, 255)
PICTURE[24:] = (255, 0, 0)
PICTURE[24:, 48:] = (0, 255, 0)


def reader_of(file: Path, labels: Sequence[str] = COLOURS, side: int = 64) -> SegmentationReader:
    pytest.importorskip("onnxruntime")
    run = open_network(str(file), parse_provider("cpu"))
    return SegmentationReader(InputSetting(side), labels, run)


def scene_of(reader: SegmentationReader, picture: np.ndarray = PICTURE) -> ClassMap:
    return ClassMap.from_answer(reader.read_picture(picture, 0.5))


def told(scene: ClassMap, sees: str, measure: Measured, use: PictureModel | None = None, **area):
    source = DetectionSource(sees=sees, measure=measure, **area)
    return measure_class_map(scene, source, MODEL, use or PictureModel())


def test_each_part_of_a_picture_of_any_shape_is_its_class(tmp_path: Path) -> None:
    reader = reader_of(colour_segmenter(tmp_path / "colours.onnx", 64))
    for picture in (PICTURE, PICTURE[:, :20], PICTURE[20:28], PICTURE.repeat(9, axis=0)):
        scene = scene_of(reader, np.ascontiguousarray(picture))
        rows, columns = scene.cells.shape
        assert max(rows, columns) == 160
        wanted = picture.argmax(axis=2)[
            ((np.arange(rows) + 0.5) / rows * picture.shape[0]).astype(int)[:, None],
            ((np.arange(columns) + 0.5) / columns * picture.shape[1]).astype(int),
        ]
        # Where colours meet they are mixed, as the square has fewer pixels than the grid.
        assert (scene.cells == wanted).mean() > 0.9


def test_shares_distances_and_edges_are_told_of_the_picture_and_of_a_part_of_it(
    tmp_path: Path,
) -> None:
    scene = scene_of(reader_of(colour_segmenter(tmp_path / "colours.onnx", 64)))
    assert told(scene, "blue", Measured.SHARE) == pytest.approx(50, abs=1)
    assert told(scene, "red", Measured.SHARE) == pytest.approx(37.5, abs=1)
    assert told(scene, "red", Measured.SHARE, within=(0, 0.6, 0.7, 1)) == 100
    # Red reaches up from below to the half of the picture, and blue not even begins there.
    assert told(scene, "red", Measured.AHEAD) == pytest.approx(50, abs=1)
    assert told(scene, "blue", Measured.AHEAD) == 0
    assert told(scene, "red", Measured.AHEAD, within=(0, 0.75, 0.7, 1)) == 100
    lower = (0, 0.6, 1, 1)
    assert told(scene, "red", Measured.LEFT_EDGE, within=lower) == 0
    assert told(scene, "red", Measured.RIGHT_EDGE, within=lower) == pytest.approx(75, abs=1)
    assert told(scene, "green", Measured.LEFT_EDGE, within=lower) == pytest.approx(75, abs=1)
    # A class that is not there has no edge, and that is unknown, not nothing.
    assert math.isnan(told(scene, "blue", Measured.LEFT_EDGE, within=lower))
    path = PictureZone(name="Path", points=((0.8, 0.6), (1, 0.6), (1, 1), (0.8, 1)))
    use = PictureModel(zones={"path": path})
    assert told(scene, "green", Measured.SHARE, use, zone="path") == 100


def test_class_numbers_are_read_and_what_is_no_class_covers_nothing(tmp_path: Path) -> None:
    numbers = np.full((1, 1, 8, 8), 255, "<i8")
    numbers[..., 4:, :] = 2
    scene = scene_of(reader_of(constant_file(tmp_path / "numbers.onnx", {"classes": numbers})))
    assert set(np.unique(scene.cells)) == {2, NO_CLASS}
    assert told(scene, "blue", Measured.SHARE) == pytest.approx(50, abs=1)
    assert told(scene, "red", Measured.SHARE) == 0


def test_outputs_of_training_beside_the_scores_are_left_alone(tmp_path: Path) -> None:
    scores = np.zeros((1, 3, 4, 4), "<f4")
    scores[:, 1] = 1
    outputs = {"aux": np.zeros((1, 5, 4, 4), "<f4"), "out": scores}
    scene = scene_of(reader_of(constant_file(tmp_path / "two.onnx", outputs)))
    assert told(scene, "green", Measured.SHARE) == 100


def test_instances_cover_their_masks_within_their_boxes_the_surest_on_top(tmp_path: Path) -> None:
    masks = np.ones((1, 2, 16, 16), "<f4")
    masks[:, 1] = -1
    # Centre and size in pixels of the square, a score for each class, and the masks' weights.
    boxes = np.array(
        [
            [32, 32, 32, 32, 0.9, 0, 0, 1, 0],
            [32, 32, 64, 64, 0, 0.8, 0, 1, 0],
            # Not sure enough; and one whose mask is nowhere.
            [8, 8, 8, 8, 0, 0, 0.4, 1, 0],
            [56, 56, 8, 8, 0, 0, 0.95, 0, 1],
        ],
        "<f4",
    ).T[None]
    file = constant_file(tmp_path / "yolo.onnx", {"masks": masks, "boxes": boxes})
    scene = scene_of(reader_of(file), np.zeros((64, 64, 3), np.uint8))
    assert told(scene, "red", Measured.SHARE) == pytest.approx(25, abs=1)
    assert told(scene, "green", Measured.SHARE) == pytest.approx(75, abs=1)
    assert told(scene, "blue", Measured.SHARE) == 0


@pytest.mark.parametrize(
    ("outputs", "said"),
    [
        ({"scores": np.zeros((1, 21, 8, 8), "<f4")}, "gives 1 × 3 × rows × columns"),
        ({"scores": np.zeros((1, 8, 8, 3), "<f4")}, "this file gives 1 × 8 × 8 × 3"),
        ({"scores": np.zeros((2, 3, 8, 8), "<f4")}, "this file gives 2 × 3 × 8 × 8"),
        # How likely one class is: where it begins to be there nobody has said.
        ({"mask": np.full((1, 1, 8, 8), 0.5, "<f4")}, "whole class numbers"),
        ({"boxes": np.full((1, 84, 100), 0.5, "<f4")}, "this file gives 1 × 84 × 100"),
        ({"scores": np.zeros((1, 3), "<f4")}, "this file gives 1 × 3"),
        ({"scores": np.zeros((1, 3, 0, 8), "<f4")}, "this file gives 1 × 3 × 0 × 8"),
    ],
)
def test_another_file_is_refused_with_what_it_gives(tmp_path: Path, outputs, said: str) -> None:
    reader = reader_of(constant_file(tmp_path / "other.onnx", outputs))
    with pytest.raises(DetectorError, match=said):
        reader.read_picture(PICTURE, 0.5)


def test_cells_without_a_number_are_unknown_and_so_is_what_is_told_of_them(tmp_path: Path) -> None:
    scores = np.zeros((1, 3, 8, 8), "<f4")
    scores[:, 0] = np.inf
    scores[:, 1, 4:] = np.nan
    scene = scene_of(reader_of(constant_file(tmp_path / "nan.onnx", {"scores": scores})))
    assert set(np.unique(scene.cells)) == {0, UNKNOWN}
    assert math.isnan(told(scene, "red", Measured.SHARE))
    assert told(scene, "red", Measured.SHARE, within=(0, 0, 1, 0.4)) == 100


@pytest.mark.parametrize("side", [32, 96])
def test_file_that_wants_another_size_is_refused_with_both(tmp_path: Path, side: int) -> None:
    reader = reader_of(colour_segmenter(tmp_path / "colours.onnx", 64), side=side)
    with pytest.raises(DetectorError, match=rf"1 × 3 × 64 × 64, and is shown 1 × 3 × {side}"):
        reader.read_picture(PICTURE, 0.5)


@given(arrays(np.float32, array_shapes(min_dims=2, max_dims=4, max_side=6)), st.floats(0, 1))
def test_any_numbers_are_a_map_of_known_classes_or_an_error_in_words(output, least) -> None:
    reader = SegmentationReader(InputSetting(32), COLOURS, lambda _: [output])
    try:
        scene = ClassMap.from_answer(reader.read_picture(PICTURE, least))
    except DetectorError:
        return
    assert set(np.unique(scene.cells)) <= {0, 1, 2, NO_CLASS, UNKNOWN}
    for measure in (Measured.SHARE, Measured.AHEAD, Measured.LEFT_EDGE, Measured.RIGHT_EDGE):
        value = told(scene, "green", measure)
        assert math.isnan(value) or 0 <= value <= 100


@given(arrays(np.float32, (1, 9, 4), elements=st.floats(width=32)), st.floats(0, 1))
@example(np.full((1, 9, 4), np.finfo(np.float32).max, np.float32), 0.5)
def test_any_boxes_with_masks_are_a_map_of_known_classes(boxes, least) -> None:
    masks = np.ones((1, 2, 8, 8), np.float32)
    reader = SegmentationReader(InputSetting(32), COLOURS, lambda _: [boxes, masks])
    scene = ClassMap.from_answer(reader.read_picture(PICTURE, least))
    assert set(np.unique(scene.cells)) <= {0, 1, 2, NO_CLASS}
