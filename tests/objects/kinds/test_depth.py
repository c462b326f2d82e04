"""Depth: the nearest of an area in metres, or against the rest of the picture; never a guess."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from picture_model_files import bright_depth, constant_file

from talaia.model.detection import (
    DepthScale,
    DetectionSource,
    Measured,
    ModelKind,
    ObjectModel,
    PictureZone,
)
from talaia.model.picture_models.picture_model import PictureModel
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.depth import DepthMap, DepthReader, measure_depth, nearness_of
from talaia.objects.kinds.picture_input import InputSetting
from talaia.objects.network import open_network
from talaia.objects.providers import parse_provider

if TYPE_CHECKING:
    from pathlib import Path

METRES = ObjectModel(file="a.onnx", kind=ModelKind.DEPTH, scale=DepthScale.METRES)
NEARNESS = ObjectModel(file="a.onnx", kind=ModelKind.DEPTH)
# From 1 m at the left to 9 m at the right, where the file says ten times the brightness.
RAMP = np.repeat(np.linspace(25.5, 229.5, 64)[None, :, None], 48, axis=0).repeat(3, axis=2)
PICTURE = RAMP.round().astype(np.uint8)


def reader_of(file: Path, side: int = 64) -> DepthReader:
    pytest.importorskip("onnxruntime")
    run = open_network(str(file), parse_provider("cpu"))
    return DepthReader(InputSetting(side), (), run)


def scene_of(reader: DepthReader, picture: np.ndarray = PICTURE) -> DepthMap:
    return DepthMap.from_answer(reader.read_picture(picture, 0.0))


def nearest(scene: DepthMap, model: ObjectModel, use: PictureModel | None = None, **area) -> float:
    source = DetectionSource(measure=Measured.NEAREST, **area)
    return measure_depth(scene, source, model, use or PictureModel())


def test_nearest_in_metres_is_told_of_the_picture_a_part_and_a_zone(tmp_path: Path) -> None:
    # 70 is a multiple of 14, as Depth Anything wants it, and not of 32.
    scene = scene_of(reader_of(bright_depth(tmp_path / "depth.onnx", 70), 70))
    assert nearest(scene, METRES) == pytest.approx(1.15, abs=0.15)
    assert nearest(scene, METRES, within=(0.5, 0, 1, 1)) == pytest.approx(5.1, abs=0.2)
    right = PictureZone(name="Right", points=((0.75, 0), (1, 0), (1, 1), (0.75, 1)))
    use = PictureModel(zones={"right": right})
    assert nearest(scene, METRES, use, zone="right") == pytest.approx(7.1, abs=0.2)


def test_nearness_without_a_unit_is_told_against_the_rest_of_the_picture(tmp_path: Path) -> None:
    scene = scene_of(reader_of(bright_depth(tmp_path / "depth.onnx", 64)))
    # Larger is nearer: the right edge is nearest.
    assert nearest(scene, NEARNESS) == pytest.approx(100, abs=1)
    assert nearest(scene, NEARNESS, within=(0, 0, 0.5, 1)) == pytest.approx(50, abs=3)
    assert np.isfinite(nearness_of(scene, DepthScale.NEARNESS)).all()
    # A picture on which all is as near tells nothing.
    flat = scene_of(reader_of(bright_depth(tmp_path / "depth.onnx", 64)), np.full_like(PICTURE, 90))
    inner = DepthMap(flat.cells[5:-5, 5:-5])
    assert math.isnan(nearest(inner, NEARNESS))


def test_what_has_no_number_or_no_distance_is_unknown(tmp_path: Path) -> None:
    told = np.full((1, 1, 8, 8), 3, "<f4")
    told[..., :4, :], told[..., 4:, 4:] = np.nan, -1
    scene = scene_of(reader_of(constant_file(tmp_path / "nan.onnx", {"depth": told})))
    assert nearest(scene, METRES, within=(0, 0.6, 0.4, 1)) == 3
    assert math.isnan(nearest(scene, METRES, within=(0, 0, 1, 0.4)))
    assert math.isnan(nearest(scene, METRES, within=(0.6, 0.6, 1, 1)))
    # A few cells with a number say nothing of all of the picture.
    told[..., 4:, :] = np.nan
    told[..., 6, :2] = 3
    scene = scene_of(reader_of(constant_file(tmp_path / "few.onnx", {"depth": told})))
    assert math.isnan(nearest(scene, METRES))
    assert nearest(scene, METRES, within=(0, 0.85, 0.2, 1)) == 3
    infinite = np.full((1, 8, 8), np.inf, "<f4")
    scene = scene_of(reader_of(constant_file(tmp_path / "inf.onnx", {"depth": infinite})))
    assert math.isnan(nearest(scene, METRES))
    assert math.isnan(nearest(scene, NEARNESS))


@pytest.mark.parametrize(
    "shape", [(1, 3, 8, 8), (1, 8, 8, 1), (2, 8, 8), (8, 8), (1, 100), (1, 1, 0, 8)]
)
def test_another_file_is_refused_with_what_it_gives(tmp_path: Path, shape) -> None:
    reader = reader_of(constant_file(tmp_path / "o.onnx", {"depth": np.ones(shape, "<f4")}))
    with pytest.raises(DetectorError, match=f"this file gives {' × '.join(map(str, shape))}"):
        reader.read_picture(PICTURE, 0.5)


@given(
    arrays(np.float32, array_shapes(min_dims=2, max_dims=4, max_side=6)),
    st.sampled_from([METRES, NEARNESS]),
)
def test_any_numbers_are_a_distance_or_unknown_or_an_error_in_words(output, model) -> None:
    reader = DepthReader(InputSetting(32), (), lambda _: [output])
    try:
        scene = DepthMap.from_answer(reader.read_picture(PICTURE, 0.0))
    except DetectorError:
        return
    value = nearest(scene, model)
    assert math.isnan(value) or value >= 0
    assert model is METRES or math.isnan(value) or value <= 100
    near = nearness_of(scene, model.scale)
    assert ((near >= 0) & (near <= 1) | np.isnan(near)).all()
