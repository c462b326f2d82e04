"""How good a picture is: size of its stars, sky, noise, zero point. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from talaia.imaging.plate_solver import PlateSolution
    from talaia.imaging.star_detection import DetectedStars

__all__ = ["FrameQuality", "measure_quality"]


class FrameQuality(NamedTuple):
    """Figures of one picture; NaN for what cannot be told.

    Attributes:
        stars: how many were measured.
        hfr: middle half-flux radius (pixels).
        fwhm: middle width at half the height (arc seconds); pixels are not known: NaN.
        elongation: middle of the stars' longer axis by the shorter; 1 for round ones.
        background: of the sky (counts).
        noise: of the sky (counts).
        zero_point: magnitude of a star that gives one count in a second.

    """

    stars: int
    hfr: float
    fwhm: float
    elongation: float
    background: float
    noise: float
    zero_point: float = float("nan")

    def header_cards(self) -> list[tuple[str, float, str]]:
        """Give them as FITS cards; those that cannot be told are left out."""
        cards = [
            ("NSTARS", float(self.stars), "stars measured"),
            ("HFR", self.hfr, "[px] median half-flux radius"),
            ("FWHM", self.fwhm, "[arcsec] median"),
            ("ELLONG", self.elongation, "median long axis / short axis"),
            ("SKYLEVEL", self.background, "[adu] median of the sky"),
            ("SKYNOISE", self.noise, "[adu] standard deviation of the sky"),
            ("MAGZP", self.zero_point, "[mag] of one adu in a second"),
        ]
        return [(key, round(value, 4), said) for key, value, said in cards if math.isfinite(value)]


def measure_quality(
    found: DetectedStars,
    *,
    scale: float | None = None,
    solution: PlateSolution | None = None,
    seconds: float | None = None,
) -> FrameQuality:
    """Measure a picture.

    Args:
        found: its stars.
        scale: of a pixel (arc seconds).
        solution: where it stands, for the zero point.
        seconds: it was exposed, for the zero point.

    """
    if solution is not None and solution.wcs is not None:
        scale = solution.wcs.scale
    return FrameQuality(
        stars=found.total,
        hfr=found.median_hfr,
        fwhm=found.fwhm * scale if scale else float("nan"),
        elongation=float(np.median(found.elongation)) if found.total else float("nan"),
        background=found.background,
        noise=found.noise,
        zero_point=_zero_point(found, solution, seconds),
    )


def _zero_point(
    found: DetectedStars, solution: PlateSolution | None, seconds: float | None
) -> float:
    if solution is None or solution.pairs is None or solution.stars is None or not seconds:
        return float("nan")
    ours, theirs = solution.pairs.T
    lit = found.flux[ours] > 0.0
    if int(lit.sum()) < 3:
        return float("nan")
    # The middle one: variable stars and wrong pairs are few.
    magnitudes = solution.stars.mag[theirs[lit]]
    return float(np.median(magnitudes + 2.5 * np.log10(found.flux[ours[lit]] / seconds)))
