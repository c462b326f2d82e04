"""Where a target stands: coordinates of date, altitude, hour angle. Pure."""

from __future__ import annotations

import importlib.util
import math
from functools import lru_cache
from typing import TYPE_CHECKING

from talaia.model.observing.targets import FixedTarget, IcrsTarget, SolarSystemTarget
from talaia.model.units import astronomy

if TYPE_CHECKING:
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.observing.targets import SolarSystemBody, Target

__all__ = [
    "EquatorialPlace",
    "altitude_of",
    "arcseconds_between",
    "hour_angle_of",
    "knows_bodies",
    "place_of_date",
    "sun_altitude",
]

_YEAR_DAYS = 365.25
# Between the times at which a body's place is worked out; the Moon goes 30″ in it, and straight.
_BODY_MARK_S = 60
_MAS = 1.0 / 3_600_000.0

# Right ascension (h) and declination (°).
EquatorialPlace = tuple[float, float]


def place_of_date(target: Target | None, time: float, place: Place) -> EquatorialPlace | None:
    """Give where a telescope at a place is sent for a target at a time (s since the epoch, UTC).

    Of a place among the stars, the mean place of date with its proper motion: nutation and
    aberration are left out, half an arc minute at the most, which centring mends. Of a body of the
    solar system, its apparent place, as seen from there.

    Returns:
        None without a target, and for a body where what works out its place is not installed.

    """
    match target:
        case None:
            return None
        case IcrsTarget():
            return _star_place(target, astronomy.julian_day(time))
        case FixedTarget():
            here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
            jd = astronomy.julian_day(time)
            return astronomy.horizontal_to_equatorial(target.altitude, target.azimuth, here, jd)
        case SolarSystemTarget():
            return _body_place(target.body, time, place) if knows_bodies() else None


def _star_place(target: IcrsTarget, jd: float) -> EquatorialPlace:
    years = (jd - astronomy.J2000) / _YEAR_DAYS + 2000.0 - target.epoch
    dec = target.dec + target.proper_motion_dec * _MAS * years
    dec = min(max(dec, -90.0), 90.0)
    ra = target.ra
    # At the pole no right ascension means anything.
    if (shrink := math.cos(math.radians(dec))) > 1e-9:
        ra += target.proper_motion_ra * _MAS * years / shrink
    # ICRS and the mean equinox J2000 differ by 0.02″.
    return astronomy.precess_coordinates(ra % 360.0 / 15.0, dec, astronomy.J2000, jd)


@lru_cache(maxsize=1)
def knows_bodies() -> bool:
    """Tell whether what works out the places of bodies is installed."""
    return importlib.util.find_spec("erfa") is not None


def _body_place(body: SolarSystemBody, time: float, place: Place) -> EquatorialPlace:
    mark, past = divmod(time, _BODY_MARK_S)
    where = place.latitude, place.longitude, place.elevation
    before, after = _body_directions(body, mark * _BODY_MARK_S, where)
    share = past / _BODY_MARK_S
    x, y, z = (a + share * (b - a) for a, b in zip(before, after, strict=True))
    ra = math.degrees(math.atan2(y, x)) % 360.0 / 15.0
    return ra, math.degrees(math.atan2(z, math.hypot(x, y)))


@lru_cache(maxsize=64)
def _body_directions(
    body: SolarSystemBody, start: float, where: tuple[float, float, float]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Give a body's direction (unit vector, equator of date) at a mark and at the next one."""
    # Here, so that nights without such a target do not keep its tables in memory.
    from talaia.planner.sky import TelescopePlace, compute_sky

    sky = compute_sky(TelescopePlace(*where), start, _BODY_MARK_S)
    track = sky.body_track(body)
    return tuple(map(float, track[:, 0])), tuple(map(float, track[:, 1]))


def arcseconds_between(one: EquatorialPlace, other: EquatorialPlace) -> float:
    """Give the angle between two places (″)."""
    (ra, dec), (other_ra, other_dec) = one, other
    separation = astronomy.angular_separation(
        astronomy.Horizontal(alt=dec, az=ra * 15.0),
        astronomy.Horizontal(alt=other_dec, az=other_ra * 15.0),
    )
    return separation * 3600.0


def altitude_of(where: EquatorialPlace, place: Place, time: float) -> float:
    """Give the altitude without refraction (°)."""
    here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
    jd = astronomy.julian_day(time)
    return astronomy.equatorial_to_horizontal(*where, here, jd).alt


def hour_angle_of(where: EquatorialPlace, place: Place, time: float) -> float:
    """Give how far past the meridian it is (h, -12 to 12)."""
    sidereal = astronomy.sidereal_hours(astronomy.julian_day(time), place.longitude)
    return (sidereal - where[0] + 12.0) % 24.0 - 12.0


def sun_altitude(place: Place, time: float) -> float:
    """Give the Sun's altitude without refraction (°)."""
    return altitude_of(astronomy.sun_position(astronomy.julian_day(time)), place, time)
