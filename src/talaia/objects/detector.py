"""A detector in an ONNX file: which numbers go in, and what comes out.

Pure but for the run itself, which is a function of one array.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.objects.boxes import (
    Box,
    as_picture_parts,
    boxes_from_centres,
    boxes_from_distances,
    fit_to_square,
    suppress_overlaps,
)
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.picture_input import InputSetting, PictureInput, shapes_text

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

__all__ = ["NANODET", "Detector", "OutputFormat", "Setting"]


class OutputFormat(StrEnum):
    """How a detector tells its boxes.

    Attributes:
        NANODET: for each of three steps a score for each class, and distances as distributions.
        YOLO: one array of (4 + classes) × boxes, each by centre and size in pixels of the square,
            as YOLOv8 and its successors give.

    """

    NANODET = "nanodet"
    YOLO = "yolo"


class Setting(NamedTuple):
    """What a detector wants to be shown.

    Attributes:
        kind: see `OutputFormat`.
        side: of the square (px).
        mean: taken from each colour, 0 to 255, in the order in which they are given.
        spread: each colour is divided by it then.
        blue_first: BGR instead of RGB.

    """

    kind: OutputFormat
    side: int
    mean: tuple[float, ...] = (0.0, 0.0, 0.0)
    spread: tuple[float, ...] = (255.0, 255.0, 255.0)
    blue_first: bool = False


# The normalisation of NanoDet's own configuration: https://github.com/RangiLyu/nanodet.
NANODET = Setting(
    OutputFormat.NANODET, 416, (103.53, 116.28, 123.675), (57.375, 57.12, 58.395), blue_first=True
)
# Pixels of the square from cell to cell, in each of NanoDet's three grids.
STEPS = (8, 16, 32)


class Detector:
    """From a picture to the things on it."""

    def __init__(
        self,
        setting: Setting,
        classes: Sequence[str],
        run: Callable[[NDArray[np.float32]], Sequence[NDArray[np.float32]]],
    ) -> None:
        """Use ``run``, which takes 1 × 3 × side × side and gives the file's outputs."""
        # What does not change while the detector lives; an instance keeps nothing from picture to
        # picture.
        self._setting, self._classes, self._run = setting, classes, run
        self._input = PictureInput(InputSetting(*setting[1:]))

    def detect_objects(self, picture: NDArray[np.uint8], least: float) -> list[Box]:
        """Find things on a picture.

        Args:
            picture: height × width × 3, RGB.
            least: what is less sure (0 to 1) is left out.

        Raises:
            DetectorError: the file gives other numbers than its setting says.

        """
        square, frame = fit_to_square(picture, self._setting.side)
        shown = self._input.arrange_colours(square)
        boxes, scores = self._decode_outputs(self._run(shown), least)
        return as_picture_parts(suppress_overlaps(boxes, scores, least), frame)

    def _decode_outputs(
        self, outputs: Sequence[NDArray[np.float32]], least: float
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Give boxes and scores of what is sure enough for any class, and perhaps of more."""
        if self._setting.kind is OutputFormat.YOLO:
            return self._read_yolo(outputs, least)
        side, count = self._setting.side, len(self._classes)
        # Outputs are known by their shapes: their names and order differ from export to export.
        by_cells: dict[int, dict[bool, NDArray[np.float32]]] = {}
        for output in outputs:
            if output.ndim == 3:
                by_cells.setdefault(output.shape[1], {})[output.shape[2] == count] = output[0]
        heads = [by_cells.get((-(-side // step)) ** 2, {}) for step in STEPS]
        if any(set(head) != {True, False} for head in heads):
            raise self._shape_error("scores and distances for each cell of three grids", outputs)
        # Of thousands of cells a few see something: only they are worth a softmax.
        chosen = [_sure_rows(head[True], least) for head in heads]
        return (
            np.concatenate(
                [
                    boxes_from_distances(head[False][cells], side, step, cells)
                    for head, step, cells in zip(heads, STEPS, chosen, strict=True)
                ]
            ),
            np.concatenate([head[True][cells] for head, cells in zip(heads, chosen, strict=True)]),
        )

    def _read_yolo(
        self, outputs: Sequence[NDArray[np.float32]], least: float
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        count = len(self._classes)
        if len(outputs) != 1 or outputs[0].ndim != 3 or outputs[0].shape[1] != 4 + count:
            raise self._shape_error(f"1 × {4 + count} × boxes, for {count} classes", outputs)
        # One row for each box: the file has one column for each.
        told = outputs[0][0].T
        told = told[_sure_rows(told[:, 4:], least)]
        return boxes_from_centres(told[:, :4]), told[:, 4:]

    def _shape_error(self, expected: str, outputs: Sequence[NDArray[np.float32]]) -> DetectorError:
        return DetectorError(
            f"a detector of the kind {self._setting.kind.value} gives {expected}; "
            f"this file gives {shapes_text(outputs)}: choose another kind or list of classes"
        )


def _sure_rows(scores: NDArray[np.float32], least: float) -> NDArray[np.intp]:
    """Give the rows that may hold a score of at least that; one with NaN among them may."""
    return np.flatnonzero(~(scores.max(axis=1) < least))
