"""Where things stand in the sky of one place, at every minute of a night.

Directions are unit vectors in the true equator and equinox of date; a direction's altitude is its
scalar product with the zenith's, so that all targets at all minutes are one matrix product.
Geometric, without refraction. Formulas: SOFA, through ``pyerfa`` (precession and nutation IAU
2006/2000A, aberration to first order, Moon of Meeus 1998, planets of Simon 1994).
"""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple

import erfa
import numpy as np
from numpy.typing import NDArray

from talaia.model.observing.targets import SolarSystemBody

__all__ = ["MARK_S", "Floats", "NightSky", "TelescopePlace", "compute_sky", "find_night"]

Floats = NDArray[np.float64]

# Time between the marks at which the sky is worked out (s).
MARK_S = 60
_UNIX_EPOCH_JD = 2440587.5
_DAY_S = 86_400.0
_AU_KM = 149_597_870.7
_AU_PER_DAY_OF_LIGHT = 173.144_632_684_7
_EARTH_RADIUS_KM = 6378.137
# (1 - f)² of the WGS 84 ellipsoid.
_AXIS_RATIO_SQUARED = 0.993_305_62
# Between the places at which the Earth's orbit is worked out.
_NODE_DAYS = 1.0 / 12.0
# Of the Sun's centre at the night's start and end (°).
_NIGHT_SUN_ALTITUDE = -6.0
_PLANETS = {
    SolarSystemBody.MERCURY: 1,
    SolarSystemBody.VENUS: 2,
    SolarSystemBody.MARS: 4,
    SolarSystemBody.JUPITER: 5,
    SolarSystemBody.SATURN: 6,
    SolarSystemBody.URANUS: 7,
    SolarSystemBody.NEPTUNE: 8,
}


class TelescopePlace(NamedTuple):
    """Where a telescope stands: latitude and longitude (°, east positive), elevation (m)."""

    latitude: float
    longitude: float
    elevation: float = 0.0


class NightSky(NamedTuple):
    """The sky at ``n`` marks.

    Attributes:
        place: where.
        unix: of each mark (s since the epoch, UTC; n).
        zenith: direction of the zenith (3 × n).
        sun: direction of the Sun (3 × n).
        moon: direction of the Moon, seen from the place (3 × n).
        sun_altitude: (°; n).
        moon_altitude: (°; n).
        moon_illumination: lit fraction of the Moon (0 to 1; n).
        sidereal: local apparent sidereal time (rad; n).
        to_date: rotates ICRS to the equator of date (3 × 3).
        velocity: of the Earth, over that of light (3).

    """

    place: TelescopePlace
    unix: Floats
    zenith: Floats
    sun: Floats
    moon: Floats
    sun_altitude: Floats
    moon_altitude: Floats
    moon_illumination: Floats
    sidereal: Floats
    to_date: Floats
    velocity: Floats

    def at_mark(self, mark: int) -> NightSky:
        """Give the sky of one mark alone."""
        one = slice(mark, mark + 1)
        return self._replace(
            unix=self.unix[one],
            zenith=self.zenith[:, one],
            sun=self.sun[:, one],
            moon=self.moon[:, one],
            sun_altitude=self.sun_altitude[one],
            moon_altitude=self.moon_altitude[one],
            moon_illumination=self.moon_illumination[one],
            sidereal=self.sidereal[one],
        )

    def star_directions(self, ra: Floats, dec: Floats) -> Floats:
        """Give the apparent directions (n × 3) of places among the stars (ICRS, °)."""
        right, up = np.radians(ra), np.radians(dec)
        vectors = np.stack([np.cos(up) * np.cos(right), np.cos(up) * np.sin(right), np.sin(up)], 1)
        vectors += self.velocity
        vectors /= np.linalg.norm(vectors, axis=1)[:, None]
        return np.asarray(vectors @ self.to_date.T)

    def body_track(self, body: SolarSystemBody) -> Floats:
        """Give a solar-system body's direction at each mark (3 × n)."""
        if body is SolarSystemBody.MOON:
            return self.moon
        tt1, tt2 = _terrestrial_time(self.unix)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", erfa.ErfaWarning)
            earth = _earth_track(tt1, tt2)
            planet = np.asarray(erfa.plan94(tt1, tt2, _PLANETS[body])["p"])
            light_days = np.linalg.norm(planet - earth, axis=1) / _AU_PER_DAY_OF_LIGHT
            planet = np.asarray(erfa.plan94(tt1, tt2 - light_days, _PLANETS[body])["p"])
        vectors = planet - earth
        vectors /= np.linalg.norm(vectors, axis=1)[:, None]
        vectors += self.velocity
        vectors /= np.linalg.norm(vectors, axis=1)[:, None]
        return np.asarray(self.to_date @ vectors.T)

    def fixed_track(self, altitude: float, azimuth: float) -> Floats:
        """Give the direction (3 × n) of a place above the horizon (°; azimuth from north)."""
        north, east = self._horizon_axes()
        high, round_ = math.radians(altitude), math.radians(azimuth)
        level = math.cos(round_) * north + math.sin(round_) * east
        return np.asarray(math.cos(high) * level + math.sin(high) * self.zenith)

    def azimuths(self, directions: Floats) -> Floats:
        """Give the azimuth (°, from north through east; m × n) of directions (m × 3)."""
        north, east = self._horizon_axes()
        return np.asarray(np.degrees(np.arctan2(directions @ east, directions @ north)) % 360.0)

    def track_azimuths(self, track: Floats) -> Floats:
        """Give the azimuth (°; n) along a track (3 × n)."""
        north, east = self._horizon_axes()
        return np.asarray(
            np.degrees(np.arctan2((track * east).sum(0), (track * north).sum(0))) % 360.0
        )

    def _horizon_axes(self) -> tuple[Floats, Floats]:
        latitude = math.radians(self.place.latitude)
        cosine, sine = np.cos(self.sidereal), np.sin(self.sidereal)
        height = np.full_like(cosine, math.cos(latitude))
        north = np.stack([-math.sin(latitude) * cosine, -math.sin(latitude) * sine, height])
        return north, np.stack([-sine, cosine, np.zeros_like(cosine)])


