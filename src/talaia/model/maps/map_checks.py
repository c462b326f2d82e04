"""Checks of a site's map."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, finding_of, id_fits, name_fits, topic_fits
from talaia.model.errors import UnknownWord
from talaia.model.maps.site_map import GeometryType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.maps.site_map import FloorPlan, MapZone, ZoneGeometry
    from talaia.model.site import Site

__all__ = ["geometry_findings", "map_findings", "tag_findings"]

_MOST = 500  # Zones, and plans.
_MOST_PLACES = 10_000  # Of one zone.
_MOST_TAGS = 20
_SHORTEST = {GeometryType.LINE: 2, GeometryType.POLYGON: 4}
_PACKAGE = "package://"


def map_findings(site: Site) -> Iterator[Finding]:
    """Look at the origin, each zone and each plan."""
    shown = site.map
    if shown is None:
        return
    if (origin := shown.origin) is not None:
        yield from _degrees_fit("$.map.origin", origin.latitude, origin.longitude)
        if not math.isfinite(origin.heading):
            yield Finding("$.map.origin.heading", "it is no number", "write degrees from north")
    for many, key in ((shown.zones, "zones"), (shown.plans, "plans")):
        if len(many) > _MOST:
            yield Finding(f"$.map.{key}", f"more than {_MOST}", "leave some out")
    for name, zone in shown.zones.items():
        yield from _zone_fits(site, f"$.map.zones.{name}", name, zone)
    for name, plan in shown.plans.items():
        yield from _plan_fits(f"$.map.plans.{name}", name, plan)
    if shown.grid:
        yield from topic_fits("$.map.grid", shown.grid)
    if shown.origin is None and (shown.plans or shown.grid):
        problem = "plans and grids lie in the local frame, and nothing says where that is"
        yield Finding("$.map.origin", problem, "write latitude and longitude of its zero")


def tag_findings(site: Site) -> Iterator[Finding]:
    """Look at the words by which a site is found among many."""
    if site.group:
        yield from name_fits("$.group", site.group)
    if len(site.tags) > _MOST_TAGS:
        yield Finding("$.tags", f"more than {_MOST_TAGS} tags", "leave some out")
    for index, tag in enumerate(site.tags):
        yield from name_fits(f"$.tags[{index}]", tag)
        if tag in site.tags[:index]:
            yield Finding(f"$.tags[{index}]", f"{tag!r} stands there twice", "leave one out")


def _degrees_fit(where: str, latitude: float, longitude: float) -> Iterator[Finding]:
    # A NaN fits nowhere.
    if not -90 <= latitude <= 90:
        problem = f"expected −90 to 90, found {latitude:g}"
        yield Finding(f"{where}.latitude", problem, "write degrees north")
    if not -180 <= longitude <= 180:
        problem = f"expected −180 to 180, found {longitude:g}"
        yield Finding(f"{where}.longitude", problem, "write degrees east")


def _zone_fits(site: Site, where: str, name: str, zone: MapZone) -> Iterator[Finding]:
    yield from id_fits(where, name)
    yield from name_fits(f"{where}.name", zone.name)
    yield from geometry_findings(f"{where}.geometry.coordinates", zone.geometry)
    if zone.alarm and zone.alarm not in site.alarms:
        yield finding_of(UnknownWord(f"{where}.alarm", "alarm", zone.alarm, list(site.alarms)))
    if zone.interlock and zone.interlock not in site.interlocks:
        known = list(site.interlocks)
        yield finding_of(UnknownWord(f"{where}.interlock", "interlock", zone.interlock, known))


def geometry_findings(where: str, geometry: ZoneGeometry) -> Iterator[Finding]:
    """Look at the places of a zone; ``where`` is that of its coordinates."""
    kind, given = geometry.type, geometry.coordinates
    if kind is GeometryType.POINT:
        yield from _place_fits(where, given)
        return
    rings = given if kind is GeometryType.POLYGON else (given,)
    if not rings:
        yield Finding(
            where, "a Polygon has at least one ring", "write [[[longitude, latitude], …]]"
        )
    for index, ring in enumerate(rings):
        at = f"{where}[{index}]" if kind is GeometryType.POLYGON else where
        if not isinstance(ring, list | tuple):
            yield Finding(at, f"expected a list of places, found {ring!r}", _remedy_of(kind))
            return
        if not _SHORTEST[kind] <= len(ring) <= _MOST_PLACES:
            problem = f"expected {_SHORTEST[kind]} to {_MOST_PLACES} places, found {len(ring)}"
            yield Finding(at, problem, _remedy_of(kind))
            return
        for place, found in enumerate(ring):
            findings = list(_place_fits(f"{at}[{place}]", found))
            yield from findings
            if findings:
                return  # Most often all are written the same wrong way.
        if kind is GeometryType.POLYGON and list(ring[0]) != list(ring[-1]):
            yield Finding(at, "the ring is not closed", "end it with its first place")


def _remedy_of(kind: GeometryType) -> str:
    if kind is GeometryType.POLYGON:
        return "write [[[longitude, latitude], …]], each ring closed"
    return "write [[longitude, latitude], …]"


def _place_fits(where: str, place: object) -> Iterator[Finding]:
    numbers = place if isinstance(place, list | tuple) else ()
    # A third one is a height, which GeoJSON allows and a map does not show.
    if len(numbers) not in {2, 3} or not all(
        isinstance(number, int | float) and not isinstance(number, bool) for number in numbers
    ):
        yield Finding(
            where, f"expected two numbers, found {place!r}", "write [longitude, latitude]"
        )
        return
    longitude, latitude = float(numbers[0]), float(numbers[1])
    if not (-180 <= longitude <= 180 and -90 <= latitude <= 90):
        problem = f"{longitude:g}, {latitude:g} is no place on Earth"
        yield Finding(where, problem, "write [longitude, latitude], in this order")


def _plan_fits(where: str, name: str, plan: FloorPlan) -> Iterator[Finding]:
    yield from id_fits(where, name)
    yield from name_fits(f"{where}.name", plan.name)
    if not plan.picture.startswith(_PACKAGE):
        remedy = "write package://<package>/<file>, which lies in the hub's --assets folder"
        yield Finding(f"{where}.picture", f"{plan.picture!r} is no such address", remedy)
    if not (plan.resolution > 0 and math.isfinite(plan.resolution)):
        yield Finding(f"{where}.resolution", "it is not above zero", "write metres for each pixel")
    for key in ("x", "y", "rotation"):
        if not math.isfinite(getattr(plan, key)):
            yield Finding(f"{where}.{key}", "it is no number", "write one")
