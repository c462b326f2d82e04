"""How bright the sky is between the stars: night, twilight, Moon, clouds. Pure."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

from talaia.model.units.astronomy import (
    Horizontal,
    Observer,
    angular_separation,
    equatorial_to_horizontal,
    julian_day,
    sun_position,
)

__all__ = ["Moonlight", "moon_position", "moonlight", "sky_magnitude"]

# A moonless night in the country (magnitudes of a square arc second).
DARK = 21.5
# Altitude of the Sun (°) and the zenith's brightness then: Patat, Ugolnikov and Postylyakov 2006
# (A&A 455, 385, figure 3, V) to -5°, and from there to the blue sky of noon.
_TWILIGHT = (
    (-18.0, 21.5),
    (-15.0, 20.9),
    (-12.0, 19.0),
    (-10.0, 17.2),
    (-8.0, 15.2),
    (-6.0, 12.9),
    (-4.0, 10.6),
    (-2.0, 8.4),
    (0.0, 6.5),
    (5.0, 4.8),
    (20.0, 3.6),
    (90.0, 3.2),
)


class Moonlight(NamedTuple):
    """The Moon as it lights the sky.

    Attributes:
        at: where it stands.
        phase_angle: Sun, Moon, Earth (°): 0 when it is full.

    """

    at: Horizontal
    phase_angle: float


def moon_position(jd: float) -> tuple[float, float]:
    """Give right ascension (h) and declination (°), to about 0.3° (Astronomical Almanac, D46)."""
    t = (jd - 2451545.0) / 36525.0

    def sine(amount: float, at: float, rate: float) -> float:
        return amount * math.sin(math.radians(at + rate * t))

    longitude = 218.32 + 481267.881 * t
    longitude += sine(6.29, 135.0, 477198.87) - sine(1.27, 259.3, -413335.36)
    longitude += sine(0.66, 235.7, 890534.22) + sine(0.21, 269.9, 954397.74)
    longitude += -sine(0.19, 357.5, 35999.05) - sine(0.11, 186.5, 966404.03)
    latitude = sine(5.13, 93.3, 483202.02) + sine(0.28, 228.2, 960400.89)
    latitude += -sine(0.28, 318.3, 6003.15) - sine(0.17, 217.6, -407332.21)
    lam, beta, eps = math.radians(longitude), math.radians(latitude), math.radians(23.4393)
    x = math.cos(beta) * math.cos(lam)
    y = math.cos(eps) * math.cos(beta) * math.sin(lam) - math.sin(eps) * math.sin(beta)
    z = math.sin(eps) * math.cos(beta) * math.sin(lam) + math.cos(eps) * math.sin(beta)
    return math.degrees(math.atan2(y, x)) / 15.0 % 24.0, math.degrees(math.asin(z))


def moonlight(place: Observer, unix_s: float) -> Moonlight:
    """Give where the Moon stands and how full it is."""
    jd = julian_day(unix_s)
    moon, sun = moon_position(jd), sun_position(jd)
    # Both are so far away that the angle at the Moon is what is left of the elongation.
    apart = angular_separation(
        Horizontal(moon[1], moon[0] * 15.0), Horizontal(sun[1], sun[0] * 15.0)
    )
    return Moonlight(equatorial_to_horizontal(*moon, place, jd), 180.0 - apart)


def sky_magnitude(at: Horizontal, sun_alt: float, moon: Moonlight, clouds: float) -> float:
    """Give the brightness of the sky where the telescope points (mag of a square arc second).

    Args:
        at: where it points.
        sun_alt: altitude of the Sun (°).
        moon: see `moonlight`.
        clouds: cover (%): they carry the light of Moon and lamps everywhere.

    """
    light = _light_of(_between(sun_alt)) + _moon_light(at, moon) * (1.0 + clouds / 100.0)
    # Lamps of the valley on the clouds: a magnitude brighter when all is covered.
    light += _light_of(DARK) * 1.5 * clouds / 100.0
    return -2.5 * math.log10(light)


def _light_of(mag: float) -> float:
    return float(10 ** (-0.4 * mag))


def _between(sun_alt: float) -> float:
    if sun_alt <= _TWILIGHT[0][0]:
        return DARK
    for (low, dark), (high, bright) in pairwise(_TWILIGHT):
        if sun_alt <= high:
            return dark + (bright - dark) * (sun_alt - low) / (high - low)
    return _TWILIGHT[-1][1]


def _moon_light(at: Horizontal, moon: Moonlight) -> float:
    """Give the Moon's part of the sky's light (Krisciunas and Schaefer 1991, PASP 103, 1033)."""
    if moon.at.alt <= 0.0:
        return 0.0
    alpha, rho = abs(moon.phase_angle), max(1.0, angular_separation(at, moon.at))
    full = 10 ** (-0.4 * (3.84 + 0.026 * alpha + 4e-9 * alpha**4))
    cosine = math.cos(math.radians(rho))
    spread = 10**5.36 * (1.06 + cosine**2) + 10 ** (6.15 - rho / 40.0)
    k = 0.172
    nano = full * spread * 10 ** (-0.4 * k * _air(moon.at.alt))
    nano *= 1.0 - 10 ** (-0.4 * k * _air(at.alt))
    # Nanolamberts to magnitudes: their formula 1.
    return _light_of((20.7233 - math.log(nano / 34.08)) / 0.92104)


def _air(alt: float) -> float:
    # Their formula 3: of a thin layer, as scattered light passes it.
    return float((1.0 - 0.96 * math.cos(math.radians(max(0.0, alt))) ** 2) ** -0.5)
