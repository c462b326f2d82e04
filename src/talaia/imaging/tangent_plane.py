"""The gnomonic projection, and a world coordinate system that uses it (FITS' ``TAN``). Pure.

Source: Calabretta and Greisen 2002, Astronomy & Astrophysics 395, 1077, sections 2 and 5.1.3.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

__all__ = ["TanWcs", "angular_distance", "plane_to_sky", "sky_to_plane"]


def sky_to_plane(
    ra: NDArray[np.float64], dec: NDArray[np.float64], ra0: float, dec0: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give standard coordinates (°, to the east and north) about a centre (°).

    What stands behind the observer, at 90° or farther, is not on the plane: NaN.
    """
    a, d, d0 = np.radians(ra - ra0), np.radians(dec), math.radians(dec0)
    cosine = math.sin(d0) * np.sin(d) + math.cos(d0) * np.cos(d) * np.cos(a)
    cosine = np.where(cosine > 1e-9, cosine, np.nan)
    xi = np.cos(d) * np.sin(a) / cosine
    eta = (math.cos(d0) * np.sin(d) - math.sin(d0) * np.cos(d) * np.cos(a)) / cosine
    return np.degrees(xi), np.degrees(eta)


def plane_to_sky(
    xi: NDArray[np.float64], eta: NDArray[np.float64], ra0: float, dec0: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Turn standard coordinates (°) about a centre (°) back into places of the sky."""
    x, y, d0 = np.radians(xi), np.radians(eta), math.radians(dec0)
    along = math.cos(d0) - y * math.sin(d0)
    ra = ra0 + np.degrees(np.arctan2(x, along))
    dec = np.degrees(np.arctan2(math.sin(d0) + y * math.cos(d0), np.hypot(x, along)))
    return ra % 360.0, dec


def angular_distance(ra: float, dec: float, other_ra: float, other_dec: float) -> float:
    """Give the distance of two places (°); exact for small ones."""
    half_dec, half_ra = math.radians(other_dec - dec) / 2, math.radians(other_ra - ra) / 2
    across = math.cos(math.radians(dec)) * math.cos(math.radians(other_dec))
    square = math.sin(half_dec) ** 2 + across * math.sin(half_ra) ** 2
    return math.degrees(2.0 * math.asin(math.sqrt(min(1.0, square))))


class TanWcs(NamedTuple):
    """Where a picture's pixels stand in the sky. Pixels are counted from 0, at their centres.

    Attributes:
        ra: of the reference pixel (°, J2000).
        dec: of the reference pixel (°, J2000).
        x: reference pixel, column.
        y: reference pixel, row.
        cd: degrees to the east by x and by y, then degrees to the north by x and by y.

    """

    ra: float
    dec: float
    x: float
    y: float
    cd: tuple[float, float, float, float]

    @property
    def scale(self) -> float:
        """Give the size of a pixel (arc seconds)."""
        a, b, c, d = self.cd
        return math.sqrt(abs(a * d - b * c)) * 3600.0

    @property
    def rotation(self) -> float:
        """Give how far north is turned from up, to the east (°)."""
        _, b, _, d = self.cd
        return math.degrees(math.atan2(b, d))

    @property
    def mirrored(self) -> bool:
        """Tell whether the picture is one of a mirror: east to the right of north."""
        a, b, c, d = self.cd
        return a * d - b * c > 0.0

    def pixel_to_sky(self, x: Any, y: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # noqa: ANN401 - a number or an array
        """Give right ascension and declination (°) of pixels."""
        a, b, c, d = self.cd
        u, v = np.asarray(x, float) - self.x, np.asarray(y, float) - self.y
        return plane_to_sky(a * u + b * v, c * u + d * v, self.ra, self.dec)

    def sky_to_pixel(self, ra: Any, dec: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # noqa: ANN401
        """Give columns and rows of places (°)."""
        xi, eta = sky_to_plane(np.asarray(ra, float), np.asarray(dec, float), self.ra, self.dec)
        a, b, c, d = self.cd
        area = a * d - b * c
        return self.x + (d * xi - b * eta) / area, self.y + (a * eta - c * xi) / area

    def header_cards(self) -> list[tuple[str, str | float, str]]:
        """Give the FITS cards that say it: keyword, value, comment. FITS counts pixels from 1."""
        return [
            ("RADESYS", "ICRS", "frame of the coordinates"),
            ("EQUINOX", 2000.0, "[yr]"),
            ("CTYPE1", "RA---TAN", "gnomonic"),
            ("CTYPE2", "DEC--TAN", "gnomonic"),
            ("CUNIT1", "deg", "unit"),
            ("CUNIT2", "deg", "unit"),
            ("CRVAL1", self.ra, "[deg] at the reference pixel"),
            ("CRVAL2", self.dec, "[deg] at the reference pixel"),
            ("CRPIX1", self.x + 1.0, "reference pixel"),
            ("CRPIX2", self.y + 1.0, "reference pixel"),
            ("CD1_1", self.cd[0], "[deg/px]"),
            ("CD1_2", self.cd[1], "[deg/px]"),
            ("CD2_1", self.cd[2], "[deg/px]"),
            ("CD2_2", self.cd[3], "[deg/px]"),
        ]

    @staticmethod
    def from_header(values: Mapping[str, object]) -> TanWcs | None:
        """Read the cards of `header_cards`; none where some are missing."""
        keys = ("CRVAL1", "CRVAL2", "CRPIX1", "CRPIX2", "CD1_1", "CD1_2", "CD2_1", "CD2_2")
        found = [values.get(key) for key in keys]
        numbers = [float(value) for value in found if isinstance(value, (int, float))]
        if len(numbers) != len(keys) or "TAN" not in str(values.get("CTYPE1", "")):
            return None
        ra, dec, x, y, *cd = numbers
        return TanWcs(ra, dec, x - 1.0, y - 1.0, (cd[0], cd[1], cd[2], cd[3]))
