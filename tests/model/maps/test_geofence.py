"""Zones as fences: inside or outside, and how far from the edge, judged by others' mathematics."""

from __future__ import annotations

import math

import pytest
from astropy import units
from astropy.coordinates import EarthLocation
from hypothesis import given, strategies as st

from talaia.model.connection import RosSource
from talaia.model.maps.geodesy import GeodeticPlace, local_of_place, place_of_local
from talaia.model.maps.geofence import FARTHEST_M, Geofence, place_of_position
from talaia.model.maps.site_map import (
    GeometryType,
    MapOrigin,
    MapZone,
    SiteMap,
    ZoneGeometry,
)
from talaia.model.site import PositionFrame, Signal, SignalType

pytestmark = pytest.mark.pure

ORIGIN = GeodeticPlace(41.387, 2.168)
# Anywhere but at the poles, where east is not one direction.
ORIGINS = st.builds(GeodeticPlace, st.floats(-85, 85), st.floats(-180, 180))
METRES = st.floats(-900, 900)


def at(x: float, y: float, origin: GeodeticPlace = ORIGIN) -> GeodeticPlace:
    return place_of_local(x, y, origin)


def fence(*rings: list[tuple[float, float]], origin: GeodeticPlace = ORIGIN) -> Geofence:
    """A polygon of rings in metres east and north of the origin; each is closed here."""
    places = [[at(x, y, origin) for x, y in (*ring, ring[0])] for ring in rings]
    coordinates = tuple([[p.longitude, p.latitude] for p in ring] for ring in places)
    geometry = ZoneGeometry(type=GeometryType.POLYGON, coordinates=coordinates)
    return Geofence(MapZone(name="Yard", geometry=geometry))


SQUARE = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]
HOLE = [(40.0, 40.0), (60.0, 40.0), (60.0, 60.0), (40.0, 60.0)]


@pytest.mark.parametrize(
    ("x", "y", "depth"),
    [
        (50, 10, 10), (99, 50, 1), (50, 50, -10), (45, 50, -5), (150, 50, -50), (-30, -40, -50),
        (35, 50, 5),
    ],
)  # fmt: skip
def test_depth_is_metres_to_the_nearest_edge_and_a_hole_is_outside(x, y, depth) -> None:
    assert fence(SQUARE, HOLE).depth_of(at(x, y)) == pytest.approx(depth, abs=0.01)


def winding(point: tuple[float, float], ring: list[tuple[float, float]]) -> int:
    """How often a ring goes round a point: by angles, which share nothing with a ray."""
    turned = 0.0
    for (ax, ay), (bx, by) in zip(ring, [*ring[1:], ring[0]], strict=True):
        one = math.atan2(ay - point[1], ax - point[0])
        two = math.atan2(by - point[1], bx - point[0])
        turned += math.remainder(two - one, math.tau)
    return round(turned / math.tau)


@st.composite
def stars(draw) -> list[tuple[float, float]]:
    """Rings without crossings: places around a middle, in the order of their angles."""
    many = draw(st.integers(3, 12))
    reach = draw(st.lists(st.floats(5, 800), min_size=many, max_size=many))
    turn = [math.tau * number / many for number in range(many)]
    return [(r * math.cos(a), r * math.sin(a)) for r, a in zip(reach, turn, strict=True)]


@given(stars(), METRES, METRES, ORIGINS)
def test_inside_is_where_the_ring_goes_round_wherever_on_earth(ring, x, y, origin) -> None:
    depth = fence(ring, origin=origin).depth_of(at(x, y, origin))
    assert depth is not None
    # A millimetre from the edge both are right.
    if abs(depth) > 0.01:
        assert (depth > 0) == (winding((x, y), ring) != 0)


@given(stars(), METRES, METRES, METRES, METRES)
def test_depth_changes_by_no_more_than_the_robot_moves(ring, x, y, dx, dy) -> None:
    yard = fence(ring)
    one, two = yard.depth_of(at(x, y)), yard.depth_of(at(dx, dy))
    assert one is not None
    assert two is not None
    assert abs(one - two) <= math.hypot(x - dx, y - dy) + 0.02


@given(ORIGINS, st.floats(-90, 90), st.floats(-180, 180))
def test_a_plane_knows_a_place_as_astropy_has_it_or_not_at_all(origin, lat, lon) -> None:
    found = local_of_place(GeodeticPlace(lat, lon), origin)
    here, there = (
        EarthLocation.from_geodetic(p.longitude * units.deg, p.latitude * units.deg)
        for p in (origin, GeodeticPlace(lat, lon))
    )
    chord = math.dist(
        [part.to_value(units.m) for part in here.geocentric],
        [part.to_value(units.m) for part in there.geocentric],
    )
    # Flat is never farther than straight through Earth, and the other side is nowhere.
    if found is not None:
        assert math.hypot(*found) <= chord + 0.001
    if chord < 9_000:
        assert found is not None
        assert math.hypot(*found) == pytest.approx(chord, abs=0.01)
    if chord > 10_000_000:
        assert found is None


@given(st.floats(-90, 90), st.floats(-180, 180))
def test_what_is_far_away_is_unknown_and_never_outside(lat, lon) -> None:
    yard = fence(SQUARE)
    depth = yard.depth_of(GeodeticPlace(lat, lon))
    assert depth is None or abs(depth) <= FARTHEST_M


@pytest.mark.parametrize("lat", [math.nan, math.inf, 91.0])
def test_no_place_on_earth_is_unknown(lat) -> None:
    assert fence(SQUARE).depth_of(GeodeticPlace(lat, 2.0)) is None
    # A receiver without a fix says 0, 0.
    assert fence(SQUARE).depth_of(GeodeticPlace(0.0, 0.0)) is None
    # The other side of Earth, where the plane would show it again.
    assert fence(SQUARE).depth_of(GeodeticPlace(-41.387, 2.168 - 180)) is None


def position(frame: PositionFrame) -> Signal:
    return Signal(name="Fix", type=SignalType.POSITION, frame=frame, source=RosSource())


@pytest.mark.parametrize("numbers", [(), (1.0,), (math.nan, 1.0), (1.0, math.inf), (1e9, 0.0)])
def test_a_position_that_is_not_whole_is_nowhere(numbers) -> None:
    shown = SiteMap(origin=MapOrigin(latitude=41.387, longitude=2.168))
    assert place_of_position(position(PositionFrame.LOCAL), numbers, shown) is None


def test_metres_are_placed_by_the_origin_and_nowhere_without_it() -> None:
    local = position(PositionFrame.LOCAL)
    shown = SiteMap(origin=MapOrigin(latitude=41.387, longitude=2.168))
    assert place_of_position(local, (100.0, 50.0, 0.0), shown) == at(100, 50)
    assert place_of_position(local, (100.0, 50.0, 0.0), SiteMap()) is None
    assert place_of_position(local, (100.0, 50.0, 0.0), None) is None
    globe = position(PositionFrame.WGS84)
    assert place_of_position(globe, (41.0, 2.0, 9.0), None) == GeodeticPlace(41.0, 2.0)


def test_a_zone_says_how_wide_it_is_and_where_its_lines_cross() -> None:
    assert fence(SQUARE).span() == pytest.approx(141.42, abs=0.01)
    assert fence(SQUARE).area() == pytest.approx(10_000, rel=1e-5)
    assert list(fence(SQUARE, HOLE).crossings()) == []
    bow = [(0.0, 0.0), (100.0, 100.0), (100.0, 0.0), (0.0, 100.0)]
    assert len(list(fence(bow).crossings())) == 1
