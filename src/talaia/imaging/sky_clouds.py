"""How much of the sky is covered, from a picture of all of it: which stars are missing. Pure.

A fisheye that looks to the zenith shows each star of the catalogue at a place that follows from
time, place and lens. Where stars that ought to be seen are not, there are clouds. Each part of the
sky counts by its size, however many stars it has.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from talaia.imaging.star_catalog import real_stars
from talaia.model.units.astronomy import (
    Observer,
    equatorial_to_horizontal,
    julian_day,
    sidereal_hours,
    sun_position,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["CloudMeasure", "SkyMoment", "lens_pixels", "measure_clouds", "sky_stars"]

# Half a box around a star's place, and half the ring that its sky is measured in (pixels).
BOX, RING = 2, 7
# Times the noise from which it is a star, and from which one ought to be.
SEEN, EXPECTED = 4.5, 9.0
# Part of a star's light that comes through a clear sky.
CLEAR = 0.4
# While it stands higher (°) stars are drowned whatever the clouds are.
HIGHEST_SUN = -8.0
# Fewer than this tell nothing.
LEAST_STARS = 20
# Parts of the sky of about equal size: rings of altitude, each cut by azimuth.
_RINGS = 5
_NEEDED = 2


class LensPlace(Protocol):
    """Where the sky is on a picture; see `talaia.model.detection.SkyLens`."""

    @property
    def x(self) -> float: ...

    @property
    def y(self) -> float: ...

    @property
    def radius(self) -> float: ...

    @property
    def turned(self) -> float: ...

    @property
    def mirrored(self) -> bool: ...

    @property
    def lowest(self) -> float: ...

    @property
    def faintest(self) -> float: ...


class SkyMoment(NamedTuple):
    """Where and when a picture was taken: latitude and longitude (°), time (s, UTC)."""

    latitude: float
    longitude: float
    unix: float


class SkyStars(NamedTuple):
    """Stars above a site, as columns.

    Attributes:
        alt: altitude (°).
        az: azimuth from the north by the east (°).
        mag: magnitude.

    """

    alt: NDArray[np.float64]
    az: NDArray[np.float64]
    mag: NDArray[np.float64]


class CloudMeasure(NamedTuple):
    """What a picture tells.

    Attributes:
        cover: of the sky (%); NaN when `problem` says why not.
        expected: so many stars ought to be seen.
        seen: so many of them are.
        zero: magnitude of a star of one count where the sky is clear; NaN where that is not told.
        problem: in words; empty when it was measured.

    """

    cover: float
    expected: int
    seen: int
    zero: float = math.nan
    problem: str = ""


def sky_stars(moment: SkyMoment, faintest: float) -> SkyStars:
    """Give the stars above a site's horizon, without refraction, to a tenth of a degree."""
    stars = real_stars()
    stars = stars.select(stars.mag <= faintest)
    jd = julian_day(moment.unix)
    # General precession in right ascension and declination (Meeus 21), enough for a pixel.
    years = (jd - 2451545.0) / 365.25
    ra, dec = np.radians(stars.ra), np.radians(stars.dec)
    m, n = math.radians(years * 46.124 / 3600.0), math.radians(years * 20.043 / 3600.0)
    tangent = np.tan(np.clip(dec, -1.55, 1.55))
    ra, dec = ra + m + n * np.sin(ra) * tangent, dec + n * np.cos(ra)
    hour = math.radians(sidereal_hours(jd, moment.longitude) * 15.0) - ra
    phi = math.radians(moment.latitude)
    sine = math.sin(phi) * np.sin(dec) + math.cos(phi) * np.cos(dec) * np.cos(hour)
    alt = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))
    north = np.sin(dec) * math.cos(phi) - np.cos(dec) * math.sin(phi) * np.cos(hour)
    az = np.degrees(np.arctan2(-np.cos(dec) * np.sin(hour), north)) % 360.0
    up = alt > 0.0
    return SkyStars(alt[up], az[up], stars.mag[up])


