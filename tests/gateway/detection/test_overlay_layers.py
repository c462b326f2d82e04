"""What is drawn over a picture is what was told of it, in few bytes however ragged it is."""

from __future__ import annotations

import numpy as np
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from talaia.gateway.detection.overlay_layers import layer_of, runs_of
from talaia.model.detection import DepthScale, ModelKind, ObjectModel
from talaia.model.picture_models.picture_model import PictureModel
from talaia.objects.kinds.classification import Likelihoods
from talaia.objects.kinds.depth import DepthMap
from talaia.objects.kinds.keypoints import Pose, Poses
from talaia.objects.kinds.segmentation import ClassMap
from talaia.wire.frames import MAX_OVERLAY_RUNS, MEDIA_FROM_GATEWAY, ModelOverlay, OverlayLayer

DEPTH = ObjectModel(file="a.onnx", kind=ModelKind.DEPTH, scale=DepthScale.METRES)
PERSON = ObjectModel(file="a.onnx", kind=ModelKind.KEYPOINTS, classes=("person",))
ROOMS = ObjectModel(file="a.onnx", kind=ModelKind.CLASSIFICATION, classes=("hall", "bath", "bed"))


def cells_of(layer: OverlayLayer) -> np.ndarray:
    runs = np.frombuffer(layer.runs, np.uint8).reshape(-1, 2)
    return np.repeat(runs[:, 1], runs[:, 0]).reshape(layer.rows, layer.columns)


def sent(layer: OverlayLayer) -> OverlayLayer:
    """Let it travel: the wire refuses what is too large or no part of a picture."""
    overlay = ModelOverlay(stream="a/b", seq=1, time_us=2, model="m", layer=layer)
    return MEDIA_FROM_GATEWAY.decode(MEDIA_FROM_GATEWAY.encode(overlay)).layer


@given(arrays(np.uint8, array_shapes(min_dims=2, max_dims=2, max_side=160)))
def test_runs_are_the_map_again(cells) -> None:
    if len(runs_of(cells)) <= MAX_OVERLAY_RUNS:
        layer = sent(layer_of(ClassMap(cells), PERSON, PictureModel()))
        np.testing.assert_array_equal(cells_of(layer), cells)


@given(st.integers(0, 2**32 - 1))
def test_noise_is_told_more_coarsely_and_what_is_smooth_as_it_is(seed: int) -> None:
    noise = np.random.default_rng(seed).integers(0, 9, (120, 160), np.uint8)
    layer = sent(layer_of(ClassMap(noise), PERSON, PictureModel()))
    np.testing.assert_array_equal(cells_of(layer), noise[::2, ::2])
    smooth = np.repeat(np.arange(120, dtype=np.uint8)[:, None], 160, axis=1)
    layer = sent(layer_of(ClassMap(smooth), PERSON, PictureModel()))
    np.testing.assert_array_equal(cells_of(layer), smooth)
    assert len(layer.runs) < 300


def test_depth_is_told_in_steps_of_nearness_with_its_ends_in_metres() -> None:
    metres = np.repeat(np.linspace(1, 9, 160, dtype=np.float32)[None], 120, axis=0)
    metres[:5] = np.nan
    layer = sent(layer_of(DepthMap(metres), DEPTH, PictureModel()))
    cells = cells_of(layer)
    assert (cells[:5] == 255).all()
    assert (cells[60, 0], cells[60, -1]) == (15, 0)
    assert layer.near is not None
    assert layer.far is not None
    assert 1 <= layer.near < 1.5 < 8.5 < layer.far <= 9
    relative = ObjectModel(file="a.onnx", kind=ModelKind.DEPTH)
    layer = sent(layer_of(DepthMap(metres), relative, PictureModel()))
    assert (layer.near, layer.far) == (None, None)
    assert cells_of(layer)[60, -1] == 15


def test_people_that_are_sure_enough_and_the_likeliest_classes_are_told() -> None:
    poses = Poses(
        (
            Pose(0.9, (0.1, 0.2, 0.3, 0.4), ((0.2, 0.3, 0.8),)),
            Pose(0.4, (0, 0, 1, 1), ((0.5, 0.5, 1.0),)),
        )
    )
    (pose,) = sent(layer_of(poses, PERSON, PictureModel(confidence=0.5))).poses
    assert (pose.score, pose.left, pose.bottom, pose.points) == (0.9, 0.1, 0.4, [(0.2, 0.3, 0.8)])
    likely = sent(layer_of(Likelihoods((0.1, 0.7, 0.2)), ROOMS, PictureModel())).likely
    assert [(one.label, one.share) for one in likely] == [
        ("bath", 0.7),
        ("bed", 0.2),
        ("hall", 0.1),
    ]
