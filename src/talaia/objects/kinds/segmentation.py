"""Segmentation: which class each part of a picture is. Pure but for the run itself.

The contract is what DeepLab, SegFormer, U-Net and YOLO-seg give when they are exported: scores
(1 × classes × rows × columns) of all the square that was shown, or the number of each cell's class
(1 × rows × columns, or 1 × 1 × rows × columns), or boxes with masks (`instance_masks`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from talaia.model.detection import Measured
from talaia.objects.boxes import fit_to_square
from talaia.objects.kinds.instance_masks import paint_instances, tells_instances
from talaia.objects.kinds.picture_grid import area_of, pack_grid, sample_places, unpack_grid
from talaia.objects.kinds.picture_input import PictureInput, contract_error

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.model.detection import DetectionSource, ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.objects.boxes import Letterbox
    from talaia.objects.kinds.picture_input import InputSetting, Run

__all__ = ["NO_CLASS", "UNKNOWN", "ClassMap", "SegmentationReader", "measure_class_map"]

# A cell that is none of the classes, and one of which the file gives no number.
NO_CLASS, UNKNOWN = 255, 254
# Of an area at least this part must be known.
_KNOWN = 0.75
# Of a row or column of an area, a class has it if it covers so much.
_COVERS = 0.5


class ClassMap(NamedTuple):
    """The number of the class in each cell of the picture's grid; or `NO_CLASS`, or `UNKNOWN`."""

    cells: NDArray[np.uint8]

    @classmethod
    def from_answer(cls, answer: Mapping[str, Any]) -> ClassMap:
        """Read an answer of the model's process; raises ValueError or KeyError for none."""
        return cls(unpack_grid(answer, np.uint8))


class SegmentationReader:
    """From a picture to the class of each of its cells."""

    def __init__(self, setting: InputSetting, labels: Sequence[str], run: Run) -> None:
        """Use ``run``, which takes 1 × 3 × side × side and gives the file's outputs."""
        self._side, self._count, self._run = setting.side, len(labels), run
        self._input = PictureInput(setting)

    def read_picture(self, picture: NDArray[np.uint8], least: float) -> dict[str, object]:
        """Give the class of each cell; of instances those are left out that are less sure.

        Raises:
            DetectorError: the file gives something else than a segmentation.

        """
        square, frame = fit_to_square(picture, self._side)
        outputs = self._run(self._input.arrange_colours(square))
        return pack_grid(self._decode_outputs(outputs, frame, least))

    def _decode_outputs(
        self, outputs: Sequence[NDArray[np.float32]], frame: Letterbox, least: float
    ) -> NDArray[np.uint8]:
        if tells_instances(outputs, self._count):
            return paint_instances(
                outputs, self._count, frame, side=self._side, least=least, none=NO_CLASS
            )
        for output in outputs:
            if output.ndim not in (3, 4) or not output.size:
                continue
            *before, rows, columns = output.shape
            down, across = sample_places(frame, self._side, (rows, columns))
            # Others beside it are of training, as torchvision's "aux".
            if before == [1, self._count]:
                # One axis after the other: both at once take longer.
                scores = output[0].take(down[:, 0], axis=1).take(across, axis=2)
                # The greatest of numbers with NaN among them is NaN.
                unknown = np.isnan(scores.max(axis=0))
                return _as_cells(np.where(unknown, UNKNOWN, scores.argmax(axis=0)))
            if before in ([1], [1, 1]):
                chosen = output.reshape(rows, columns)[down, across]
                whole = chosen == np.floor(chosen)
                if not (whole | np.isnan(chosen)).all():
                    # How likely one class is, say; which part of it is enough nobody has said.
                    break
                known = whole & (chosen >= 0) & (chosen < self._count)
                return _as_cells(
                    np.where(np.isnan(chosen), UNKNOWN, np.where(known, chosen, NO_CLASS))
                )
        raise contract_error(
            "segmentation",
            f"1 × {self._count} × rows × columns of scores for {self._count} classes, or "
            "1 × rows × columns of whole class numbers, or boxes and masks as YOLO does",
            outputs,
        )


def _as_cells(numbers: NDArray[Any]) -> NDArray[np.uint8]:
    return numbers.astype(np.uint8)


def measure_class_map(
    scene: ClassMap, source: DetectionSource, model: ObjectModel, use: PictureModel
) -> float:
    """Give what a signal tells of it (%); NaN where that is unknown, or the class has no edge."""
    area = area_of(source, use, (scene.cells.shape[0], scene.cells.shape[1]))
    known = area & (scene.cells != UNKNOWN)
    if known.sum() < _KNOWN * area.sum():
        return float("nan")
    covered = (scene.cells == model.classes.index(source.sees)) & area
    if source.measure is Measured.SHARE:
        return float(100 * covered.sum() / known.sum())
    if source.measure is Measured.AHEAD:
        of_row = area.sum(axis=1)
        there = of_row > 0
        # From the nearest row on; the first that is not the class's own ends it.
        has = (covered.sum(axis=1)[there] >= _COVERS * of_row[there])[::-1]
        return float(100 * (has.argmin() if not has.all() else has.size) / has.size)
    of_column = area.sum(axis=0)
    columns = np.flatnonzero((of_column > 0) & (covered.sum(axis=0) >= _COVERS * of_column))
    if not columns.size:
        return float("nan")
    at = columns[0] if source.measure is Measured.LEFT_EDGE else columns[-1] + 1
    return float(100 * at / area.shape[1])
