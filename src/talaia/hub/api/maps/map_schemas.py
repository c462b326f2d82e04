"""What is said about maps."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from talaia.hub.store.sites.map_sources import SourceKind
from talaia.model.maps.site_map import GeometryType, ZoneKind  # noqa: TC001 - pydantic reads it

__all__ = [
    "FloorPlanShape",
    "MapFile",
    "MapLineShape",
    "MapOffer",
    "MapOriginShape",
    "MapSession",
    "MapSourceAsk",
    "MapSourceMade",
    "MapSourceShape",
    "MapZoneShape",
    "SiteMapShape",
]


class _Shape(BaseModel):
    """A key that is not described is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class MapOriginShape(_Shape):
    """Where the local frame's zero is (°), and where its x points (°, clockwise from north)."""

    latitude: float
    longitude: float
    heading: float


class MapLineShape(_Shape):
    """Places in turn (°)."""

    latitudes: list[float]
    longitudes: list[float]


class MapZoneShape(_Shape):
    """A zone: one line, a ring for each of a polygon's, or one place of a point."""

    id: str
    name: str
    kind: ZoneKind
    type: GeometryType
    lines: list[MapLineShape]
    alarm: str
    interlock: str


class FloorPlanShape(_Shape):
    """A picture in the local frame: its lower left corner (m), turned by ``rotation`` (°)."""

    id: str
    name: str
    picture: str
    x: float
    y: float
    rotation: float
    resolution: float


class SiteMapShape(_Shape):
    """What a site draws on a map; ``grid`` is a topic of its robot, or empty."""

    origin: MapOriginShape | None
    zones: list[MapZoneShape]
    plans: list[FloorPlanShape]
    grid: str


class MapFile(_Shape):
    """A PMTiles file of the hub's folder; ``url`` takes range requests."""

    name: str
    url: str


class MapSourceShape(_Shape):
    """A tile server that an admin allowed. ``tiles``: its address, empty where a session says it.

    ``host``: what a browser asks that shows it, and so learns where somebody looks.
    """

    id: str
    name: str
    kind: SourceKind
    host: str
    tiles: str
    attribution: str
    most_zoom: int


class MapOffer(_Shape):
    """The maps that a page may show, besides the coarse world that it brings along."""

    files: list[MapFile]
    sources: list[MapSourceShape]


class MapSourceAsk(_Shape):
    """A tile server to allow.

    ``address``: ``https://host/{z}/{x}/{y}.png``; empty for Google, which takes ``key`` instead.
    """

    name: str = Field(min_length=1, max_length=100)
    kind: SourceKind = SourceKind.TILES
    address: str = Field(default="", max_length=500)
    attribution: str = Field(default="", max_length=200)
    most_zoom: int = Field(default=19, ge=0, le=24)
    key: str = Field(default="", max_length=200)


class MapSourceMade(_Shape):
    """The id of what was kept."""

    id: str


class MapSession(_Shape):
    """A session of a map that is asked by one: the address of its tiles, good until ``ends_us``."""

    tiles: str
    ends_us: int
