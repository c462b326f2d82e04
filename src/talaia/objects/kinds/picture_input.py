"""What a model is shown: a square of a picture, its colours as the file wants them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.objects.errors import DetectorError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float32]
    Run = Callable[[Floats], Sequence[NDArray[np.float32]]]

__all__ = ["InputSetting", "PictureInput", "contract_error", "shapes_text"]


class InputSetting(NamedTuple):
    """What a model wants to be shown.

    Attributes:
        side: of the square (px).
        mean: taken from each colour, 0 to 255, in the order in which they are given.
        spread: each colour is divided by it then.
        blue_first: BGR instead of RGB.

    """

    side: int
    mean: tuple[float, ...] = (0.0, 0.0, 0.0)
    spread: tuple[float, ...] = (255.0, 255.0, 255.0)
    blue_first: bool = False


class PictureInput:
    """Arranges a square's pixels."""

    def __init__(self, setting: InputSetting) -> None:
        """Arrange them as ``setting`` says."""
        self._blue_first = setting.blue_first
        factor = 1 / np.array(setting.spread, np.float32)
        # One for each colour's rows and columns.
        self._factor = factor[:, None, None]
        self._offset = (np.array(setting.mean, np.float32) * factor)[:, None, None]

    def arrange_colours(self, square: NDArray[np.uint8]) -> Floats:
        """Give 1 × 3 × side × side of a square (side × side × 3, RGB)."""
        # Rows × columns × colours to colours × rows × columns, as models are exported; before they
        # are made floats, which is four times as much.
        colours = square.transpose(2, 0, 1)
        planes = np.ascontiguousarray(colours[::-1] if self._blue_first else colours)
        shown = planes.astype(np.float32)
        shown *= self._factor
        shown -= self._offset
        return shown[None]


def shapes_text(outputs: Sequence[NDArray[np.float32]]) -> str:
    """Give the shapes of a file's outputs, for people."""
    return ", ".join(" × ".join(map(str, output.shape)) for output in outputs) or "nothing"


def contract_error(
    kind: str, expected: str, outputs: Sequence[NDArray[np.float32]]
) -> DetectorError:
    """Say what a model of a kind gives, and what this file gives instead."""
    return DetectorError(
        f"a model of the kind {kind} gives {expected}; this file gives {shapes_text(outputs)}: "
        "choose another kind, or correct its list of classes or points"
    )
