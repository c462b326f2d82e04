"""Where the focus is best, from the size of stars at several positions. Pure.

The half-flux radius of a star over the focuser's position is a hyperbola: far from focus it is a
cone of light, near it what the air leaves (Weber and Brady 2001, "Fast auto-focus method and
software for CCD-based telescopes"). Its square is a parabola, which least squares fit exactly.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["FocusFit", "FocusPoint", "fit_focus"]

LEAST_POINTS = 5
# Part of the spread that the curve must explain.
LEAST_QUALITY = 0.8
# Where fewer than this part of the stars are seen, the rest is noise or their brightest middle.
LEAST_SHARE = 0.15


class FocusPoint(NamedTuple):
    """Stars at one position.

    Attributes:
        position: of the focuser (steps).
        hfr: middle half-flux radius (pixels); NaN where no stars were seen.
        stars: how many it is the middle of.

    """

    position: float
    hfr: float
    stars: int = 1


class FocusFit(NamedTuple):
    """The curve through the points.

    Attributes:
        position: where stars are smallest (steps); NaN when `problem` says why not.
        hfr: what they measure there (pixels).
        uncertainty: standard error of the position (steps).
        quality: part of the spread of the radii that the curve explains, 0 to 1.
        problem: why it is not to be used; empty when it is.
        side: where to look on: -1 inwards, 1 outwards, 0 where that is not known.

    """

    position: float = float("nan")
    hfr: float = float("nan")
    uncertainty: float = float("nan")
    quality: float = 0.0
    problem: str = ""
    side: int = 0


def fit_focus(points: Sequence[FocusPoint]) -> FocusFit:
    """Fit the hyperbola, and say what is wrong with it in words."""
    seen = [point for point in points if point.stars > 0 and math.isfinite(point.hfr)]
    most = max((point.stars for point in seen), default=0)
    seen = [point for point in seen if point.stars >= LEAST_SHARE * most]
    if len(seen) < LEAST_POINTS:
        said = "no stars were seen" if not seen else f"stars were seen at {len(seen)} positions"
        return FocusFit(
            problem=f"{said}; at least {LEAST_POINTS} are needed", side=_side_of(seen, points)
        )
    at = np.array([point.position for point in seen])
    hfr = np.array([point.hfr for point in seen])
    middle, spread = float(at.mean()), max(1.0, float(np.ptp(at)) / 2)
    # Around the middle and of unit size, so that the squares of 25 000 steps lose no digits.
    u = (at - middle) / spread
    columns = np.stack([np.ones_like(u), u, u * u], axis=1)
    # An error of the radius counts 2 HFR times in its square.
    weight = np.sqrt([min(point.stars, 50) for point in seen]) / (2.0 * hfr)
    solved, *_ = np.linalg.lstsq(columns * weight[:, None], hfr**2 * weight, rcond=None)
    a, b, c = (float(value) for value in solved)
    side = int(np.sign(at[np.argmin(hfr)] - middle))
    if c <= 0.0:
        return FocusFit(problem="stars do not grow to both sides of a position", side=side)
    best = -b / (2.0 * c)
    fitted = np.sqrt(np.maximum(columns @ solved, 1e-6))
    rest = float(((hfr - fitted) ** 2).sum())
    total = float(((hfr - hfr.mean()) ** 2).sum())
    quality = max(0.0, 1.0 - rest / total) if total > 0.0 else 0.0
    least = math.sqrt(max(0.0, a + b * best + c * best * best))
    error = _standard_error(columns * weight[:, None], b, c, rest / max(1, len(seen) - 3)) * spread
    found = FocusFit(middle + best * spread, least, error, quality, "", 0)
    return found._replace(problem=_problem_of(found, at, hfr), side=int(np.sign(best)))


def _side_of(seen: Sequence[FocusPoint], points: Sequence[FocusPoint]) -> int:
    # Far out of focus the faint stars are gone: where some are left, it is nearer.
    if not seen:
        return 0
    smallest = min(seen, key=lambda point: point.hfr)
    middle = sum(point.position for point in points) / len(points)
    return int(np.sign(smallest.position - middle))


def _standard_error(weighted: object, b: float, c: float, variance: float) -> float:
    matrix = np.asarray(weighted)
    covariance = np.linalg.pinv(matrix.T @ matrix) * variance
    # Of -b / 2c, by its derivatives.
    by = np.array([0.0, -1.0 / (2.0 * c), b / (2.0 * c * c)])
    return math.sqrt(max(0.0, float(by @ covariance @ by)))


def _problem_of(found: FocusFit, at: object, hfr: object) -> str:
    places, radii = np.asarray(at), np.asarray(hfr)
    if not places.min() <= found.position <= places.max():
        where = "below" if found.position < places.min() else "above"
        return f"the best focus lies {where} the positions that were tried"
    if float(np.ptp(radii)) < 0.15 * float(radii.min()):
        return "the stars are as large everywhere: the positions are too near to each other"
    if found.quality < LEAST_QUALITY:
        return f"the sizes scatter: the curve explains {found.quality:.0%} of them"
    return ""
