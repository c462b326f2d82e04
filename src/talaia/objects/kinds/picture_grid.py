"""A picture as a grid of cells, on which maps of classes and of depth are kept small. Pure."""

from __future__ import annotations

import base64
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from talaia.model.detection import DetectionSource, PicturePoint
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.objects.boxes import Letterbox

__all__ = [
    "MOST_CELLS",
    "area_cells",
    "area_of",
    "grid_shape",
    "pack_grid",
    "sample_places",
    "unpack_grid",
]

# Cells along the picture's longer side.
MOST_CELLS = 160


def grid_shape(height: int, width: int) -> tuple[int, int]:
    """Give the rows and columns of a picture's grid; its cells are about square."""
    longest = max(height, width)
    return max(1, round(MOST_CELLS * height / longest)), max(1, round(MOST_CELLS * width / longest))


def sample_places(frame: Letterbox, side: int, output: tuple[int, int]) -> tuple[Any, Any]:
    """Give where the middles of the picture's cells lie in an output: rows (n × 1), columns (n).

    Args:
        frame: where the picture lies in the square that the model was shown.
        side: of that square (px).
        output: rows and columns of the output, which is of all the square.

    """
    rows, columns = grid_shape(frame.height, frame.width)

    def places(count: int, first: int, length: float, of: int) -> NDArray[np.intp]:
        at = (first + (np.arange(count) + 0.5) / count * length) / side * of
        return np.clip(at.astype(np.intp), 0, of - 1)

    down = places(rows, frame.top, frame.height * frame.scale, output[0])
    across = places(columns, frame.left, frame.width * frame.scale, output[1])
    return down[:, None], across


def area_of(source: DetectionSource, use: PictureModel, shape: tuple[int, int]) -> NDArray[np.bool]:
    """Give which cells of a grid a signal tells of."""
    zone = use.zones.get(source.zone) if source.zone else None
    if zone is not None:
        return area_cells(shape, zone.points)
    left, top, right, bottom = source.within or (0.0, 0.0, 1.0, 1.0)
    return area_cells(shape, ((left, top), (right, top), (right, bottom), (left, bottom)))


# The zones of some cameras: each is worked out once, and not for each picture.
@lru_cache(256)
def area_cells(shape: tuple[int, int], polygon: tuple[PicturePoint, ...]) -> NDArray[np.bool]:
    """Give which cells of a grid have their middle in a polygon; at least one has."""
    rows, columns = shape
    y = (np.arange(rows)[:, None] + 0.5) / rows
    x = (np.arange(columns) + 0.5) / columns
    inside = np.zeros(shape, np.bool)
    for (x1, y1), (x2, y2) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        if y1 == y2:
            continue
        crosses = (y1 > y) != (y2 > y)
        # Elsewhere it is of no use, and beyond all numbers for an edge that is all but level.
        along = np.divide(y - y1, y2 - y1, out=np.zeros_like(y), where=crosses)
        inside ^= crosses & (x < x1 + along * (x2 - x1))
    if not inside.any():
        # One that is smaller than a cell.
        middle_x, middle_y = (sum(part) / len(polygon) for part in zip(*polygon, strict=True))
        row, column = int(middle_y * rows), int(middle_x * columns)
        inside[min(row, rows - 1), min(column, columns - 1)] = True
    inside.flags.writeable = False
    return inside


def pack_grid(grid: NDArray[Any]) -> dict[str, object]:
    """Give a grid as an answer of the model's process has it."""
    data = base64.b64encode(np.ascontiguousarray(grid).tobytes()).decode("ascii")
    return {"rows": grid.shape[0], "columns": grid.shape[1], "data": data}


def unpack_grid(answer: Mapping[str, Any], kind: type[np.generic]) -> NDArray[Any]:
    """Read it back.

    Raises:
        ValueError: it is none, or too large.
        KeyError: something is missing.

    """
    rows, columns = int(answer["rows"]), int(answer["columns"])
    if not (0 < rows <= MOST_CELLS and 0 < columns <= MOST_CELLS):
        raise ValueError(f"a grid of {rows} × {columns}")
    return np.frombuffer(base64.b64decode(answer["data"]), kind).reshape(rows, columns)
