"""What a model told of a picture as it goes to the pages that look: small enough for any line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from talaia.model.detection import DepthScale
from talaia.objects.kinds.classification import Likelihoods
from talaia.objects.kinds.depth import DepthMap, depth_ends, nearness_of
from talaia.objects.kinds.keypoints import Poses
from talaia.objects.kinds.segmentation import NO_CLASS, ClassMap
from talaia.wire.frames import MAX_OVERLAY_RUNS, ClassLikelihood, DetectedPose, OverlayLayer

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.model.detection import ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.objects.kinds.catalog import Scene
    from talaia.objects.kinds.keypoints import Pose

__all__ = ["layer_of", "runs_of"]

# Steps of nearness, and how many likely classes are named.
_STEPS, _MOST_LIKELY = 16, 3
_LONGEST_RUN = 255
_NOTHING = OverlayLayer(rows=0, columns=0, runs=b"", near=None, far=None, poses=[], likely=[])


def layer_of(scene: Scene, model: ObjectModel, use: PictureModel) -> OverlayLayer:
    """Give what is drawn of a scene."""
    match scene:
        case ClassMap(cells):
            return _map_layer(cells)
        case DepthMap():
            near = nearness_of(scene, model.scale)
            # The middle of what is rounded away is no number.
            steps = np.nan_to_num(near * (_STEPS - 1), nan=NO_CLASS).round().astype(np.uint8)
            ends = depth_ends(scene, model.scale) if model.scale is DepthScale.METRES else None
            return _map_layer(steps, ends)
        case Poses(things):
            sure = [pose for pose in things if pose.score >= use.confidence]
            return structs.replace(_NOTHING, poses=[_pose_message(pose) for pose in sure])
        case Likelihoods(shares):
            order = sorted(range(len(shares)), key=shares.__getitem__, reverse=True)
            named = [number for number in order[:_MOST_LIKELY] if number < len(model.classes)]
            likely = [
                ClassLikelihood(label=model.classes[number], share=shares[number])
                for number in named
            ]
            return structs.replace(_NOTHING, likely=likely)


def _pose_message(pose: Pose) -> DetectedPose:
    left, top, right, bottom = pose.box
    return DetectedPose(
        score=pose.score,
        left=left,
        top=top,
        right=right,
        bottom=bottom,
        points=list(pose.points),
    )


def _map_layer(cells: NDArray[np.uint8], ends: tuple[float, float] | None = None) -> OverlayLayer:
    near, far = ends or (None, None)
    runs = runs_of(cells)
    while len(runs) > MAX_OVERLAY_RUNS:
        # As ragged as noise: every second cell says as much to a person.
        cells = cells[::2, ::2]
        runs = runs_of(cells)
    rows, columns = cells.shape
    return structs.replace(_NOTHING, rows=rows, columns=columns, runs=runs, near=near, far=far)


def runs_of(cells: NDArray[np.uint8]) -> bytes:
    """Give cells row by row as pairs of bytes: how many, and of what."""
    flat = cells.ravel()
    begins = np.flatnonzero(np.concatenate([[True], flat[1:] != flat[:-1]]))
    lengths = np.diff(np.append(begins, flat.size))
    pieces = -(-lengths // _LONGEST_RUN)
    counts = np.full(int(pieces.sum()), _LONGEST_RUN, np.uint8)
    # The last piece of each run has what is left.
    counts[np.cumsum(pieces) - 1] = lengths - (pieces - 1) * _LONGEST_RUN
    return np.stack([counts, np.repeat(flat[begins], pieces)], axis=1).tobytes()
