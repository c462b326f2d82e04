"""A site's map in its description: read, checked, and where its local frame lies on Earth."""

from __future__ import annotations

import math

import msgspec
import pytest
from astropy import units
from astropy.coordinates import EarthLocation
from hypothesis import given, strategies as st

from talaia.model.checks.site_checks import check_site
from talaia.model.maps.geodesy import GeodeticPlace, place_of_local
from talaia.model.site import Site

ORIGIN = {"latitude": 41.387, "longitude": 2.168}
RING = [[2.168, 41.387], [2.169, 41.387], [2.169, 41.388], [2.168, 41.387]]
YARD = {"name": "Yard", "kind": "fence", "geometry": {"type": "Polygon", "coordinates": [RING]}}


def findings(**more: object) -> dict[str, str]:
    said = {"talaia": 1, "site": "agv", "name": "Vehicle", **more}
    found = check_site(msgspec.convert(said, Site))
    # A site without devices is told of, too.
    return {one.where: one.problem for one in found if one.where != "$.devices"}


def ecef(place: GeodeticPlace) -> tuple[float, ...]:
    at = EarthLocation.from_geodetic(place.longitude * units.deg, place.latitude * units.deg)
    return tuple(part.to_value(units.m) for part in at.geocentric)


@given(
    st.floats(-89, 89),
    st.floats(-180, 180),
    st.floats(-1000, 1000),
    st.floats(-1000, 1000),
    st.floats(0, 360),
)
def test_a_local_place_is_as_far_on_earth_as_in_metres(lat, lon, x, y, heading) -> None:
    origin = GeodeticPlace(lat, lon)
    place = place_of_local(x, y, origin, heading)
    # Astropy's ellipsoid judges: straight through the ground, which a kilometre does not tell.
    assert math.dist(ecef(origin), ecef(place)) == pytest.approx(math.hypot(x, y), abs=0.01)


@pytest.mark.parametrize(
    ("heading", "north", "east"), [(90, 0, 100), (0, 100, 0), (180, -100, 0), (45, 70.71, 70.71)]
)
def test_x_of_a_local_frame_points_where_its_heading_says(heading, north, east) -> None:
    origin = GeodeticPlace(0.0, 10.0)
    place = place_of_local(100.0, 0.0, origin, heading)
    # On the equator a degree is 110 574 m to the north and 111 320 m to the east.
    assert (place.latitude - origin.latitude) * 110_574 == pytest.approx(north, abs=0.01)
    assert (place.longitude - origin.longitude) * 111_319.5 == pytest.approx(east, abs=0.01)


def test_a_map_with_zones_plans_and_a_grid_is_in_order() -> None:
    dock = {"name": "Dock", "kind": "dock", "geometry": {"type": "Point", "coordinates": [2, 41]}}
    plan = {"name": "Hall", "picture": "package://hall/floor.png", "resolution": 0.05}
    shown = {
        "origin": ORIGIN,
        "zones": {"yard": YARD, "dock": dock},
        "plans": {"hall": plan},
        "grid": "/map",
    }
    assert findings(map=shown, group="North", tags=["indoor", "night"]) == {}
    site = msgspec.convert({"talaia": 1, "site": "a", "name": "A", "map": shown}, Site)
    assert site.map is not None
    assert site.map.zones["dock"].geometry.lines() == [[(2.0, 41.0)]]
    assert site.map.zones["yard"].geometry.lines()[0][0] == (2.168, 41.387)


@pytest.mark.parametrize(
    ("coordinates", "where", "problem"),
    [
        ([RING[:3]], "[0]", "expected 4 to 10000 places, found 3"),
        ([[*RING[:3], [2.2, 41.3]]], "[0]", "the ring is not closed"),
        ([], "", "a Polygon has at least one ring"),
        ([[[41.387, 92.0]] * 4], "[0][0]", "41.387, 92 is no place on Earth"),
        ([[["2", "41"]] * 4], "[0][0]", "expected two numbers, found ['2', '41']"),
        (RING, "[0]", "expected 4 to 10000 places, found 2"),
    ],
)
def test_a_wrong_geometry_is_named_with_its_place(coordinates, where, problem) -> None:
    zone = {**YARD, "geometry": {"type": "Polygon", "coordinates": coordinates}}
    found = findings(map={"zones": {"yard": zone}})
    assert found == {f"$.map.zones.yard.geometry.coordinates{where}": problem}


def test_what_does_not_fit_together_is_said() -> None:
    plan = {"name": "Hall", "picture": "floor.png", "resolution": 0}
    zones = {"yard": {**YARD, "alarm": "fire", "interlock": "rain"}}
    found = findings(map={"zones": zones, "plans": {"hall": plan}}, tags=["a", "a"])
    assert set(found) == {
        "$.map.origin",
        "$.map.zones.yard.alarm",
        "$.map.zones.yard.interlock",
        "$.map.plans.hall.picture",
        "$.map.plans.hall.resolution",
        "$.tags[1]",
    }
    assert "$.map.origin.latitude" in findings(map={"origin": {**ORIGIN, "latitude": 91}})
