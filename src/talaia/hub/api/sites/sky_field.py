"""A piece of the sky: the stars of Hipparcos that the product ships, and the catalogue's objects.

Of the star catalogue only what is really there is shown: what simulators draw below its limit no
telescope would find.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.api.sites.sky_names import CatalogObject, objects_between

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["WIDEST", "FieldStar", "look_around"]

# Of a piece (°): a mosaic of the Milky Way still fits, and a tangent plane is still right.
WIDEST = 20.0
# In one answer: what a drawing still shows apart.
MOST_STARS = 600
MOST_OBJECTS = 60
# An object that is smaller than this part of the radius is a dot among dots.
_SMALLEST_PART = 1 / 120
# A degree short of the pole every right ascension is near.
_POLAR = 89.0


class FieldStar(NamedTuple):
    """A star; degrees of J2000."""

    ra_deg: float
    dec_deg: float
    magnitude: float


def look_around(
    ra: float, dec: float, radius: float
) -> tuple[list[FieldStar], list[CatalogObject]]:
    """Give the brightest stars and the largest objects within a radius of a place (°).

    Reads files: not for the event loop.
    """
    # Here, so that a hub without an observatory does not read the star catalogue.
    from talaia.imaging.star_catalog import stars_near
    from talaia.imaging.tangent_plane import angular_distance

    stars = stars_near(ra, dec, radius, drawn=False).brightest(MOST_STARS)
    rows = zip(stars.ra.tolist(), stars.dec.tolist(), stars.mag.tolist(), strict=True)
    low, high = max(-90.0, dec - radius), min(90.0, dec + radius)
    near = [
        found
        for first, last in _right_ascensions(ra, dec, radius)
        for found in objects_between((first, last), (low, high), radius * 60 * _SMALLEST_PART)
        if angular_distance(ra, dec, found.ra_deg, found.dec_deg) <= radius
    ]
    largest = sorted(near, key=lambda found: -(found.major or 0.0))[:MOST_OBJECTS]
    return [FieldStar(*row) for row in rows], largest


def _right_ascensions(ra: float, dec: float, radius: float) -> Iterator[tuple[float, float]]:
    """Give the ranges of right ascension (°) that a circle reaches into."""
    farthest = abs(dec) + radius
    if farthest >= _POLAR:
        yield 0.0, 360.0
        return
    # A circle touches the meridians where its own radius is at a right angle to them.
    reach = math.degrees(
        math.asin(min(1.0, math.sin(math.radians(radius)) / math.cos(math.radians(dec))))
    )
    first, last = ra - reach, ra + reach
    if first < 0.0:
        yield 0.0, last
        yield first + 360.0, 360.0
    elif last > 360.0:
        yield first, 360.0
        yield 0.0, last - 360.0
    else:
        yield first, last
