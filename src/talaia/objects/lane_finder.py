"""Where a vehicle stands between the two markings of a lane, from one picture. Pure.

The floor before the vehicle is looked at from above: of each point of a grid on the floor (REP-103:
x ahead, y to the left, of the vehicle) the picture has one pixel, by the camera's four known
points. A marking is a stripe that is lighter (or darker) than the floor on both of its sides. For
each heading in question the stripes are summed along it, and the pair of lines that is as far
apart as a lane is wide, and has the most of its length marked, is the lane.

It is the classical way (bird's-eye view, as in Bertozzi and Broggi, "GOLD", IEEE Transactions on
Image Processing 7(1), 1998), for straight pieces: of a bend it gives what is near.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.model.detection import LaneView
    from talaia.objects.floor_lines import FloorMapping

__all__ = ["LaneFinder", "LanePlace"]

# From point to point of the floor, ahead and across (m).
_AHEAD_M, _ACROSS_M = 0.05, 0.01
# A stripe differs from the floor beside it by at least this much of 255.
_CONTRAST = 12.0
# And by so many times what points of the floor usually differ by (median of it).
_ABOVE_USUAL = 5.0
# So much of both markings must be seen of what the camera looks at.
_LEAST_SEEN = 0.35
# Headings that are tried: as tangents, one after the other, and then finer about the best.
_STEEPEST, _SLOPES = 0.6, 49
# Points so far from a line (m) still belong to it when it is fitted.
_NEAR_M = 0.04


class LanePlace(NamedTuple):
    """Where the vehicle is in its lane.

    Attributes:
        offset: of the vehicle from the middle of the lane, to the left (m).
        heading: of the vehicle against the lane, counter-clockwise (rad).
        width: of the lane, from marking to marking (m).
        seen: how much of both markings was seen, 0 to 1.

    """

    offset: float
    heading: float
    width: float
    seen: float


class LaneFinder:
    """Looks for the lane on pictures of one size of one camera."""

    def __init__(self, view: LaneView, mapping: FloorMapping, size: tuple[int, int]) -> None:
        """Find out which pixels show the floor before the vehicle.

        Args:
            view: what is to be looked for.
            mapping: from picture to floor.
            size: of the pictures, rows and columns.

        """
        self._view = view
        near, far = view.ahead
        self._x = np.arange(near, far + _AHEAD_M / 2, _AHEAD_M)
        # The lane may begin where the vehicle stands, on either side of it.
        reach = view.widest + _STEEPEST * far
        self._y = np.arange(-reach, reach + _ACROSS_M / 2, _ACROSS_M)
        x, y = np.meshgrid(self._x, self._y, indexing="ij")
        across, down = mapping.to_picture(x, y)
        rows, columns = size
        with np.errstate(invalid="ignore"):
            self._column = np.nan_to_num(np.floor(across * columns), nan=-1).astype(np.int64)
            self._row = np.nan_to_num(np.floor(down * rows), nan=-1).astype(np.int64)
        self._on_picture = (
            (self._column >= 0) & (self._column < columns) & (self._row >= 0) & (self._row < rows)
        )
        self._column[~self._on_picture] = 0
        self._row[~self._on_picture] = 0

    def find_lane(self, rgb: NDArray[np.uint8]) -> LanePlace | None:
        """Find the lane.

        Args:
            rgb: rows × columns × 3, of the size that was said.

        Returns:
            None where no lane can be seen.

        """
        marked = self._find_stripes(rgb)
        if not marked.any():
            return None
        slope, left, right = self._best_pair(marked, np.linspace(-_STEEPEST, _STEEPEST, _SLOPES))
        step = 2 * _STEEPEST / (_SLOPES - 1)
        slope, left, right = self._best_pair(marked, np.linspace(slope - step, slope + step, 9))
        fitted = self._fit_lines(marked, slope, left, right)
        if fitted is None:
            return None
        slope, left, right, seen = fitted
        if seen < _LEAST_SEEN:
            return None
        # Lines are y = slope · x + c: across the lane, distances are shorter by the cosine.
        cosine = 1 / math.hypot(1.0, slope)
        return LanePlace(
            offset=-(left + right) / 2 * cosine,
            heading=-math.atan(slope),
            width=(left - right) * cosine,
            seen=seen,
        )

    def _find_stripes(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Tell for each point of the floor whether it is the middle of a stripe (1 or 0)."""
        grey = rgb[self._row, self._column].mean(axis=2, dtype=np.float32)
        if not self._view.light:
            grey = 255 - grey
        # Sums along a row, so that the mean of any piece is one difference.
        sums = np.cumsum(np.pad(grey, ((0, 0), (1, 0))), axis=1)
        wide = max(2, round(self._view.marking / _ACROSS_M))
        middle = _means(sums, 0, wide)
        # The floor beside it, as wide as the marking, half of that away.
        beside = wide // 2 + wide
        floor = np.maximum(_means(sums, -beside, wide), _means(sums, beside, wide))
        known = self._on_picture.astype(np.int64)
        counts = np.cumsum(np.pad(known, ((0, 0), (1, 0))), axis=1)
        whole = _means(counts, 0, 2 * beside + wide) >= 1
        differs = np.where(whole, middle - floor, 0.0)
        # Of a stripe only its middle: neighbours that differ less are its edges.
        peak = np.ones_like(whole)
        for by in range(1, wide // 2 + 1):
            peak[:, by:] &= differs[:, by:] >= differs[:, :-by]
            peak[:, :-by] &= differs[:, :-by] >= differs[:, by:]
        if not whole.any():
            return np.zeros_like(differs, np.float32)
        # Of a rough floor, or by night, everything differs a little: what stands out counts.
        usual = float(np.median(np.abs(differs[whole] - np.median(differs[whole]))))
        least = max(_CONTRAST, _ABOVE_USUAL * usual)
        return (peak & (differs > least)).astype(np.float32)

    def _best_pair(
        self, marked: NDArray[np.float32], slopes: NDArray[np.float64]
    ) -> tuple[float, float, float]:
        """Give slope, left and right line (y at x = 0) of the pair that has most of its length."""
        row, column = np.nonzero(marked)
        x, y = self._x[row], self._y[column]
        first = self._y[0] - _STEEPEST * self._x[-1]
        bins = int((self._y[-1] + _STEEPEST * self._x[-1] - first) / _ACROSS_M) + 2
        least = max(1, round(self._view.narrowest / _ACROSS_M))
        most = round(self._view.widest / _ACROSS_M)
        best = (-1.0, 0.0, 0.0, 0.0)
        for slope in slopes.tolist():
            place = np.rint((y - slope * x - first) / _ACROSS_M).astype(np.int64)
            found = np.bincount(np.clip(place, 0, bins - 1), minlength=bins).astype(np.float64)
            # Pixels far away are coarse: a line may be a centimetre beside itself.
            profile = np.convolve(found, [0.5, 1.0, 1.0, 1.0, 0.5], "same")
            for apart in range(least, most + 1):
                both = np.minimum(profile[:-apart], profile[apart:])
                at = int(both.argmax())
                if both[at] > best[0]:
                    right = first + at * _ACROSS_M
                    best = (float(both[at]), slope, right + apart * _ACROSS_M, right)
        return best[1:]

    def _fit_lines(
        self, marked: NDArray[np.float32], slope: float, left: float, right: float
    ) -> tuple[float, float, float, float] | None:
        """Fit two parallel lines to the stripes near them; with how much of them was seen."""
        row, column = np.nonzero(marked)
        x, y = self._x[row], self._y[column]
        columns: list[Any] = []
        values: list[Any] = []
        seen = 1.0
        # Rows whose stripe the camera could have seen on both sides.
        for side, at in enumerate((left, right)):
            near = np.abs(y - slope * x - at) < _NEAR_M
            if not near.any():
                return None
            where = np.rint((slope * self._x + at - self._y[0]) / _ACROSS_M).astype(np.int64)
            inside = (where >= 0) & (where < self._y.size)
            rows = np.arange(self._x.size)[inside]
            could = int(self._on_picture[rows, where[inside]].sum())
            seen = min(seen, len(np.unique(row[near])) / max(1, could))
            ones = np.ones(int(near.sum()))
            columns.append(np.stack([x[near], ones * (side == 0), ones * (side == 1)], axis=1))
            values.append(y[near])
        solved = np.linalg.lstsq(np.concatenate(columns), np.concatenate(values), rcond=None)[0]
        return float(solved[0]), float(solved[1]), float(solved[2]), seen


def _means(sums: NDArray[Any], shift: int, wide: int) -> NDArray[np.float64]:
    """Give the mean of ``wide`` points about each point, ``shift`` beside it; outside 0."""
    count = sums.shape[1] - 1
    low = np.arange(count) + shift - wide // 2
    high = low + wide
    inside = (low >= 0) & (high <= count)
    low, high = np.clip(low, 0, count), np.clip(high, 0, count)
    found = (sums[:, high] - sums[:, low]) / wide
    found[:, ~inside] = 0
    return np.asarray(found, np.float64)
