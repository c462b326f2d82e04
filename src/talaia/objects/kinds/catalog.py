"""One row for each kind of model that tells no boxes. Everything else goes by this table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from talaia.model.detection import ModelKind
from talaia.objects.kinds.classification import (
    ClassificationReader,
    Likelihoods,
    measure_likelihoods,
)
from talaia.objects.kinds.depth import DepthMap, DepthReader, measure_depth
from talaia.objects.kinds.keypoints import KeypointReader, Poses, measure_poses
from talaia.objects.kinds.segmentation import ClassMap, SegmentationReader, measure_class_map

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from talaia.model.detection import DetectionSource, ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.objects.kinds.picture_input import InputSetting, Run

__all__ = ["KINDS", "KindContract", "Scene", "SceneReader"]

# What a model told of a picture.
Scene = ClassMap | Likelihoods | Poses | DepthMap


class SceneReader(Protocol):
    """What shows a picture to a file, and makes of its outputs a small answer."""

    def read_picture(self, picture: NDArray[np.uint8], least: float) -> dict[str, object]:
        """Give the answer: plain values, as JSON has them.

        Raises:
            DetectorError: the file gives something else than its kind does.

        """
        ...


class KindContract(NamedTuple):
    """What a kind is.

    Attributes:
        make_reader: of the file's setting, the names of its classes (or points), and its run.
        read_answer: makes a `Scene` of an answer of its reader.
        measure: gives what a signal tells of the scene; NaN where nothing can be told.

    """

    make_reader: Callable[[InputSetting, Sequence[str], Run], SceneReader]
    read_answer: Callable[[Mapping[str, Any]], Scene]
    measure: Callable[[Any, DetectionSource, ObjectModel, PictureModel], float]


KINDS: Mapping[ModelKind, KindContract] = {
    ModelKind.SEGMENTATION: KindContract(
        SegmentationReader, ClassMap.from_answer, measure_class_map
    ),
    ModelKind.CLASSIFICATION: KindContract(
        ClassificationReader, Likelihoods.from_answer, measure_likelihoods
    ),
    ModelKind.KEYPOINTS: KindContract(KeypointReader, Poses.from_answer, measure_poses),
    ModelKind.DEPTH: KindContract(DepthReader, DepthMap.from_answer, measure_depth),
}
