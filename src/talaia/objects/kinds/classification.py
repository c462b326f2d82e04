"""Classification: how likely each class is of all the picture. Pure but for the run itself.

The contract is what torchvision, timm and YOLO-cls give: one number for each class (1 × classes),
either scores, which go through a softmax, or probabilities, which add up to one. The file is shown
the middle square of the picture, as those are trained.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from talaia.model.detection import Measured
from talaia.objects.boxes import fit_to_square
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.picture_input import PictureInput, contract_error

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.model.detection import DetectionSource, ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.objects.kinds.picture_input import InputSetting, Run

__all__ = ["ClassificationReader", "Likelihoods", "measure_likelihoods"]

# Probabilities add up to one, as near as 16 bits have them.
_NEAR_ONE = 0.01


class Likelihoods(NamedTuple):
    """How likely each class is, 0 to 1, in the file's order."""

    shares: tuple[float, ...]

    @classmethod
    def from_answer(cls, answer: Mapping[str, Any]) -> Likelihoods:
        """Read an answer of the model's process; raises ValueError or KeyError for none."""
        shares = tuple(min(max(float(share), 0.0), 1.0) for share in answer["shares"])
        if not shares:
            raise ValueError("no class")
        return cls(shares)

    def likeliest(self) -> int:
        """Give the number of the likeliest class."""
        return max(range(len(self.shares)), key=self.shares.__getitem__)


class ClassificationReader:
    """From a picture to how likely each class is."""

    def __init__(self, setting: InputSetting, labels: Sequence[str], run: Run) -> None:
        """Use ``run``, which takes 1 × 3 × side × side and gives the file's outputs."""
        self._side, self._count, self._run = setting.side, len(labels), run
        self._input = PictureInput(setting)

    def read_picture(self, picture: NDArray[np.uint8], _least: float) -> dict[str, object]:
        """Give how likely each class is.

        Raises:
            DetectorError: the file gives something else than one finite number for each class.

        """
        height, width = picture.shape[:2]
        size = min(height, width)
        top, left = (height - size) // 2, (width - size) // 2
        square, _ = fit_to_square(picture[top : top + size, left : left + size], self._side)
        outputs = self._run(self._input.arrange_colours(square))
        if not outputs or outputs[0].shape not in (
            (1, self._count),
            (1, self._count, 1, 1),
        ):
            expected = f"1 × {self._count}, a number for each of {self._count} classes"
            raise contract_error("classification", expected, outputs)
        told = outputs[0].reshape(self._count).astype(np.float64)
        if not np.isfinite(told).all():
            raise DetectorError("this file gives no finite number for each of its classes")
        return {"shares": _as_probabilities(told).tolist()}


def _as_probabilities(told: NDArray[np.float64]) -> NDArray[np.float64]:
    if told.min() >= 0 and abs(told.sum() - 1) < _NEAR_ONE:
        return told
    # The greatest is taken off first, so that `exp` cannot overflow.
    raised = np.exp(told - told.max())
    return np.asarray(raised / raised.sum(), np.float64)


def measure_likelihoods(
    scene: Likelihoods, source: DetectionSource, model: ObjectModel, use: PictureModel
) -> float:
    """Give how likely a class is (%), or the number of the likeliest; NaN where none is enough."""
    if len(scene.shares) != len(model.classes):
        return float("nan")
    if source.measure is Measured.PROBABILITY:
        return 100 * scene.shares[model.classes.index(source.sees)]
    best = scene.likeliest()
    return float(best) if scene.shares[best] >= use.confidence else float("nan")
