"""Ways of running of a machine, found in rows of its signals: few levels that lie well apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.hub.anomaly.base import Floats

__all__ = ["assign_modes", "find_modes", "likeliest_modes", "mode_widths", "scale_levels"]

# Rows that are looked at; more, evenly left out, would tell no more of levels.
_MOST_ROWS, _ROUNDS = 1_000, 20
# Two modes are as far apart as so many of their spreads (Ashman, Bird and Zepf 1994: 2 is a clean
# division). A steady drift cut in two reaches 3.5: it must not count as two ways of running.
_APART = 5.0
# Within a mode no signal counts as steadier than such a part of its whole spread, nor any value as
# farther than so many of the mode's spreads.
_LEAST_WIDTH, _FAR = 0.1, 10.0


def scale_levels(rows: Floats) -> tuple[Floats, Floats]:
    """Give middle and spread of each column, by which its levels are compared; NaN left out."""
    there = np.isfinite(rows)
    counts = np.maximum(there.sum(axis=0), 1)
    center = np.where(there, rows, 0.0).sum(axis=0) / counts
    spread = np.sqrt((np.where(there, rows - center, 0.0) ** 2).sum(axis=0) / counts)
    # A signal that does not move tells no modes apart.
    return center, np.where(spread > 1e-9 * np.maximum(np.abs(center), 1e-9), spread, np.inf)


def find_modes(levels: Floats, most: int, fewest_rows: int) -> Floats:
    """Find at most ``most`` modes.

    Args:
        levels: scaled rows (rows, signals), no NaN.
        most: so many modes at the most.
        fewest_rows: of so many rows at least each.

    Returns:
        Their middles (modes, signals): one where the rows do not fall apart.

    """
    some = levels[:: max(1, -(-len(levels) // _MOST_ROWS))]
    least = max(2, round(fewest_rows * len(some) / len(levels)))
    for count in range(most, 1, -1):
        centers = _settle_centers(some, _first_centers(some, count))
        if _fall_apart(some, centers, least):
            return centers
    middle: Floats = levels.mean(axis=0, keepdims=True)
    return middle


def assign_modes(levels: Floats, centers: Floats) -> NDArray[np.intp]:
    """Give the number of the nearest mode for each row."""
    distances = ((levels[:, np.newaxis, :] - centers[np.newaxis]) ** 2).sum(axis=2)
    nearest: NDArray[np.intp] = np.argmin(distances, axis=1)
    return nearest


def mode_widths(levels: Floats, modes: NDArray[np.intp], count: int) -> Floats:
    """Give the spread of each signal's levels within each mode (modes, signals)."""
    widths = np.array([levels[modes == at].std(axis=0) for at in range(count)])
    bounded: Floats = np.maximum(widths, _LEAST_WIDTH)
    return bounded


def likeliest_modes(levels: Floats, centers: Floats, widths: Floats) -> NDArray[np.intp]:
    """Give the number of the mode that each row fits best, in spreads of that mode.

    Without widths (of a version before) it is the nearest one. A mode in which a signal hardly
    moves is no place for a row in which it is elsewhere, however near the other signals are.
    """
    if not widths.size:
        return assign_modes(levels, centers)
    off = (levels[:, np.newaxis, :] - centers[np.newaxis]) / widths[np.newaxis]
    # What is far off in all modes, as a sensor that fails, tells nothing about which it is.
    unlike = np.minimum(off * off, _FAR * _FAR).sum(axis=2) + 2.0 * np.log(widths).sum(axis=1)
    likeliest: NDArray[np.intp] = np.argmin(unlike, axis=1)
    return likeliest


def _first_centers(levels: Floats, count: int) -> Floats:
    """Begin with rows that lie far apart (Gonzalez 1985): the same rows give the same modes."""
    chosen = [int(np.argmin(((levels - np.median(levels, axis=0)) ** 2).sum(axis=1)))]
    nearest = np.full(len(levels), np.inf)
    while len(chosen) < count:
        nearest = np.minimum(nearest, ((levels - levels[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(nearest)))
    return levels[chosen]


def _settle_centers(levels: Floats, centers: Floats) -> Floats:
    """Move each middle to that of its rows until nothing changes (Lloyd 1982)."""
    for _ in range(_ROUNDS):
        mode = assign_modes(levels, centers)
        moved = np.array(
            [
                levels[mode == at].mean(axis=0) if (mode == at).any() else centers[at]
                for at in range(len(centers))
            ]
        )
        if np.allclose(moved, centers):
            break
        centers = moved
    return centers


def _fall_apart(levels: Floats, centers: Floats, fewest: int) -> bool:
    mode = assign_modes(levels, centers)
    if np.bincount(mode, minlength=len(centers)).min() < fewest:
        return False
    for one in range(len(centers)):
        for other in range(one):
            way = centers[one] - centers[other]
            length = float(np.sqrt(way @ way))
            if length == 0.0:
                return False
            along = levels @ (way / length)
            spread = np.sqrt(0.5 * (along[mode == one].var() + along[mode == other].var()))
            if length < _APART * spread:
                return False
    return True
