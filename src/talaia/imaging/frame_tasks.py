"""What is reckoned from a whole file, as functions that a process of its own can run. Pure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from talaia.imaging.errors import UnreadableFrame
from talaia.imaging.fits_pixels import Frame, read_frame
from talaia.imaging.frame_quality import measure_quality
from talaia.imaging.plate_solver import PlateHint, solve_plate
from talaia.imaging.star_catalog import stars_near
from talaia.imaging.star_detection import detect_stars

__all__ = [
    "FocusMeasure",
    "SolvedFrame",
    "frame_scale",
    "measure_focus",
    "measure_level",
    "solve_frame",
]

# Fewer stars than this are taken for none: one may be a hot pixel.
_LEAST_STARS = 3


class FocusMeasure(NamedTuple):
    """Stars of one picture of a focus run.

    Attributes:
        hfr: middle half-flux radius (pixels); NaN without stars.
        stars: how many.
        problem: the file cannot be read; empty otherwise.

    """

    hfr: float
    stars: int
    problem: str = ""


class SolvedFrame(NamedTuple):
    """Where a file's picture stands, and how good it is.

    Attributes:
        ra: of the middle (°, J2000); NaN when `problem` says why not.
        dec: (°, J2000).
        problem: in words; empty when it was solved.
        fwhm: middle width of its stars at half their height (″); NaN where it was not solved.
        cards: for its header: quality, and the WCS where it was solved.

    """

    ra: float = float("nan")
    dec: float = float("nan")
    problem: str = ""
    fwhm: float = float("nan")
    cards: tuple[tuple[str, str | float, str], ...] = ()


def measure_level(data: bytes) -> float | None:
    """Give the median of the middle of a FITS file's picture (counts); none: it cannot be read."""
    try:
        pixels = read_frame(data).pixels
    except UnreadableFrame:
        return None
    height, width = pixels.shape
    middle = pixels[height // 4 : height - height // 4, width // 4 : width - width // 4]
    return float(np.median(middle))


def measure_focus(data: bytes) -> FocusMeasure:
    """Measure the stars of a FITS file."""
    try:
        found = detect_stars(read_frame(data).pixels)
    except UnreadableFrame as error:
        return FocusMeasure(float("nan"), 0, str(error))
    stars = found.total if found.total >= _LEAST_STARS else 0
    return FocusMeasure(found.median_hfr, stars)


def solve_frame(data: bytes, ra: float | None = None, dec: float | None = None) -> SolvedFrame:
    """Solve a FITS file near a place (°, J2000), or else near what its header says."""
    try:
        frame = read_frame(data)
    except UnreadableFrame as error:
        return SolvedFrame(problem=f"the picture cannot be read: {error}")
    found = detect_stars(frame.pixels)
    ra = frame.number("RA", "CRVAL1") if ra is None else ra
    dec = frame.number("DEC", "CRVAL2") if dec is None else dec
    scale, seconds = frame_scale(frame), frame.number("EXPTIME")
    if ra is None or dec is None or scale is None:
        only = measure_quality(found, scale=scale).header_cards()
        missing = "the size of a pixel" if scale is None else "where the telescope points"
        return SolvedFrame(problem=f"its header does not say {missing}", cards=tuple(only))
    rows, columns = frame.pixels.shape
    solved = solve_plate(found, (rows, columns), PlateHint(ra, dec, scale), stars_near)
    quality = measure_quality(found, scale=scale, solution=solved, seconds=seconds)
    cards = tuple(quality.header_cards())
    if solved.wcs is None:
        return SolvedFrame(problem=solved.problem, cards=cards)
    return SolvedFrame(
        solved.wcs.ra,
        solved.wcs.dec,
        fwhm=quality.fwhm,
        cards=(*cards, *solved.wcs.header_cards()),
    )


def frame_scale(frame: Frame) -> float | None:
    """Give the size of a pixel (arc seconds): as the header says, or by focal length and pixel."""
    said = frame.number("SCALE", "PIXSCALE", "SECPIX")
    pixel, focal = frame.number("XPIXSZ", "PIXSIZE1"), frame.number("FOCALLEN")
    if said is not None and said > 0.0:
        return said
    if pixel is None or focal is None or pixel <= 0.0 or focal <= 0.0:
        return None
    # XPIXSZ is that of the binned pixel.
    return 206.265 * pixel / focal
