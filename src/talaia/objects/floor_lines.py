"""Where things stand: in a zone, on which side of a line, and how fast on the floor. Pure.

Places are parts of the picture, from the upper left, unless they are said to be metres.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["FloorMapping", "LineCounter", "is_inside"]

Point = tuple[float, float]
# So far beyond a line (parts of the picture's width) something must have gone to be on its other
# side: who stands on it sways, and so do the boxes of a detector.
_BESIDE = 0.008
# A track that was not seen for so long is forgotten (µs).
_FORGOTTEN_US = 15_000_000
_LEAST_W = 1e-9


def is_inside(polygon: Sequence[Point], point: Point) -> bool:
    """Tell whether a point lies in a polygon, by how often a ray to the right leaves it."""
    x, y = point
    inside = False
    for (x1, y1), (x2, y2) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) / (y2 - y1) * (x2 - x1):
            inside = not inside
    return inside


class _Side(NamedTuple):
    """On which side a track was seen last, where, and when."""

    side: int
    at: Point
    time_us: int


class LineCounter:
    """Counts who crosses a line of two points, or more.

    From its first point to its last, +1 is a crossing to the left of it as one sees it on the
    picture, and -1 one to the right.
    """

    def __init__(self, line: Sequence[Point]) -> None:
        """Have seen nobody yet."""
        self._line = [(float(x), float(y)) for x, y in line]
        # By track; forgotten some time after it was seen last.
        self._sides: dict[int, _Side] = {}

    def move_track(self, track: int, foot: Point, at_us: int) -> int:
        """Take where a track stands now.

        Returns:
            1 or -1 where it has just crossed, 0 where not.

        """
        for other in [
            one for one, last in self._sides.items() if at_us - last.time_us > _FORGOTTEN_US
        ]:
            del self._sides[other]
        side, apart = self._side_of(foot)
        last = self._sides.get(track)
        # Too near to tell: it is where it was.
        if apart < _BESIDE:
            if last is not None:
                self._sides[track] = last._replace(time_us=at_us)
            return 0
        self._sides[track] = _Side(side, foot, at_us)
        if last is None or last.side == side:
            return 0
        # Around its end is not across it.
        return side if self._is_crossed(last.at, foot) else 0

    def _side_of(self, point: Point) -> tuple[int, float]:
        """Give the side of the nearest piece, and how far it is."""
        best = (1, np.inf)
        for one, other in zip(self._line, self._line[1:], strict=False):
            along = (other[0] - one[0], other[1] - one[1])
            to = (point[0] - one[0], point[1] - one[1])
            length = max(along[0] ** 2 + along[1] ** 2, 1e-12)
            part = min(max((along[0] * to[0] + along[1] * to[1]) / length, 0.0), 1.0)
            apart = float(np.hypot(to[0] - part * along[0], to[1] - part * along[1]))
            if apart < best[1]:
                # Rows run downwards, so left of the way is negative here.
                best = (1 if along[0] * to[1] - along[1] * to[0] < 0 else -1, apart)
        return best

    def _is_crossed(self, one: Point, other: Point) -> bool:
        return any(
            _ways_cut(one, other, start, end)
            for start, end in zip(self._line, self._line[1:], strict=False)
        )


def _ways_cut(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Tell whether the way from a to b cuts the piece from c to d."""

    # Twice the area of a triangle: its sign says on which side of the way its third corner lies.
    def turned_side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return (turned_side(a, b, c) > 0) != (turned_side(a, b, d) > 0) and (
        turned_side(c, d, a) > 0
    ) != (turned_side(c, d, b) > 0)


class FloorMapping:
    """From the picture to the floor (m), by four points whose places are known (a homography)."""

    def __init__(self, picture: Sequence[Point], floor: Sequence[Point]) -> None:
        """Take four points on the picture, and where they are on the floor (m).

        Raises:
            ValueError: three of them lie on one line, or they are not four.

        """
        if len(picture) != 4 or len(floor) != 4:
            raise ValueError("expected four points")
        # Each point gives two equations for the eight unknown numbers of the homography; the ninth
        # is set to 1.
        rows, right = [], []
        for (x, y), (to_x, to_y) in zip(picture, floor, strict=True):
            rows += [
                [x, y, 1, 0, 0, 0, -x * to_x, -y * to_x],
                [0, 0, 0, x, y, 1, -x * to_y, -y * to_y],
            ]
            right += [to_x, to_y]
        table = np.array(rows, float)
        if np.linalg.cond(table) > 1e8:
            raise ValueError("three of the points lie on one line")
        self._matrix = np.append(np.linalg.solve(table, np.array(right, float)), 1).reshape(3, 3)
        middle = np.mean(np.array(picture, float), axis=0)
        # The floor ends at the horizon: beyond it this turns its sign.
        self._sign = 1.0 if self._weight(middle[0], middle[1]) > 0 else -1.0
        centre = np.mean(np.array(floor, float), axis=0)
        # Any factor gives the same points: this one keeps the sign of what is before the camera.
        back = np.linalg.inv(self._matrix)
        self._back = back if back[2] @ (centre[0], centre[1], 1) > 0 else -back

    def _weight(self, x: float, y: float) -> float:
        return float(self._matrix[2] @ (x, y, 1))

    def picture_matrix(self) -> NDArray[np.float64]:
        """Give the way back (3 × 3): from the floor (m) to parts of the picture.

        Its third row is above 0 for what lies before the camera.
        """
        return self._back

    def to_picture(
        self, x: NDArray[np.float64], y: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Say where points of the floor (m) are on the picture; NaN behind the camera."""
        across, down, w = (row[0] * x + row[1] * y + row[2] for row in self._back)
        before = np.where(w > _LEAST_W, w, np.nan)
        return across / before, down / before

    def to_floor(self, point: Point) -> Point | None:
        """Say where a point of the picture is on the floor (m); none above the horizon."""
        x, y, w = self._matrix @ (point[0], point[1], 1)
        if w * self._sign < _LEAST_W:
            return None
        return float(x / w), float(y / w)
