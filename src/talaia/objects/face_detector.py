"""Faces on pictures, by CenterFace: which numbers go in, and what comes out.

Pure but for the run itself, which is a function of one array. Of each cell of four by four pixels
the file tells how sure it is that a face's middle lies there, where in the cell, and how large the
face is (Xu et al. 2019, "CenterFace: Joint Face Detection and Alignment Using Face as Point",
https://arxiv.org/abs/1911.03599).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.objects.boxes import Box, as_picture_parts, fit_to_square, suppress_overlaps
from talaia.objects.errors import DetectorError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

__all__ = ["FACES", "MOST_FACES", "FaceDetector"]

FACES = ("face",)
# On one picture; of more not all would be told.
MOST_FACES = 1000
# Pixels from cell to cell, and of what the sides of a picture must be a multiple.
STEP, STRIDE = 4, 32
# Boxes that share more of their area than this are one face.
SAME_FACE = 0.3
# Its sides are told by their logarithms: none is larger than this many cells.
MOST_LOG = 10.0


class FaceDetector:
    """From a picture to the faces on it."""

    def __init__(self, side: int, run: Callable[[Floats], Sequence[Floats]]) -> None:
        """Show pictures with a longer side of ``side`` px, a multiple of 32.

        ``run`` takes 1 × 3 × rows × columns (RGB, 0 to 255) and gives the file's outputs.
        """
        self._side, self._run = side, run

    def detect_objects(self, picture: NDArray[np.uint8], least: float) -> list[Box]:
        """Find faces on a picture; see `Detector.detect_objects`.

        Raises:
            DetectorError: the file gives other numbers than CenterFace does.

        """
        # Two steps of 255 decide whether a face at the edge of being one is blurred.
        square, frame = fit_to_square(picture, self._side, exactly=True)
        # Grey above and below, or beside it, that is not needed is left out: it costs as much time
        # as the picture.
        rows = _needed(frame.top, round(frame.height * frame.scale), self._side)
        columns = _needed(frame.left, round(frame.width * frame.scale), self._side)
        shown = square[rows, columns].astype(np.float32)
        frame = frame._replace(top=frame.top - rows.start, left=frame.left - columns.start)
        outputs = self._run(np.ascontiguousarray(shown.transpose(2, 0, 1)[None]))
        sure, boxes = _read_outputs(outputs, (shown.shape[0] // STEP, shown.shape[1] // STEP))
        found = suppress_overlaps(boxes, sure, least, same=SAME_FACE, most=MOST_FACES)
        return as_picture_parts(found, frame)


def _needed(first: int, count: int, side: int) -> slice:
    """Give the part of the square's side that has the picture, in whole strides."""
    size = min(side, -(-max(count, 1) // STRIDE) * STRIDE)
    begin = min(max(0, first - (size - count) // 2), side - size)
    return slice(begin, begin + size)


def _read_outputs(outputs: Sequence[Floats], cells: tuple[int, int]) -> tuple[Floats, Floats]:
    """Give how sure each cell is (n × 1), and its box's corners (n × 4, px)."""
    shapes = [output.shape for output in outputs]
    if len(shapes) < 3 or shapes[:3] != [(1, 1, *cells), (1, 2, *cells), (1, 2, *cells)]:
        told = ", ".join(" × ".join(map(str, shape)) for shape in shapes)
        raise DetectorError(
            f"CenterFace gives sureness, sizes and places for {cells[0]} × {cells[1]} cells; this "
            f"file gives {told or 'nothing'}: it is another one"
        )
    sure, sizes, places = (output[0] for output in outputs[:3])
    high, wide = np.exp(np.minimum(sizes, MOST_LOG)) * STEP
    row, column = np.indices(cells, np.float32)
    y, x = (row + places[0] + 0.5) * STEP, (column + places[1] + 0.5) * STEP
    boxes = np.stack([x - wide / 2, y - high / 2, x + wide / 2, y + high / 2], axis=-1)
    return sure.reshape(-1, 1), boxes.reshape(-1, 4)
