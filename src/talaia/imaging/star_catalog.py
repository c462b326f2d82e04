"""Stars near a place of the sky: the real ones of Hipparcos, and fainter ones that are drawn. Pure.

Hipparcos has 118 thousand stars, nearly all down to 8th magnitude and some to 12th: three in a
square degree, so that a telescope of 2 m sees one in every twelfth of its pictures. What no file of
a megabyte can hold is made up: the sky (J2000) is cut into cells of half a degree, and each cell's
faint stars come from a generator seeded by the cell. They are the same in every picture of a field
and in every program, which is what a solver is tried with; no other catalogue knows them.
"""

from __future__ import annotations

import math
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

__all__ = ["FAINTEST", "REAL_UNTIL", "Stars", "drawn_stars", "real_stars", "stars_near"]

CELL = 0.5
# Hipparcos is nearly complete to here; what is drawn begins here.
REAL_UNTIL = 8.5
FAINTEST = 16.5
# log N(<m) = 0.42 m - 3.3 for each square degree: 8 stars to 10th magnitude and a thousand to
# 15th, the mean of the whole sky (Allen's Astrophysical Quantities, 4th edition, table 19.10).
SLOPE, ZERO = 0.42, -3.3
# Julian year of Hipparcos' places, and the one that pictures are drawn for.
_EPOCH, _YEAR = 1991.25, 2027.0


class Stars(NamedTuple):
    """Stars as columns of one length.

    Attributes:
        ra: right ascension (°, J2000).
        dec: declination (°, J2000).
        mag: magnitude.

    """

    ra: NDArray[np.float64]
    dec: NDArray[np.float64]
    mag: NDArray[np.float64]

    def select(self, chosen: NDArray[Any]) -> Stars:
        """Give those of a mask, or of an index."""
        return Stars(self.ra[chosen], self.dec[chosen], self.mag[chosen])

    def brightest(self, count: int) -> Stars:
        """Give so many at the most, the brightest first."""
        return self.select(np.argsort(self.mag, kind="stable")[:count])


def stars_near(
    ra: float, dec: float, radius: float, faintest: float = FAINTEST, *, drawn: bool = True
) -> Stars:
    """List the stars within a radius (°) of a place (°, J2000).

    Args:
        ra: of the place.
        dec: of the place.
        radius: at most so far from it.
        faintest: no star is fainter.
        drawn: with those that are made up; without, only what is really there.

    """
    found = [_real_between(dec - radius, dec + radius)]
    if drawn and faintest > REAL_UNTIL:
        found.append(drawn_stars(ra, dec, radius))
    stars = Stars(*(np.concatenate(column) for column in zip(*found, strict=True)))
    # The haversine: exact for small distances, where the cosine is not.
    half = np.radians(stars.dec - dec) / 2, np.radians(stars.ra - ra) / 2
    across = np.cos(np.radians(stars.dec)) * math.cos(math.radians(dec)) * np.sin(half[1]) ** 2
    near = np.sin(half[0]) ** 2 + across <= math.sin(math.radians(min(radius, 180.0)) / 2) ** 2
    return stars.select(near & (stars.mag <= faintest))


@lru_cache(maxsize=1)
def real_stars() -> Stars:
    """Read the packed catalogue, sorted by declination; places of 2027."""
    with (files("talaia.imaging") / "data" / "hipparcos.npz").open("rb") as file:
        packed = np.load(file)
        dec = packed["dec"] * (90.0 / (2**31 - 1))
        ra = packed["ra"] * (360.0 / 2**32)
        # Milliarcseconds a year; that of right ascension is along the sky.
        years = (_YEAR - _EPOCH) / 3.6e6
        dec_now = dec + packed["north"] * years
        ra_now = ra + packed["east"] * years / np.cos(np.radians(dec))
        mag = packed["mag"] / 1000.0
    order = np.argsort(dec_now)
    return Stars(ra_now % 360.0, np.clip(dec_now, -90.0, 90.0), mag).select(order)


def _real_between(low: float, high: float) -> Stars:
    stars = real_stars()
    first, last = np.searchsorted(stars.dec, (low, high))
    return stars.select(np.arange(first, last))


def drawn_stars(ra: float, dec: float, radius: float) -> Stars:
    """List the faint stars that are made up, of all cells within a radius (°)."""
    cells = [_stars_of_cell(band, column) for band, column in _cells_near(ra, dec, radius)]
    return Stars(*(np.concatenate(column) for column in zip(*cells, strict=True)))


def _cells_near(ra: float, dec: float, radius: float) -> Iterator[tuple[int, int]]:
    low = math.floor((dec - radius + 90.0) / CELL)
    high = math.floor((dec + radius + 90.0) / CELL)
    for band in range(max(0, low), min(round(180 / CELL) - 1, high) + 1):
        count = _cells_of_band(band)
        width = 360.0 / count
        middle = math.radians(-90.0 + (band + 0.5) * CELL)
        # Right ascension spans more degrees near the pole; a whole cell is added for the edges.
        reach = min(180.0, radius / max(0.01, math.cos(middle)) + width)
        first, last = math.floor((ra - reach) / width), math.floor((ra + reach) / width)
        # Near the pole both ends may reach the same cell: each counts once.
        columns = {index % count for index in range(first, min(last, first + count) + 1)}
        yield from ((band, column) for column in sorted(columns))


def _cells_of_band(band: int) -> int:
    # Cells of about equal area: a band nearer the pole has fewer of them.
    middle = math.radians(-90.0 + (band + 0.5) * CELL)
    return max(1, round(360.0 * math.cos(middle) / CELL))


@lru_cache(maxsize=1024)
def _stars_of_cell(band: int, column: int) -> Stars:
    # Seeded by the cell, so that the same field shows the same stars every night.
    dice = np.random.default_rng((band, column))
    width = 360.0 / _cells_of_band(band)
    south = -90.0 + band * CELL
    area = width * CELL * math.cos(math.radians(south + CELL / 2))
    number = int(dice.poisson(area * (_density_at(FAINTEST) - _density_at(REAL_UNTIL))))
    # The law of numbers, turned round, between both ends.
    share = _density_at(REAL_UNTIL) / _density_at(FAINTEST)
    mag = FAINTEST + np.log10(share + (1.0 - share) * dice.random(number)) / SLOPE
    place = (column + dice.random(number)) * width, south + dice.random(number) * CELL
    return Stars(*place, mag)


def _density_at(mag: float) -> float:
    # Stars to this magnitude in a square degree.
    return float(10 ** (SLOPE * mag + ZERO))
