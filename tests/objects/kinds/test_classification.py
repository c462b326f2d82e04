"""Classification: scores and probabilities are read, and what is unsure is not told."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, strategies as st
from picture_model_files import colour_classifier, constant_file

from talaia.model.detection import DetectionSource, Measured, ModelKind, ObjectModel
from talaia.model.picture_models.picture_model import PictureModel
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.classification import (
    ClassificationReader,
    Likelihoods,
    measure_likelihoods,
)
from talaia.objects.kinds.picture_input import InputSetting
from talaia.objects.network import open_network
from talaia.objects.providers import parse_provider

if TYPE_CHECKING:
    from pathlib import Path

COLOURS = ("red", "green", "blue")
MODEL = ObjectModel(file="a.onnx", kind=ModelKind.CLASSIFICATION, classes=COLOURS)
RED = np.full((48, 64, 3), (255, 0, 0), np.uint8)
SUREST = DetectionSource(measure=Measured.SUREST)


def reader_of(file: Path) -> ClassificationReader:
    pytest.importorskip("onnxruntime")
    run = open_network(str(file), parse_provider("cpu"))
    return ClassificationReader(InputSetting(32), COLOURS, run)


def scene_of(reader: ClassificationReader, picture: np.ndarray = RED) -> Likelihoods:
    return Likelihoods.from_answer(reader.read_picture(picture, 0.5))


def likely(scene: Likelihoods, sees: str) -> float:
    source = DetectionSource(sees=sees, measure=Measured.PROBABILITY)
    return measure_likelihoods(scene, source, MODEL, PictureModel())


def test_scores_become_probabilities_of_the_middle_square_of_the_picture(tmp_path: Path) -> None:
    reader = reader_of(colour_classifier(tmp_path / "colour.onnx", 32))
    scene = scene_of(reader)
    assert likely(scene, "red") == pytest.approx(100 / (1 + 2 * math.exp(-10)))
    assert measure_likelihoods(scene, SUREST, MODEL, PictureModel()) == 0
    # What lies beside the middle square does not count.
    wide = np.full((40, 120, 3), (0, 0, 255), np.uint8)
    wide[:, 40:80] = (0, 255, 0)
    assert measure_likelihoods(scene_of(reader, wide), SUREST, MODEL, PictureModel()) == 1


@pytest.mark.parametrize("shape", [(1, 3), (1, 3, 1, 1)])
def test_probabilities_are_taken_as_they_are(tmp_path: Path, shape) -> None:
    told = np.array([0.2, 0.3, 0.5], "<f4").reshape(shape)
    scene = scene_of(reader_of(constant_file(tmp_path / "sure.onnx", {"probabilities": told})))
    assert likely(scene, "blue") == pytest.approx(50)
    assert measure_likelihoods(scene, SUREST, MODEL, PictureModel(confidence=0.4)) == 2
    # None is likely enough: that is unknown.
    assert math.isnan(measure_likelihoods(scene, SUREST, MODEL, PictureModel(confidence=0.6)))


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (np.zeros((1, 1000), "<f4"), "gives 1 × 3, a number for each of 3 classes; .* 1 × 1000"),
        (np.zeros((3,), "<f4"), "this file gives 3"),
        (np.zeros((2, 3), "<f4"), "this file gives 2 × 3"),
        (np.array([[1, np.nan, 2]], "<f4"), "no finite number"),
        (np.array([[1, np.inf, 2]], "<f4"), "no finite number"),
    ],
)
def test_another_file_is_refused_with_what_it_gives(tmp_path: Path, told, said: str) -> None:
    reader = reader_of(constant_file(tmp_path / "other.onnx", {"scores": told}))
    with pytest.raises(DetectorError, match=said):
        reader.read_picture(RED, 0.5)


@given(st.lists(st.floats(allow_nan=True, width=32), min_size=3, max_size=3))
def test_any_scores_are_shares_of_one_or_an_error(scores: list[float]) -> None:
    output = np.array([scores], np.float32)
    reader = ClassificationReader(InputSetting(32), COLOURS, lambda _: [output])
    try:
        scene = Likelihoods.from_answer(reader.read_picture(RED, 0.0))
    except DetectorError:
        assert not np.isfinite(output).all()
        return
    assert sum(scene.shares) == pytest.approx(1, abs=0.02)
    assert scene.shares[scene.likeliest()] == max(scene.shares)
