"""Key points: people and their points are counted where they are, and hostile numbers nowhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from picture_model_files import constant_file, red_pose

from talaia.model.detection import DetectionSource, ModelKind, ObjectModel
from talaia.model.picture_models.picture_model import COCO_BONES, COCO_POINTS, PictureModel
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.keypoints import KeypointReader, Poses, measure_poses
from talaia.objects.kinds.picture_input import InputSetting
from talaia.objects.network import open_network
from talaia.objects.providers import parse_provider

if TYPE_CHECKING:
    from pathlib import Path

POINTS = ("hand", "foot")
MODEL = ObjectModel(
    file="a.onnx", kind=ModelKind.KEYPOINTS, classes=("person",), points=POINTS, side=64
)
RED = np.full((48, 64, 3), (255, 0, 0), np.uint8)
# Of the square; the picture lies in its middle three quarters.
PLACES = [(0.5, 0.3125), (0.6, 0.6875)]


def reader_of(file: Path) -> KeypointReader:
    pytest.importorskip("onnxruntime")
    run = open_network(str(file), parse_provider("cpu"))
    return KeypointReader(InputSetting(64), POINTS, run)


def scene_of(reader: KeypointReader, picture: np.ndarray = RED, least: float = 0.3) -> Poses:
    return Poses.from_answer(reader.read_picture(picture, least))


def count(scene: Poses, sees: str, **area) -> float:
    return measure_poses(scene, DetectionSource(sees=sees, **area), MODEL, PictureModel())


def test_person_stands_where_the_feet_are_and_a_hand_is_where_it_is(tmp_path: Path) -> None:
    reader = reader_of(red_pose(tmp_path / "pose.onnx", 64, PLACES))
    scene = scene_of(reader)
    (pose,) = scene.things
    assert pose.box == pytest.approx((0.25, 1 / 6, 0.75, 5 / 6), abs=1e-6)
    assert pose.points[0][:2] == pytest.approx((0.5, 0.25), abs=1e-6)
    assert pose.points[1][:2] == pytest.approx((0.6, 0.75), abs=1e-6)
    assert count(scene, "person") == 1
    upper, lower = (0, 0, 1, 0.5), (0, 0.5, 1, 1)
    assert (count(scene, "person", within=upper), count(scene, "person", within=lower)) == (0, 1)
    assert (count(scene, "hand", within=upper), count(scene, "hand", within=lower)) == (1, 0)
    assert (count(scene, "foot", within=upper), count(scene, "foot", within=lower)) == (0, 1)
    assert scene_of(reader, np.full((48, 64, 3), 40, np.uint8)).things == ()


def test_one_person_in_many_boxes_is_one_and_points_beside_the_picture_are_none(
    tmp_path: Path,
) -> None:
    rows = np.array(
        [
            [32, 32, 32, 32, 0.9, 20, 20, 0.9, 32, 2, 0.9],
            [33, 32, 32, 32, 0.8, 20, 20, 0.9, 32, 40, 0.9],
            [10, 40, 8, 8, 0.7, 10, 40, 0.2, 10, 40, 0.9],
        ],
        "<f4",
    ).T[None]
    scene = scene_of(reader_of(constant_file(tmp_path / "many.onnx", {"boxes": rows})))
    assert count(scene, "person") == 2
    # A foot in the grey above the picture, and a hand that nobody is sure of, do not count.
    assert (count(scene, "hand"), count(scene, "foot")) == (1, 1)


def test_cocos_skeleton_joins_points_that_it_has() -> None:
    assert len(COCO_POINTS) == 17
    assert {point for bone in COCO_BONES for point in bone} == set(COCO_POINTS)


@pytest.mark.parametrize(
    "shape", [(1, 56, 100), (1, 100, 11), (2, 11, 100), (1, 300, 6), (1, 11), (1, 3, 8, 8)]
)
def test_another_file_is_refused_with_what_it_gives(tmp_path: Path, shape) -> None:
    reader = reader_of(constant_file(tmp_path / "o.onnx", {"boxes": np.zeros(shape, "<f4")}))
    said = rf"gives 1 × 11 × boxes, for 2 points; this file gives {' × '.join(map(str, shape))}"
    with pytest.raises(DetectorError, match=said):
        reader.read_picture(RED, 0.5)


def test_thousands_of_people_are_told_as_fifty(tmp_path: Path) -> None:
    rows = np.zeros((1, 11, 5000), "<f4")
    rows[0, 0], rows[0, 1] = np.arange(5000) % 60 + 2, np.arange(5000) // 60 % 40 + 12
    rows[0, 2:5] = 1
    scene = scene_of(reader_of(constant_file(tmp_path / "crowd.onnx", {"boxes": rows})))
    assert len(scene.things) == 50


@given(arrays(np.float32, array_shapes(min_dims=3, max_dims=3, max_side=11)), st.floats(0.01, 1))
def test_any_numbers_are_poses_within_the_picture_or_an_error_in_words(output, least) -> None:
    reader = KeypointReader(InputSetting(64), POINTS, lambda _: [output])
    try:
        scene = scene_of(reader, least=least)
    except DetectorError:
        return
    for pose in scene.things:
        assert least <= pose.score <= 1
        assert all(0 <= part <= 1 for part in (*pose.box, *sum(pose.points, ())))


@given(arrays(np.float32, (1, 11, 5), elements=st.floats(width=32)))
@example(np.full((1, 11, 5), np.finfo(np.float32).max, np.float32))
def test_any_boxes_are_told_within_the_picture(output) -> None:
    scene = scene_of(KeypointReader(InputSetting(64), POINTS, lambda _: [output]), least=0.1)
    for pose in scene.things:
        assert all(0 <= part <= 1 for part in (*pose.box, *sum(pose.points, ())))
