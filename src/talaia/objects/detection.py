"""What a detector told of a picture, in the names of its classes. Values only."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["LABEL_LETTERS", "Detection"]

# What the wire takes of a name.
LABEL_LETTERS = 200


class Detection(NamedTuple):
    """One thing on a picture; places are parts of its width and height, from the upper left."""

    # The class's name, not its number: numbers mean something else with another detector.
    label: str
    # 0 to 1, as the detector gives it.
    score: float
    left: float
    top: float
    right: float
    bottom: float
