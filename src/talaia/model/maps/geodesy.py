"""Places on the ellipsoid of WGS 84 and on the plane that touches it at an origin. Pure."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["GeodeticPlace", "local_of_place", "place_of_local"]

# Half the greater axis (m) and the flattening of WGS 84.
_AXIS = 6_378_137.0
_FLATTENING = 1 / 298.257223563
_ECC2 = _FLATTENING * (2 - _FLATTENING)


class GeodeticPlace(NamedTuple):
    """Degrees north and east."""

    latitude: float
    longitude: float


def local_of_place(place: GeodeticPlace, origin: GeodeticPlace) -> tuple[float, float] | None:
    """Give how far east and north (m) a place is on the plane that touches at ``origin``.

    None where it is not on that side of Earth, or no place at all: a plane has no such point.
    """
    if not (abs(place.latitude) <= 90 and abs(place.longitude) <= 180):
        return None
    lat, lon = math.radians(origin.latitude), math.radians(origin.longitude)
    here, there = _earth_centred(origin), _earth_centred(place)
    d_x, d_y, d_z = (to - at for at, to in zip(here, there, strict=True))
    across = d_x * math.cos(lon) + d_y * math.sin(lon)
    # Beyond the horizon by a quarter of Earth the plane would show it again from behind.
    if across * math.cos(lat) + d_z * math.sin(lat) < -_AXIS / 2:
        return None
    east = d_y * math.cos(lon) - d_x * math.sin(lon)
    return east, d_z * math.cos(lat) - across * math.sin(lat)


def _earth_centred(place: GeodeticPlace) -> tuple[float, float, float]:
    lat, lon = math.radians(place.latitude), math.radians(place.longitude)
    normal = _AXIS / math.sqrt(1 - _ECC2 * math.sin(lat) ** 2)
    across = normal * math.cos(lat)
    return across * math.cos(lon), across * math.sin(lon), normal * (1 - _ECC2) * math.sin(lat)


def place_of_local(
    x: float, y: float, origin: GeodeticPlace, heading: float = 90.0
) -> GeodeticPlace:
    """Give the place at ``x``, ``y`` (m) of a local frame on the plane that touches at ``origin``.

    Args:
        x: along the frame's first axis (m).
        y: to the left of it (m).
        origin: of the frame, on the ellipsoid.
        heading: of the first axis, clockwise from true north (°).

    """
    turn = math.radians(heading)
    east = x * math.sin(turn) - y * math.cos(turn)
    north = x * math.cos(turn) + y * math.sin(turn)
    lat, lon = math.radians(origin.latitude), math.radians(origin.longitude)
    sin_lat, cos_lat, sin_lon, cos_lon = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    normal = _AXIS / math.sqrt(1 - _ECC2 * sin_lat**2)
    # Earth-centred (m).
    at_x = normal * cos_lat * cos_lon - east * sin_lon - north * sin_lat * cos_lon
    at_y = normal * cos_lat * sin_lon + east * cos_lon - north * sin_lat * sin_lon
    at_z = normal * (1 - _ECC2) * sin_lat + north * cos_lat
    # Bowring's way; one step is exact to far below a millimetre near the ground.
    across = math.hypot(at_x, at_y)
    minor = _AXIS * (1 - _FLATTENING)
    reduced = math.atan2(at_z * _AXIS, across * minor)
    second = _ECC2 / (1 - _ECC2)
    latitude = math.atan2(
        at_z + second * minor * math.sin(reduced) ** 3,
        across - _ECC2 * _AXIS * math.cos(reduced) ** 3,
    )
    return GeodeticPlace(math.degrees(latitude), math.degrees(math.atan2(at_y, at_x)))
