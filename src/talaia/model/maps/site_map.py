"""What a site's map shows beside its robots, as values."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

import msgspec

from talaia.model.base import Shape

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = [
    "FloorPlan",
    "GeometryType",
    "MapOrigin",
    "MapZone",
    "SiteMap",
    "ZoneGeometry",
    "ZoneKind",
    "zone_meaning",
]


class MapOrigin(Shape, frozen=True, kw_only=True):
    """Where the zero of the site's local frame lies on Earth.

    With it, positions in metres stand on the map, too.

    Attributes:
        latitude: degrees north (WGS 84).
        longitude: degrees east.
        heading: where the frame's x points, clockwise from true north (°); 90 is east, as REP-105
            has it for a map frame.

    """

    latitude: float
    longitude: float
    heading: float = 90.0


class ZoneKind(StrEnum):
    """What a zone is for, and how it is drawn. What stops a robot is an interlock that names it."""

    ZONE = "zone"
    FENCE = "fence"
    DOCK = "dock"


class GeometryType(StrEnum):
    """The shapes of GeoJSON (RFC 7946) that a zone may have."""

    POINT = "Point"
    LINE = "LineString"
    POLYGON = "Polygon"


class ZoneGeometry(Shape, frozen=True, kw_only=True):
    """A geometry of GeoJSON.

    Attributes:
        type: which one it is.
        coordinates: ``[longitude, latitude]`` (°, WGS 84) of a point, a list of such places for a
            line, and a list of closed rings for a polygon, the outer one first.

    """

    type: GeometryType
    coordinates: tuple[object, ...]

    def lines(self) -> list[list[tuple[float, float]]]:
        """Give longitude and latitude (°) of each place: a polygon's rings, or one line.

        Only of what `map_checks` found no fault with.
        """
        nested: object = self.coordinates
        if self.type is GeometryType.POINT:
            nested = [[nested]]
        elif self.type is GeometryType.LINE:
            nested = [nested]
        lines = msgspec.convert(nested, list[list[list[float]]])
        return [[(place[0], place[1]) for place in line] for line in lines]


class MapZone(Shape, frozen=True, kw_only=True):
    """A part of the ground that has a name.

    Attributes:
        name: what people call it.
        kind: how it is drawn; see `ZoneKind`.
        geometry: where it is.
        alarm: of `Site.alarms`: while it is raised, the zone is drawn so.
        interlock: of `Site.interlocks`: while it holds, the zone is drawn so.

    """

    name: str
    kind: ZoneKind = ZoneKind.ZONE
    geometry: ZoneGeometry
    alarm: str = ""
    interlock: str = ""


class FloorPlan(Shape, frozen=True, kw_only=True):
    """A picture of a floor, placed as a map of ROS is: in the local frame, by one corner.

    Attributes:
        name: what people call it.
        picture: ``package://<package>/<path>`` in the hub's folder of ``--assets``: PNG or JPEG.
        x: where its lower left corner is (m).
        y: the same (m).
        rotation: of the picture about that corner, counter-clockwise (°).
        resolution: length of one pixel (m).

    """

    name: str
    picture: str
    x: float = 0.0
    y: float = 0.0
    rotation: float = 0.0
    resolution: float


class SiteMap(Shape, frozen=True, kw_only=True):
    """The site's map.

    Attributes:
        origin: where its local frame is on Earth; without it metres stay on a plain grid.
        zones: by name; see `MapZone`.
        plans: of floors, by name; see `FloorPlan`.
        grid: a topic of ``nav_msgs/msg/OccupancyGrid`` in the local frame, or empty.

    """

    origin: MapOrigin | None = None
    zones: dict[str, MapZone] = {}
    plans: dict[str, FloorPlan] = {}
    grid: str = ""


def zone_meaning(site: Site, name: str) -> object:
    """Give all that decides where a zone lies to a position; not its name or look."""
    shown = site.map
    if shown is None or name not in shown.zones:
        return None
    return shown.zones[name].geometry, shown.origin