def _utc(unix: Floats) -> tuple[float, Floats]:
    """Split times into a Julian day and the days since (UTC; no leap second is near)."""
    day = math.floor(float(unix[0]) / _DAY_S)
    return _UNIX_EPOCH_JD + day, unix / _DAY_S - day


def _terrestrial_time(unix: Floats) -> tuple[Floats, Floats]:
    with warnings.catch_warnings():
        # That leap seconds of a year to come are not known.
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        tai1, tai2 = erfa.utctai(*_utc(unix))
        tt1, tt2 = erfa.taitt(tai1, tai2)
    return np.asarray(tt1), np.asarray(tt2)


def compute_sky(place: TelescopePlace, start: float, length_s: int) -> NightSky:
    """Work out the sky from ``start`` (s since the epoch, UTC) at marks of `MARK_S` seconds."""
    unix = start + np.arange(length_s // MARK_S + 1, dtype=np.float64) * MARK_S
    tt1, tt2 = _terrestrial_time(unix)
    # Nutation moves by less than 0.01″ in half a night, and the Earth's velocity by 0.2″.
    middle1, middle2 = float(tt1[0]), float(tt2[len(tt2) // 2])
    to_date = np.asarray(erfa.pnm06a(middle1, middle2))
    _, barycentric = erfa.epv00(middle1, middle2)
    velocity = np.asarray(barycentric["v"]) / _AU_PER_DAY_OF_LIGHT
    # UT1 is within 0.9 s of UTC, and within 0.1 s in these years: 1.5″ at the most.
    utc1, utc2 = _utc(unix)
    sidereal = np.asarray(erfa.era00(utc1, utc2)) + math.radians(place.longitude)
    sidereal -= _equation_of_origins(tt1, tt2)
    zenith = _vertical(math.radians(place.latitude), sidereal)
    observer = _observer(place, sidereal)
    sun = -_earth_track(tt1, tt2)
    # Aberration turns a direction by the velocity over that of light.
    sun += velocity * np.linalg.norm(sun, axis=1)[:, None]
    sun = to_date @ sun.T - observer
    sun /= np.linalg.norm(sun, axis=0)
    moon = to_date @ np.asarray(erfa.moon98(tt1, tt2)["p"]).T - observer
    moon /= np.linalg.norm(moon, axis=0)
    return NightSky(
        place=place,
        unix=unix,
        zenith=zenith,
        sun=sun,
        moon=moon,
        sun_altitude=_altitudes(zenith, sun),
        moon_altitude=_altitudes(zenith, moon),
        moon_illumination=(1.0 - (sun * moon).sum(0)) / 2.0,
        sidereal=sidereal,
        to_date=to_date,
        velocity=velocity,
    )


def _equation_of_origins(tt1: Floats, tt2: Floats) -> Floats:
    """Give the Earth's rotation angle less Greenwich's apparent sidereal time (rad; n).

    It follows precession and nutation, which bend it by less than 0.01″ in a day and a half: so it
    is worked out at three marks.
    """
    some = [0, len(tt2) // 2, len(tt2) - 1]
    found: Floats = np.interp(tt2, tt2[some], np.asarray(erfa.eo06a(tt1[some], tt2[some])))
    return found


def _earth_track(tt1: Floats, tt2: Floats) -> Floats:
    """Give the Earth's place, from the Sun's centre (au; n × 3).

    The series has 1 200 terms, so it is summed every two hours. Between, a cubic through places
    and velocities (Hermite) is off by less than 10⁻¹⁰ au, which is 0.00002″.
    """
    nodes = tt2[0] + _NODE_DAYS * np.arange(int((tt2[-1] - tt2[0]) / _NODE_DAYS) + 2)
    heliocentric, _ = erfa.epv00(tt1[0], nodes)
    place = np.asarray(heliocentric["p"])
    way = np.asarray(heliocentric["v"]) * _NODE_DAYS
    before = ((tt2 - nodes[0]) / _NODE_DAYS).astype(np.intp)
    share = ((tt2 - nodes[before]) / _NODE_DAYS)[:, None]
    rest = 1.0 - share
    return np.asarray(
        rest**2 * ((1.0 + 2.0 * share) * place[before] + share * way[before])
        + share**2 * ((1.0 + 2.0 * rest) * place[before + 1] - rest * way[before + 1])
    )


def _vertical(latitude: float, sidereal: Floats) -> Floats:
    cosine = math.cos(latitude)
    height = np.full_like(sidereal, math.sin(latitude))
    return np.stack([cosine * np.cos(sidereal), cosine * np.sin(sidereal), height])


def _observer(place: TelescopePlace, sidereal: Floats) -> Floats:
    """Give where the place is, from the Earth's centre (au; 3 × n)."""
    latitude = math.radians(place.latitude)
    geocentric = math.atan2(_AXIS_RATIO_SQUARED * math.sin(latitude), math.cos(latitude))
    flattening = 1.0 - math.sqrt(_AXIS_RATIO_SQUARED)
    radius = _EARTH_RADIUS_KM * (1.0 - flattening * math.sin(latitude) ** 2)
    radius += place.elevation / 1000.0
    return radius / _AU_KM * _vertical(geocentric, sidereal)


def _altitudes(zenith: Floats, track: Floats) -> Floats:
    return np.asarray(np.degrees(np.arcsin(np.clip((zenith * track).sum(0), -1.0, 1.0))))


def find_night(place: TelescopePlace, time: float) -> tuple[float, int]:
    """Find the night at ``time``, or the next one: its start (s since the epoch, UTC), length (s).

    It begins and ends with the Sun at -6°. Where the Sun does not go so low in a day and a half,
    the night has no length, and where it stays lower, it lasts that day and a half.
    """
    base = math.floor(time / MARK_S) * float(MARK_S)
    before = 24 * 3600
    sky = compute_sky(place, base - before, before + 36 * 3600)
    dark = sky.sun_altitude <= _NIGHT_SUN_ALTITUDE
    now = before // MARK_S
    coming = np.flatnonzero(dark[now:])
    if not coming.size:
        return base, 0
    first = now + int(coming[0])
    while first > 0 and dark[first - 1]:
        first -= 1
    bright = np.flatnonzero(~dark[first:])
    marks = int(bright[0]) - 1 if bright.size else len(dark) - 1 - first
    return float(sky.unix[first]), marks * MARK_S
