"""A model of one's own at work on one camera, and what signals may tell of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.base import Shape
from talaia.model.detection import DepthScale, Measured, ModelKind, PictureZone

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.detection import ObjectModel

__all__ = [
    "COCO_BONES",
    "COCO_POINTS",
    "MEASURES",
    "PictureModel",
    "bones_of",
    "measured_unit",
    "points_of",
]

# In the order of COCO's annotations of persons, which YOLO-pose has, too.
COCO_POINTS = (
    "nose",
    "left eye",
    "right eye",
    "left ear",
    "right ear",
    "left shoulder",
    "right shoulder",
    "left elbow",
    "right elbow",
    "left wrist",
    "right wrist",
    "left hip",
    "right hip",
    "left knee",
    "right knee",
    "left ankle",
    "right ankle",
)
COCO_BONES = (
    ("nose", "left eye"),
    ("nose", "right eye"),
    ("left eye", "left ear"),
    ("right eye", "right ear"),
    ("left shoulder", "right shoulder"),
    ("left shoulder", "left elbow"),
    ("left elbow", "left wrist"),
    ("right shoulder", "right elbow"),
    ("right elbow", "right wrist"),
    ("left shoulder", "left hip"),
    ("right shoulder", "right hip"),
    ("left hip", "right hip"),
    ("left hip", "left knee"),
    ("left knee", "left ankle"),
    ("right hip", "right knee"),
    ("right knee", "right ankle"),
)
# What a signal may tell of each kind.
MEASURES: Mapping[ModelKind, tuple[Measured, ...]] = {
    ModelKind.SEGMENTATION: (
        Measured.SHARE,
        Measured.AHEAD,
        Measured.LEFT_EDGE,
        Measured.RIGHT_EDGE,
    ),
    ModelKind.CLASSIFICATION: (Measured.PROBABILITY, Measured.SUREST),
    ModelKind.KEYPOINTS: (Measured.COUNT,),
    ModelKind.DEPTH: (Measured.NEAREST,),
}


class PictureModel(Shape, frozen=True, kw_only=True):
    """A model of one's own at work on one camera. It runs at the gateway.

    Attributes:
        confidence: things of ``keypoints`` that are less sure than this do not count, things of a
            segmentation by instances cover nothing, and a likeliest class that is less likely is
            not told. 0 to 1.
        max_rate: pictures a second that are looked at, at the most (Hz).
        hold: of ``keypoints``, as of `Detect`: for interlocks a count falls only after it has been
            lower for so long (s).
        zones: parts of the picture in which signals tell, by the names that their sources use.

    """

    confidence: float = 0.5
    max_rate: float = 5.0
    hold: float = 2.0
    zones: dict[str, PictureZone] = {}


def points_of(model: ObjectModel) -> tuple[str, ...]:
    """Name the points that a model tells of each thing."""
    return model.points or COCO_POINTS


def bones_of(model: ObjectModel) -> tuple[tuple[str, str], ...]:
    """Name which of its points are drawn joined."""
    return model.bones if model.points else COCO_BONES


def measured_unit(model: ObjectModel, measure: Measured) -> str:
    """Give the unit of what a signal tells of a model."""
    if measure is Measured.COUNT:
        return ""
    metres = measure is Measured.NEAREST and model.scale is DepthScale.METRES
    return "m" if metres else "%"
