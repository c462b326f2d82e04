"""Where a position lies to a zone: inside or outside, and how far from its edge. Pure."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

from talaia.model.maps.geodesy import GeodeticPlace, local_of_place, place_of_local
from talaia.model.site import PositionFrame

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.model.maps.site_map import MapZone, SiteMap
    from talaia.model.site import Signal

__all__ = ["FARTHEST_M", "Geofence", "place_of_position"]

# Farther away no position is one of the site's: most often it is 0, 0 of a receiver without a fix.
FARTHEST_M = 100_000.0

_Point = tuple[float, float]


class Geofence:
    """The ground of a zone, a polygon, on the plane that touches Earth at its first place.

    Straight between its places, as GeoJSON has it; of rings that lie within others every second
    one is a hole.
    """

    def __init__(self, zone: MapZone) -> None:
        """Lay it flat. `map_checks` and `interlock_checks` must have found no fault with it."""
        rings = zone.geometry.lines()
        longitude, latitude = rings[0][0]
        self._origin = GeodeticPlace(latitude, longitude)
        self._edges: list[tuple[_Point, _Point]] = []
        self._whole = True
        for ring in rings:
            points = [local_of_place(GeodeticPlace(lat, lon), self._origin) for lon, lat in ring]
            for start, end in itertools.pairwise(points):
                # A zone that goes around Earth has no plane, and nothing is known of it.
                if start is None or end is None:
                    self._whole = False
                else:
                    self._edges.append((start, end))

    def depth_of(self, place: GeodeticPlace | None) -> float | None:
        """Give how deep inside a place is: metres to the nearest edge, below 0 when outside.

        None when that cannot be known: it is no place, or too far away to be one of this site.
        """
        point = None if place is None else local_of_place(place, self._origin)
        if point is None or not self._whole or not self._edges:
            return None
        away = min(_distance(point, start, end) for start, end in self._edges)
        if not away <= FARTHEST_M:  # So written that NaN is unknown, too.
            return None
        inside = sum(_crosses(point, start, end) for start, end in self._edges) % 2 == 1
        return away if inside else -away

    def span(self) -> float:
        """Give how far its farthest place is from its first one (m)."""
        if not self._whole:
            return math.inf
        return max((math.hypot(*end) for _, end in self._edges), default=0.0)

    def area(self) -> float:
        """Give its ground (m²); that of holes counts as well."""
        twice = sum(x * v - u * y for (x, y), (u, v) in self._edges)
        return abs(twice) / 2

    def crossings(self) -> Iterator[_Point]:
        """Give where edges cross others (m east and north of the first place)."""
        for one, two in itertools.combinations(self._edges, 2):
            if _cross_properly(one, two):
                yield one[0]


def place_of_position(
    signal: Signal, numbers: Sequence[float], shown: SiteMap | None
) -> GeodeticPlace | None:
    """Give where a position is on Earth; None where that cannot be known.

    Args:
        signal: it; degrees, or metres of the site's local frame.
        numbers: its values, as `parts_of` names them.
        shown: the site's map, which says where the local frame is.

    """
    if len(numbers) < 2 or not all(math.isfinite(number) for number in numbers[:2]):
        return None
    first, second = numbers[0], numbers[1]
    if signal.frame is PositionFrame.WGS84:
        return GeodeticPlace(first, second)
    origin = None if shown is None else shown.origin
    # The same plane again: farther out it is nowhere near Earth.
    if origin is None or math.hypot(first, second) > FARTHEST_M:
        return None
    zero = GeodeticPlace(origin.latitude, origin.longitude)
    return place_of_local(first, second, zero, origin.heading)


def _distance(point: _Point, start: _Point, end: _Point) -> float:
    """Give how far a point is from a line between two others."""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    to_x, to_y = point[0] - start[0], point[1] - start[1]
    length = along_x * along_x + along_y * along_y
    share = 0.0 if length == 0 else (to_x * along_x + to_y * along_y) / length
    share = min(1.0, max(0.0, share))
    return math.hypot(to_x - share * along_x, to_y - share * along_y)


def _crosses(point: _Point, start: _Point, end: _Point) -> bool:
    """Tell whether a ray to the east of a point meets a line; a corner counts once."""
    x, y = point
    if (start[1] > y) == (end[1] > y):
        return False
    return x < start[0] + (y - start[1]) * (end[0] - start[0]) / (end[1] - start[1])


def _cross_properly(one: tuple[_Point, _Point], two: tuple[_Point, _Point]) -> bool:
    """Tell whether two lines cross between their ends; lines that only touch do not."""
    (a, b), (c, d) = one, two
    return _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0


def _side(start: _Point, end: _Point, point: _Point) -> float:
    along = (end[0] - start[0]) * (point[1] - start[1])
    across = (end[1] - start[1]) * (point[0] - start[0])
    return math.copysign(1.0, along - across) if along != across else 0.0
