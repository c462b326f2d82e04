"""The house as a map of occupied cells, at the height of the lidar. Pure.

As a finished mapping run would have left it: what is solid there is occupied, the rest is free.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.sim.vehicle.scene import Hull

__all__ = ["RESOLUTION", "FloorMap", "draw_map"]

RESOLUTION = 0.05
"""Side of a cell (m)."""
_MARGIN = 0.5
_OCCUPIED = 100


class FloorMap(NamedTuple):
    """Cells by rows, the first row at the smallest y, as ``nav_msgs/msg/OccupancyGrid`` has them.

    Attributes:
        x: of the first cell's corner (m).
        y: see above.
        cells: 0 (free) or 100 (occupied).

    """

    x: float
    y: float
    cells: npt.NDArray[np.int8]


def draw_map(hulls: Iterable[Hull], height: float) -> FloorMap:
    """Draw what is solid at ``height`` (m)."""
    cut = [hull for hull in hulls if abs(hull.centre[2] - height) <= hull.half[2]]
    reaches = [math.hypot(hull.half[0], hull.half[1]) for hull in cut]
    low = [
        min((h.centre[axis] - reach for h, reach in zip(cut, reaches, strict=True)), default=0.0)
        - _MARGIN
        for axis in (0, 1)
    ]
    high = [
        max((h.centre[axis] + reach for h, reach in zip(cut, reaches, strict=True)), default=0.0)
        + _MARGIN
        for axis in (0, 1)
    ]
    columns, rows = (math.ceil((high[axis] - low[axis]) / RESOLUTION) for axis in (0, 1))
    xs = low[0] + (np.arange(columns) + 0.5) * RESOLUTION
    ys = low[1] + (np.arange(rows) + 0.5) * RESOLUTION
    x, y = np.meshgrid(xs, ys)
    cells = np.zeros((rows, columns), dtype=np.int8)
    # A cell that a thin wall passes through is occupied, too.
    slack = RESOLUTION / 2
    for hull in cut:
        across, along = x - hull.centre[0], y - hull.centre[1]
        c, s = math.cos(hull.yaw), math.sin(hull.yaw)
        forward, left = c * across + s * along, c * along - s * across
        if hull.round:
            inside = np.hypot(across, along) <= hull.half[0] + slack
        else:
            inside = (abs(forward) <= hull.half[0] + slack) & (abs(left) <= hull.half[1] + slack)
        cells[inside] = _OCCUPIED
    return FloorMap(low[0], low[1], cells)
