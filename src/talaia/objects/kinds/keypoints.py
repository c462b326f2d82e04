"""Key points: things with named points, as people with their joints. Pure but for the run itself.

The contract is what YOLO-pose gives when it is exported: one output of 1 × (5 + 3 · points) ×
boxes, each box by centre and size in pixels of the square and how sure it is, then each point by
its place and how sure that is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from talaia.model.detection import Detect
from talaia.model.picture_models.picture_model import points_of
from talaia.objects.boxes import (
    MOST_PLACE,
    as_picture_parts,
    boxes_from_centres,
    fit_to_square,
    kept_boxes,
)
from talaia.objects.camera_objects import counts_as
from talaia.objects.detection import Detection
from talaia.objects.kinds.picture_input import PictureInput, contract_error

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.model.detection import DetectionSource, ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.objects.kinds.picture_input import InputSetting, Run

__all__ = ["KeypointReader", "Pose", "Poses", "detect_like", "measure_poses", "pose_things"]

# On one picture; of more the surest are told.
MOST_POSES = 50


class Pose(NamedTuple):
    """A thing with its points; places are parts of the picture, from the upper left.

    Attributes:
        box: left, top, right, bottom.
        points: each by its place and how sure it is; one out of the picture is not sure at all.

    """

    score: float
    box: tuple[float, float, float, float]
    points: tuple[tuple[float, float, float], ...]


class Poses(NamedTuple):
    """What is on a picture, the surest first."""

    things: tuple[Pose, ...]

    @classmethod
    def from_answer(cls, answer: Mapping[str, Any]) -> Poses:
        """Read an answer of the model's process; raises ValueError, KeyError or TypeError."""
        return cls(
            tuple(
                Pose(
                    _as_part(score),
                    (_as_part(box[0]), _as_part(box[1]), _as_part(box[2]), _as_part(box[3])),
                    tuple((_as_part(x), _as_part(y), _as_part(sure)) for x, y, sure in points),
                )
                for score, box, points in answer["poses"][:MOST_POSES]
            )
        )


def _as_part(number: float) -> float:
    return min(max(float(number), 0.0), 1.0)


class KeypointReader:
    """From a picture to the things on it and their points."""

    def __init__(self, setting: InputSetting, labels: Sequence[str], run: Run) -> None:
        """Use ``run``, which takes 1 × 3 × side × side; ``labels`` are the points'."""
        self._side, self._count, self._run = setting.side, len(labels), run
        self._input = PictureInput(setting)

    def read_picture(self, picture: NDArray[np.uint8], least: float) -> dict[str, object]:
        """Give things that are at least so sure, with their points.

        Raises:
            DetectorError: the file gives something else than YOLO-pose does.

        """
        square, frame = fit_to_square(picture, self._side)
        outputs = self._run(self._input.arrange_colours(square))
        numbers = 5 + 3 * self._count
        if len(outputs) != 1 or outputs[0].ndim != 3 or outputs[0].shape[:2] != (1, numbers):
            expected = f"1 × {numbers} × boxes, for {self._count} points"
            raise contract_error("keypoints", expected, outputs)
        # One row for each box: the file has one column for each.
        rows = outputs[0][0].T
        rows = rows[np.flatnonzero(~(rows[:, 4] < least) & np.isfinite(rows).all(axis=1))]
        rows = np.clip(rows, -MOST_PLACE, MOST_PLACE)
        boxes = boxes_from_centres(rows[:, :4])
        poses: list[object] = []
        for row, _, score in kept_boxes(boxes, rows[:, 4:5], least, most=MOST_POSES):
            for box in as_picture_parts([(0, score, boxes[row])], frame):
                points = rows[row, 5:].reshape(-1, 3).astype(np.float64)
                points[:, 0] = (points[:, 0] - frame.left) / (frame.scale * frame.width)
                points[:, 1] = (points[:, 1] - frame.top) / (frame.scale * frame.height)
                outside = ((points[:, :2] < 0) | (points[:, :2] > 1)).any(axis=1)
                points[outside, 2] = 0
                poses.append((score, box[2:], np.clip(points, 0, 1).tolist()))
        return {"poses": poses}


def pose_things(scene: Poses, model: ObjectModel) -> list[Detection]:
    """Give things and their points as a detector would tell them: a point is a box of no size."""
    names = points_of(model)
    things = []
    for pose in scene.things:
        things.append(Detection(model.classes[0], pose.score, *pose.box))
        things += [
            # No surer than the thing that it is of.
            Detection(name, min(sure, pose.score), x, y, x, y)
            for name, (x, y, sure) in zip(names, pose.points, strict=False)
        ]
    return things


def detect_like(use: PictureModel) -> Detect:
    """Give what counts on a camera in a detector's words."""
    return Detect(confidence=use.confidence, hold=use.hold, zones=use.zones)


def measure_poses(
    scene: Poses, source: DetectionSource, model: ObjectModel, use: PictureModel
) -> float:
    """Count the things, or their points of one name, that are sure enough in an area."""
    detect = detect_like(use)
    return float(
        sum(
            counts_as(source, thing, detect)
            for thing in pose_things(scene, model)
            if thing.score >= use.confidence
        )
    )
