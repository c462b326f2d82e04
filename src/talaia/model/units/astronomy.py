"""Where things stand in the sky: sidereal time, horizon coordinates, Sun, precession. Pure.

Formulas from J. Meeus, *Astronomical Algorithms*, 2nd edition (chapters 7, 12, 13, 17, 21, 25).
Angles in degrees, right ascension in hours, azimuth from north through east, longitude positive to
the east. Refraction, nutation and aberration are left out: together at most half an arc minute
above 30° of altitude, far below what a dome or a limit cares for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = [
    "J2000",
    "Horizontal",
    "Observer",
    "angular_separation",
    "equatorial_to_horizontal",
    "horizontal_to_equatorial",
    "julian_day",
    "precess_coordinates",
    "sidereal_hours",
    "sun_position",
]

# 2000 January 1, 12 h, as a Julian day.
J2000 = 2451545.0


class Observer(NamedTuple):
    """A place on Earth: degrees north, degrees east, metres."""

    latitude: float
    longitude: float
    elevation: float = 0.0


class Horizontal(NamedTuple):
    """Altitude above the horizon and azimuth (°)."""

    alt: float
    az: float


def julian_day(unix_s: float) -> float:
    """Give the Julian day of a time in seconds since 1970 UTC (UT1 is taken as UTC)."""
    # 2440587.5 is the Julian day of 1970 January 1, 0 h.
    return unix_s / 86400.0 + 2440587.5


def sidereal_hours(jd: float, longitude: float) -> float:
    """Give the local mean sidereal time (h); Meeus 12.4."""
    # Julian centuries since J2000.
    t = (jd - J2000) / 36525.0
    degrees = 280.46061837 + 360.98564736629 * (jd - J2000) + t * t * (0.000387933 - t / 38710000.0)
    return (degrees + longitude) % 360.0 / 15.0


def equatorial_to_horizontal(ra: float, dec: float, place: Observer, jd: float) -> Horizontal:
    """Turn right ascension (h) and declination (°) of date to the horizon; Meeus 13.5, 13.6."""
    hour = math.radians((sidereal_hours(jd, place.longitude) - ra) * 15.0)
    d, lat = math.radians(dec), math.radians(place.latitude)
    sine = math.sin(lat) * math.sin(d) + math.cos(lat) * math.cos(d) * math.cos(hour)
    # Meeus counts azimuths from the south: the signs of both turn them to the north.
    y = -math.cos(d) * math.sin(hour)
    x = math.sin(d) * math.cos(lat) - math.cos(d) * math.sin(lat) * math.cos(hour)
    # Not the arc sine, which loses half its digits near the zenith.
    alt = math.degrees(math.atan2(sine, math.hypot(x, y)))
    return Horizontal(alt, math.degrees(math.atan2(y, x)) % 360.0)


def horizontal_to_equatorial(
    alt: float, az: float, place: Observer, jd: float
) -> tuple[float, float]:
    """Turn altitude and azimuth to right ascension (h) and declination (°) of date."""
    a, z, lat = math.radians(alt), math.radians(az), math.radians(place.latitude)
    sine = math.sin(lat) * math.sin(a) + math.cos(lat) * math.cos(a) * math.cos(z)
    y = -math.cos(a) * math.sin(z)
    x = math.sin(a) * math.cos(lat) - math.cos(a) * math.sin(lat) * math.cos(z)
    hour = math.degrees(math.atan2(y, x)) / 15.0
    dec = math.degrees(math.atan2(sine, math.hypot(x, y)))
    return (sidereal_hours(jd, place.longitude) - hour) % 24.0, dec


def sun_position(jd: float) -> tuple[float, float]:
    """Give the Sun's apparent right ascension (h) and declination (°); Meeus 25, within 0.01°."""
    t = (jd - J2000) / 36525.0
    # Mean longitude and mean anomaly, 25.2 and 25.3.
    mean = 280.46646 + 36000.76983 * t + 0.0003032 * t * t
    m = math.radians(357.52911 + 35999.05029 * t - 0.0001537 * t * t)
    # The equation of the centre.
    centre = (
        (1.914602 - 0.004817 * t - 0.000014 * t * t) * math.sin(m)
        + (0.019993 - 0.000101 * t) * math.sin(2 * m)
        + 0.000289 * math.sin(3 * m)
    )
    # The Moon's node, for nutation; with it and aberration the longitude is the apparent one.
    node = math.radians(125.04 - 1934.136 * t)
    longitude = math.radians(mean + centre - 0.00569 - 0.00478 * math.sin(node))
    # The mean obliquity with the correction that 25.8 has for apparent places.
    tilt = math.radians(23.439291 - 0.0130042 * t + 0.00256 * math.cos(node))
    ra = math.atan2(math.cos(tilt) * math.sin(longitude), math.cos(longitude))
    dec = math.asin(math.sin(tilt) * math.sin(longitude))
    return math.degrees(ra) / 15.0 % 24.0, math.degrees(dec)


def precess_coordinates(ra: float, dec: float, jd_from: float, jd_to: float) -> tuple[float, float]:
    """Carry coordinates from one mean equinox to another; Meeus 21.2 to 21.4."""
    # Centuries from J2000 to the first equinox, and from that to the second.
    big, t = (jd_from - J2000) / 36525.0, (jd_to - jd_from) / 36525.0
    lead = 2306.2181 + 1.39656 * big - 0.000139 * big * big
    zeta = lead * t + (0.30188 - 0.000344 * big) * t * t + 0.017998 * t**3
    z = lead * t + (1.09468 + 0.000066 * big) * t * t + 0.018203 * t**3
    theta = (
        (2004.3109 - 0.85330 * big - 0.000217 * big * big) * t
        - (0.42665 + 0.000217 * big) * t * t
        - 0.041833 * t**3
    )
    # Arc seconds until here.
    zeta, z, theta = (math.radians(arcseconds / 3600.0) for arcseconds in (zeta, z, theta))
    a, d = math.radians(ra * 15.0) + zeta, math.radians(dec)
    first = math.cos(d) * math.sin(a)
    second = math.cos(theta) * math.cos(d) * math.cos(a) - math.sin(theta) * math.sin(d)
    third = math.sin(theta) * math.cos(d) * math.cos(a) + math.cos(theta) * math.sin(d)
    ra_to = math.degrees(math.atan2(first, second) + z) / 15.0 % 24.0
    return ra_to, math.degrees(math.atan2(third, math.hypot(first, second)))


def angular_separation(one: Horizontal, other: Horizontal) -> float:
    """Give the angle between two directions (°); Vincenty's form, good at every angle."""
    a1, a2 = math.radians(one.alt), math.radians(other.alt)
    dz = math.radians(other.az - one.az)
    y = math.hypot(
        math.cos(a2) * math.sin(dz),
        math.cos(a1) * math.sin(a2) - math.sin(a1) * math.cos(a2) * math.cos(dz),
    )
    x = math.sin(a1) * math.sin(a2) + math.cos(a1) * math.cos(a2) * math.cos(dz)
    return math.degrees(math.atan2(y, x))
