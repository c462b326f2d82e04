"""Depth: how far each part of a picture is. Pure but for the run itself.

The contract is what MiDaS, Depth Anything and their kin give when they are exported: one output of
1 × rows × columns, or 1 × 1 × rows × columns, of all the square that was shown. Its numbers are
metres, or larger the nearer something is, in no unit: of those only what is nearer on the same
picture can be told.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from talaia.model.detection import DepthScale
from talaia.objects.boxes import fit_to_square
from talaia.objects.kinds.picture_grid import area_of, pack_grid, sample_places, unpack_grid
from talaia.objects.kinds.picture_input import PictureInput, contract_error

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.model.detection import DetectionSource, ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.objects.kinds.picture_input import InputSetting, Run

__all__ = ["DepthMap", "DepthReader", "depth_ends", "measure_depth", "nearness_of"]

# The nearest is that to which so much of an area (%) is nearer: one cell alone is noise.
_NEAREST = 2.0
# A picture's own range leaves out so much (%) at either end.
_BEYOND = 2.0
# Of an area at least this part must be known.
_KNOWN = 0.25


class DepthMap(NamedTuple):
    """A number for each cell of the picture's grid; NaN where nothing is known."""

    cells: NDArray[np.float32]

    @classmethod
    def from_answer(cls, answer: Mapping[str, Any]) -> DepthMap:
        """Read an answer of the model's process; raises ValueError or KeyError for none."""
        return cls(unpack_grid(answer, np.float32))


class DepthReader:
    """From a picture to a number for each of its cells."""

    def __init__(self, setting: InputSetting, _labels: Sequence[str], run: Run) -> None:
        """Use ``run``, which takes 1 × 3 × side × side and gives the file's outputs."""
        self._side, self._run = setting.side, run
        self._input = PictureInput(setting)

    def read_picture(self, picture: NDArray[np.uint8], _least: float) -> dict[str, object]:
        """Give the number of each cell.

        Raises:
            DetectorError: the file gives something else than a map.

        """
        square, frame = fit_to_square(picture, self._side)
        outputs = self._run(self._input.arrange_colours(square))
        if len(outputs) != 1 or outputs[0].shape[:-2] not in ((1,), (1, 1)) or not outputs[0].size:
            expected = "1 × rows × columns, or 1 × 1 × rows × columns"
            raise contract_error("depth", expected, outputs)
        *_, rows, columns = outputs[0].shape
        told = outputs[0].reshape(rows, columns)
        cells = told[sample_places(frame, self._side, (rows, columns))].astype(np.float32)
        cells[~np.isfinite(cells)] = np.nan
        return pack_grid(cells)


def depth_ends(scene: DepthMap, scale: DepthScale) -> tuple[float, float] | None:
    """Give the nearest and the farthest number of the picture; none where nothing differs."""
    known = _known_cells(scene.cells, scale)
    if not known.size:
        return None
    low, high = (float(end) for end in np.percentile(known, [_BEYOND, 100 - _BEYOND]))
    if low == high:
        return None
    return (low, high) if scale is DepthScale.METRES else (high, low)


def nearness_of(scene: DepthMap, scale: DepthScale) -> NDArray[np.float32]:
    """Give how near each cell is in the picture's own range, 0 to 1; NaN where nothing is known."""
    ends = depth_ends(scene, scale)
    if ends is None:
        return np.full(scene.cells.shape, np.nan, np.float32)
    near, far = ends
    found = np.clip((scene.cells.astype(np.float64) - far) / (near - far), 0, 1)
    if scale is DepthScale.METRES:
        found = np.where(scene.cells > 0, found, np.nan)
    return np.asarray(found, np.float32)


def _known_cells(cells: NDArray[np.float32], scale: DepthScale) -> NDArray[np.float64]:
    """Give what is known of cells; a distance of nothing or less is none."""
    known = cells[np.isfinite(cells)].astype(np.float64)
    return known[known > 0] if scale is DepthScale.METRES else known


def measure_depth(
    scene: DepthMap, source: DetectionSource, model: ObjectModel, use: PictureModel
) -> float:
    """Give how near the nearest in an area is: metres, or % of the picture's own range."""
    area = area_of(source, use, (scene.cells.shape[0], scene.cells.shape[1]))
    metres = model.scale is DepthScale.METRES
    cells = scene.cells if metres else nearness_of(scene, model.scale)
    known = _known_cells(cells[area], model.scale)
    if known.size < max(1.0, _KNOWN * area.sum()):
        return float("nan")
    if metres:
        return float(np.percentile(known, _NEAREST))
    return float(100 * np.percentile(known, 100 - _NEAREST))
