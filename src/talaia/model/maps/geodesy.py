"""Places on the ellipsoid of WGS 84 and on the plane that touches it at an origin. Pure."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["GeodeticPlace", "place_of_local"]

# Half the greater axis (m) and the flattening of WGS 84.
_AXIS = 6_378_137.0
_FLATTENING = 1 / 298.257223563
_ECC2 = _FLATTENING * (2 - _FLATTENING)


class GeodeticPlace(NamedTuple):
    """Degrees north and east."""

    latitude: float
    longitude: float


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