def lens_pixels(
    alt: NDArray[np.float64], az: NDArray[np.float64], lens: LensPlace
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give column and row (from the top) of directions: the distance from the zenith as angles."""
    far = lens.radius * (90.0 - alt) / 90.0
    angle = np.radians(az - lens.turned)
    # Who looks up has east at the left when north is up.
    side = 1.0 if lens.mirrored else -1.0
    return lens.x + side * far * np.sin(angle), lens.y - far * np.cos(angle)


def measure_clouds(
    pixels: NDArray[np.float64], lens: LensPlace, moment: SkyMoment, zero: float = math.nan
) -> CloudMeasure:
    """Measure a picture (brightness by rows from the top and columns).

    Args:
        pixels: see above.
        lens: where the sky is on it.
        moment: where and when it was taken.
        zero: that of a clear sky, if it is known: a sky that is covered all over does not tell it.

    """
    here = Observer(moment.latitude, moment.longitude, 0.0)
    jd = julian_day(moment.unix)
    if equatorial_to_horizontal(*sun_position(jd), here, jd).alt > HIGHEST_SUN:
        return CloudMeasure(math.nan, 0, 0, problem="the Sun is too high for stars")
    stars = sky_stars(moment, lens.faintest)
    x, y = lens_pixels(stars.alt, stars.az, lens)
    column, row = np.round(x).astype(int), np.round(y).astype(int)
    height, width = pixels.shape
    kept = (stars.alt >= lens.lowest) & (column >= RING) & (column < width - RING)
    kept &= (row >= RING) & (row < height - RING)
    column, row = column[kept], row[kept]
    alt, az, mag = stars.alt[kept], stars.az[kept], stars.mag[kept]
    if len(mag) < LEAST_STARS:
        return CloudMeasure(math.nan, len(mag), 0, problem="too few stars stand high enough")
    signal, noise = _star_signals(pixels, column, row)
    found = signal > SEEN * noise
    here_zero = _zero_point(signal, mag, found)
    # The better of both: clouds only make stars weaker.
    zero = float(np.nanmax([here_zero, zero, -math.inf]))
    expected = _expected_stars(noise, mag, zero)
    # The brightest shine through a cloud, and are weaker than they ought to be.
    if math.isfinite(zero):
        found &= signal > CLEAR * 10 ** (0.4 * (zero - mag))
    if int(expected.sum()) < LEAST_STARS:
        problem = "the sky is too bright for stars"
        return CloudMeasure(math.nan, int(expected.sum()), 0, here_zero, problem)
    cover = _cover_of(found[expected], alt[expected], az[expected], lens.lowest)
    return CloudMeasure(cover, int(expected.sum()), int((found & expected).sum()), here_zero)


def _star_signals(
    pixels: NDArray[np.float64], column: NDArray[np.int_], row: NDArray[np.int_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give the brightest 3 by 3 pixels near each place above the sky around it, and its noise."""
    axis = np.arange(-RING, RING + 1)
    boxes = pixels[row[:, None, None] + axis[:, None], column[:, None, None] + axis]
    far = np.maximum(np.abs(axis)[:, None], np.abs(axis))
    ring = boxes[:, far > BOX + 2]
    sky = np.median(ring, axis=1)
    # By the middle deviation: another star in the ring is no noise.
    noise = 1.4826 * np.median(np.abs(ring - sky[:, None]), axis=1)
    middle = RING
    sums = np.stack(
        [
            boxes[:, middle + dy - 1 : middle + dy + 2, middle + dx - 1 : middle + dx + 2].sum(
                axis=(1, 2)
            )
            for dy in range(-BOX + 1, BOX)
            for dx in range(-BOX + 1, BOX)
        ]
    )
    # Nine pixels have three times the noise of one; less than a count is the camera's rounding.
    return sums.max(axis=0) - 9.0 * sky, 3.0 * np.maximum(noise, 0.5)


def _zero_point(
    signal: NDArray[np.float64], mag: NDArray[np.float64], found: NDArray[np.bool_]
) -> float:
    """Give the magnitude of a star of one count where the sky is clear; NaN: hardly any is seen."""
    if int(found.sum()) < LEAST_STARS // 2:
        return math.nan
    # Of those that are seen some shine through clouds: the better ones tell it.
    return float(np.quantile(mag[found] + 2.5 * np.log10(signal[found]), 0.7))


def _expected_stars(
    noise: NDArray[np.float64], mag: NDArray[np.float64], zero: float
) -> NDArray[np.bool_]:
    """Tell which ought to stand out."""
    if not math.isfinite(zero):
        # All may be covered: then the brightest tell it.
        return np.asarray(mag <= np.sort(mag)[min(len(mag), 2 * LEAST_STARS) - 1])
    return np.asarray(10 ** (0.4 * (zero - mag)) > EXPECTED * float(np.median(noise)))


def _cover_of(
    found: NDArray[np.bool_], alt: NDArray[np.float64], az: NDArray[np.float64], lowest: float
) -> float:
    low = math.sin(math.radians(lowest))
    # Rings of equal size: the sine of the altitude in equal steps.
    ring = np.minimum(_RINGS - 1, ((np.sin(np.radians(alt)) - low) / (1.0 - low) * _RINGS))
    cell = ring.astype(int) * 8 + (az / 45.0).astype(int)
    asked = np.bincount(cell, minlength=_RINGS * 8)
    seen = np.bincount(cell, found.astype(float), minlength=_RINGS * 8)
    told = asked >= _NEEDED
    if not told.any():
        return float(100.0 * (1.0 - found.mean()))
    return float(100.0 * (1.0 - (seen[told] / asked[told]).mean()))
