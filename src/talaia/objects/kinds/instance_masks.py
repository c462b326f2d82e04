"""Boxes with masks as YOLO-seg gives them, painted as a map of classes. Pure.

Of two outputs one has for each box its place, a score for each class, and the weights by which the
other's masks are added up: inside the box the sum is above zero where the thing is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.objects.boxes import MOST_PLACE, boxes_from_centres, kept_boxes
from talaia.objects.kinds.picture_grid import sample_places

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.objects.boxes import Letterbox

    Floats = NDArray[np.float32]

__all__ = ["paint_instances", "tells_instances"]


def tells_instances(outputs: Sequence[Floats], count: int) -> bool:
    """Tell whether outputs are boxes with masks for so many classes."""
    if len(outputs) != 2:
        return False
    told, masks = sorted(outputs, key=lambda output: output.ndim)
    return told.ndim == 3 and masks.ndim == 4 and told.shape[1] == 4 + count + masks.shape[1]


def paint_instances(
    outputs: Sequence[Floats],
    count: int,
    frame: Letterbox,
    *,
    side: int,
    least: float,
    none: int,
) -> NDArray[np.uint8]:
    """Give the class of each cell of the picture's grid, the surest on top."""
    told, masks = sorted(outputs, key=lambda output: output.ndim)
    # One row for each box: the file has one column for each.
    rows = told[0].T
    scores = rows[:, 4 : 4 + count]
    fine = np.flatnonzero(~(scores.max(axis=1) < least) & np.isfinite(rows).all(axis=1))
    boxes = boxes_from_centres(np.clip(rows[fine, :4], -MOST_PLACE, MOST_PLACE))
    weights = rows[fine, 4 + count :]
    height, width = masks.shape[2], masks.shape[3]
    down, across = sample_places(frame, side, (height, width))
    shown = masks[0][:, down, across]
    # The middles of the masks' cells, in pixels of the square.
    y, x = (down + 0.5) * side / height, (across + 0.5) * side / width
    cells = np.full(shown.shape[1:], none, np.uint8)
    for row, label, _ in reversed(kept_boxes(boxes, scores[fine], least)):
        left, top, right, bottom = boxes[row]
        within = (x >= left) & (x <= right) & (y >= top) & (y <= bottom)
        # Where a mask holds no number nothing is painted: NaN is not above zero.
        with np.errstate(over="ignore", invalid="ignore"):
            there = np.tensordot(weights[row], shown, 1) > 0
        cells[within & there] = label
    return cells
