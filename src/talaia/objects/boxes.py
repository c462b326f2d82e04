"""Boxes around things: what a detector's numbers mean, and which of many boxes are one thing.

Pure: arrays in, arrays out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

__all__ = [
    "MOST_PLACE",
    "Box",
    "Letterbox",
    "as_picture_parts",
    "boxes_from_centres",
    "boxes_from_distances",
    "fit_to_square",
    "kept_boxes",
    "suppress_overlaps",
]

# Boxes of one class that share more of their area than this are one thing.
SAME = 0.5
# Places of a broken file may be any numbers (px); so far from the square all are as far, and their
# products still fit 32 bits.
MOST_PLACE = 1e6
# A picture that shows more than this is a picture of a crowd; the surest are told.
MOST = 100


class Box(NamedTuple):
    """One thing on a picture; places are parts of its width and height, from the upper left."""

    # Index into the detector's list of classes.
    label: int
    # What the detector gave after its own sigmoid, 0 to 1.
    score: float
    left: float
    top: float
    right: float
    bottom: float


class Letterbox(NamedTuple):
    """Where a picture lies in the square that the detector is shown.

    Attributes:
        scale: the square's pixels for one of the picture's.
        left, top: the square's pixels before the picture begins.
        width, height: of the picture (px).

    """

    scale: float
    left: int
    top: int
    width: int
    height: int


def fit_to_square(
    picture: NDArray[np.uint8], side: int, *, exactly: bool = False
) -> tuple[NDArray[np.uint8], Letterbox]:
    """Fit a picture into a square as wide as ``side``, grey around it, its shape kept.

    Args:
        picture: height × width × 3.
        side: of the square (px).
        exactly: each pixel is rounded once, which takes seven times as long; else it may be two
            steps off.

    Returns:
        side × side × 3, and where the picture lies in it. Pixels are interpolated linearly, which
        is what the detectors were trained on.

    """
    height, width = picture.shape[:2]
    scale = side / max(width, height)
    new_height, new_width = max(1, round(height * scale)), max(1, round(width * scale))
    top, left = (side - new_height) // 2, (side - new_width) // 2
    # 114 is the grey that YOLO pads with when it is trained.
    square = np.full((side, side, 3), 114, np.uint8)
    place = np.s_[top : top + new_height, left : left + new_width]
    if exactly:
        square[place] = _interpolate_exactly(picture, new_height, new_width)
        return square, Letterbox(scale, left, top, width, height)
    first, second, part = _linear_weights(height, new_height)
    lines = _mix(picture[first], picture[second], part[:, None, None])
    first, second, part = _linear_weights(width, new_width)
    # As rows of bytes: of the third axis NumPy would make a loop of three.
    flat, colours = lines.reshape(new_height, width * 3), np.arange(3)
    shown = _mix(
        flat.take((first[:, None] * 3 + colours).ravel(), axis=1),
        flat.take((second[:, None] * 3 + colours).ravel(), axis=1),
        np.repeat(part, 3)[None, :],
    )
    square[place] = shown.reshape(new_height, -1, 3)
    return square, Letterbox(scale, left, top, width, height)


def _neighbours(old: int, new: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats]:
    """Between which two pixels each new one lies, and how far; centres lie on centres."""
    # The centre of new pixel k lies at k + 1/2; half a pixel off would move every box.
    at = (np.arange(new) + 0.5) * old / new - 0.5
    at = np.clip(at, 0, old - 1)
    low = np.floor(at).astype(np.intp)
    return low, np.minimum(low + 1, old - 1), (at - low).astype(np.float32)


def _linear_weights(
    old: int, new: int
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.uint16]]:
    """Give the same with how far as a part of 256."""
    low, high, part = _neighbours(old, new)
    return low, high, np.rint(part * 256).astype(np.uint16)


def _interpolate_exactly(picture: NDArray[np.uint8], rows: int, columns: int) -> Floats:
    """Interpolate linearly, rounded to whole numbers at the end."""
    above, below, down = _neighbours(picture.shape[0], rows)
    left, right, across = _neighbours(picture.shape[1], columns)
    # As floats: a difference of two bytes would wrap around below zero.
    upper = picture[above].astype(np.float32)
    lines = upper + (picture[below] - upper) * down[:, None, None]
    first = lines[:, left]
    return np.rint(first + (lines[:, right] - first) * across[None, :, None])


def _mix(
    first: NDArray[np.uint8], second: NDArray[np.uint8], part: NDArray[np.uint16]
) -> NDArray[np.uint8]:
    """Give what lies between two pictures, ``part`` of 256 from the first to the second."""
    # In sixteen bits, a quarter of the time of floats: 255 · 256 + 128 just fits.
    both = first.astype(np.uint16)
    both *= 256 - part
    other = second.astype(np.uint16)
    other *= part
    both += other
    both += 128
    both >>= 8
    return both.astype(np.uint8)


def boxes_from_distances(
    bins: Floats, side: int, step: int, cells: NDArray[np.intp] | None = None
) -> Floats:
    """Boxes of one of NanoDet's heads, each told by four distances from its cell's centre.

    A distance is the mean of a distribution over whole steps (Li et al. 2020, "Generalized Focal
    Loss", https://arxiv.org/abs/2006.04388, equation 4).

    Args:
        bins: cells × (4 · n), not yet through softmax.
        side: of the detector's square (px).
        step: from cell to cell (px).
        cells: the numbers of the cells; none for all.

    Returns:
        cells × 4: left, top, right, bottom (px of the square).

    """
    # Rounded up: the last column of cells may stand out of the square.
    across = -(-side // step)
    count = bins.shape[1] // 4
    shaped = bins.reshape(-1, 4, count)
    # The greatest is taken off first, so that `exp` cannot overflow.
    raised = np.exp(shaped - shaped.max(axis=2, keepdims=True))
    mean = (raised @ np.arange(count, dtype=np.float32)) / raised.sum(axis=2) * step
    cell = np.arange(across * across) if cells is None else cells
    x, y = (cell % across + 0.5) * step, (cell // across + 0.5) * step
    found = np.stack([x - mean[:, 0], y - mean[:, 1], x + mean[:, 2], y + mean[:, 3]], axis=1)
    return found.astype(np.float32)


def boxes_from_centres(boxes: Floats) -> Floats:
    """Boxes told by centre, width and height, by their corners."""
    half = boxes[:, 2:] / 2
    return np.concatenate([boxes[:, :2] - half, boxes[:, :2] + half], axis=1)


def suppress_overlaps(
    boxes: Floats, scores: Floats, least: float, *, same: float = SAME, most: int = MOST
) -> list[tuple[int, float, Floats]]:
    """Of boxes that overlap, keep the surest of each class (non-maximum suppression).

    Args:
        boxes: n × 4, corners.
        scores: n × classes, 0 to 1; NaN counts as 0.
        least: boxes less sure than this are left out.
        same: boxes of one class with a larger intersection over union are one thing.
        most: so many are given, the surest first.

    Returns:
        Class, score and corners of each.

    """
    kept = kept_boxes(boxes, scores, least, same=same, most=most)
    return [(label, score, boxes[row]) for row, label, score in kept]


def kept_boxes(
    boxes: Floats, scores: Floats, least: float, *, same: float = SAME, most: int = MOST
) -> list[tuple[int, int, float]]:
    """Give the same by the row, class and score of each, where more is told of a box."""
    # A broken file may give NaN; `argmax` would prefer it to everything.
    label = np.nan_to_num(scores, nan=0.0).argmax(axis=1)
    sure = np.nan_to_num(scores, nan=0.0)[np.arange(len(label)), label]
    fine = (sure >= least) & np.isfinite(boxes).all(axis=1)
    found: list[tuple[int, int, float]] = []
    # Before the costly part: what cannot be among the surest is of no use.
    order = np.flatnonzero(fine)[np.argsort(-sure[fine], kind="stable")][: most * 10]
    while order.size and len(found) < most:
        best, order = order[0], order[1:]
        found.append((int(best), int(label[best]), float(sure[best])))
        # Only within a class: a person on a bicycle is both.
        alike = (label[order] == label[best]) & (_overlap_with(boxes[best], boxes[order]) > same)
        order = order[~alike]
    return found


def _overlap_with(box: Floats, others: Floats) -> Floats:
    """Intersection over union of one box with others."""
    low = np.maximum(box[:2], others[:, :2])
    high = np.minimum(box[2:], others[:, 2:])
    both = np.prod(np.maximum(high - low, 0), axis=1)
    area = np.prod(np.maximum(box[2:] - box[:2], 0))
    areas = np.prod(np.maximum(others[:, 2:] - others[:, :2], 0), axis=1)
    # Two boxes without any area would divide zero by zero.
    return np.asarray(both / np.maximum(area + areas - both, 1e-9), np.float32)


def as_picture_parts(found: list[tuple[int, float, Floats]], frame: Letterbox) -> list[Box]:
    """Give boxes as parts of the picture; those that lie beside it are left out."""
    boxes = []
    for label, score, box in found:
        # A detector's boxes may stand out into the grey around the picture.
        x = np.clip((box[[0, 2]] - frame.left) / (frame.scale * frame.width), 0, 1)
        y = np.clip((box[[1, 3]] - frame.top) / (frame.scale * frame.height), 0, 1)
        # Nothing is left of a box that lay in the grey alone.
        if x[1] > x[0] and y[1] > y[0]:
            boxes.append(Box(label, score, float(x[0]), float(y[0]), float(x[1]), float(y[1])))
    return boxes
