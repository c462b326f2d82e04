"""Interlocks that go by where a robot is: permitted only by a position that is known and right."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.interlocks import Interlocks
from talaia.model.checks.site_checks import check_site
from talaia.model.interlocks.override_rules import condition_id, condition_label
from talaia.model.maps.geodesy import GeodeticPlace, place_of_local
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure

ORIGIN = GeodeticPlace(41.387, 2.168)


def ring(*places: tuple[float, float]) -> str:
    """Write places in metres east and north of the origin as a closed ring of GeoJSON."""
    found = [place_of_local(x, y, ORIGIN) for x, y in (*places, places[0])]
    return str([[place.longitude, place.latitude] for place in found])


YARD = ring((0, 0), (100, 0), (100, 100), (0, 100))
PIT = ring((40, 40), (60, 40), (60, 60), (40, 60))
OUTSIDE = "{signal: base/fix, outside: yard, margin: 2}"
DESCRIPTION = f"""
talaia: 1
site: s
name: S
ros2: {{}}
map:
  origin: {{latitude: 41.387, longitude: 2.168}}
  zones:
    yard: {{name: Yard, kind: fence, geometry: {{type: Polygon, coordinates: [{YARD}]}}}}
    pit: {{name: Pit, geometry: {{type: Polygon, coordinates: [{PIT}]}}}}
devices:
  base:
    name: Base
    drive: {{topic: /cmd_vel, max_speed: 1, max_turn: 1}}
    signals:
      fix:
        {{name: Position, type: position, frame: wgs84, max_age: 2, frozen_after: 60,
          source: {{topic: /fix, type: sensor_msgs/msg/NavSatFix, stamp: header.stamp}}}}
      pose:
        {{name: Pose, type: position, max_age: 2,
          source: {{topic: /pose, type: nav_msgs/msg/Odometry, field: pose.pose.position}}}}
interlocks:
  fence:
    name: Leaves the yard
    when: [{OUTSIDE}]
    refuse: [base/drive]
    dwell: 0
"""


class Yard:
    """Interlocks of a robot whose newest position and clock are given."""

    def __init__(self, condition: str = OUTSIDE) -> None:  # noqa: D107
        self.site = load_site(DESCRIPTION.replace(OUTSIDE, condition))
        assert check_site(self.site) == []
        self.now = 100 * SECOND
        self.readings: dict[str, ChannelReading] = {}
        self.interlocks = Interlocks(
            site=self.site, readings=self, output=self, run=lambda *_: None, now_ns=0,
            wall_ns=lambda: self.now,
        )  # fmt: skip

    def latest(self, address: str) -> ChannelReading | None:
        return self.readings.get(address)

    def send(self, message: object) -> None: ...

    def record_event(self, kind: str, *_more: object, **_good: object) -> None: ...

    def refusal(self, after_s: float = 1.0) -> str:
        # As often as a gateway looks, or its own standstill would count as none of the robot's.
        for _ in range(round(after_s * 10)):
            self.now += SECOND // 10
            self.interlocks.conditions.mark_running(self.now)
            self.interlocks.evaluate_all(self.now)
        return self.interlocks.refusal_reason("base", "drive", self.now)

    def at(self, x: float, y: float) -> str:
        """Hear a position in metres from the origin, in degrees, and say what is refused."""
        place = place_of_local(x, y, ORIGIN)
        return self.heard("base/fix", place.latitude, place.longitude, 0.0)

    def heard(self, address: str, *numbers: float) -> str:
        mono_ns = self.now + SECOND
        self.readings[address] = ChannelReading(
            numbers[0], mono_ns, mono_ns, mono_ns, tuple(numbers)
        )
        return self.refusal()


def test_a_robot_that_leaves_its_yard_or_comes_near_its_edge_is_refused() -> None:
    yard = Yard()
    assert yard.at(50, 50) == ""
    assert yard.at(99, 50) == "Leaves the yard: Position is less than 2 m from the edge of Yard"
    assert yard.at(101, 50) == "Leaves the yard: Position is outside Yard"
    assert yard.at(97, 50) == ""


def test_a_robot_that_enters_a_place_or_comes_near_it_is_refused() -> None:
    yard = Yard("{signal: base/fix, inside: pit, margin: 5}")
    assert yard.at(10, 10) == ""
    assert "less than 5 m from the edge of Pit" in yard.at(36, 50)
    assert "Position is inside Pit" in yard.at(50, 50)


def test_a_position_in_metres_is_judged_where_the_map_says_that_its_zero_lies() -> None:
    yard = Yard("{signal: base/pose, outside: yard}")
    assert yard.heard("base/pose", 50.0, 50.0, 0.0) == ""
    assert "Pose is outside Yard" in yard.heard("base/pose", -1.0, 50.0, 0.0)


@pytest.mark.parametrize("condition", [OUTSIDE, "{signal: base/fix, inside: pit}"])
@pytest.mark.parametrize(
    "numbers",
    [
        (math.nan, 2.168, 0.0), (41.387, math.nan, 0.0), (math.inf, 2.168, 0.0),
        # Without a fix many receivers say this.
        (0.0, 0.0, 0.0),
        (91.0, 2.168, 0.0), (-41.387, -177.832, 0.0), (41.387, 182.0, 0.0),
    ],
)  # fmt: skip
def test_a_position_that_cannot_be_is_unknown_and_refused(condition, numbers) -> None:
    yard = Yard(condition)
    assert yard.at(10, 10) == ""
    assert yard.heard("base/fix", *numbers) != ""


@pytest.mark.parametrize("condition", [OUTSIDE, "{signal: base/fix, inside: pit}"])
def test_a_position_that_is_old_or_never_came_is_refused(condition) -> None:
    yard = Yard(condition)
    assert "no value yet" in yard.refusal()
    assert yard.at(10, 10) == ""
    assert yard.refusal() == ""
    refused = [yard.refusal() for _ in range(3)]
    assert "no value newer than 2 s" in refused[-1]
    assert yard.at(10, 10) == ""


def test_a_stamp_that_stands_still_makes_a_position_unknown_however_often_it_comes() -> None:
    yard = Yard()
    assert yard.at(50, 50) == ""
    before = yard.readings["base/fix"]
    for _ in range(4):
        # It arrives again and again with the time of one measurement.
        yard.readings["base/fix"] = before._replace(arrived_ns=yard.now + SECOND)
        refused = yard.refusal()
    assert "time stamp has stood still" in refused


def test_a_position_of_which_no_bit_changes_is_frozen_and_one_that_moves_east_is_not() -> None:
    yard = Yard()
    place = place_of_local(50, 50, ORIGIN)
    still, moves = 0, 0
    for _ in range(70):
        still = yard.heard("base/fix", place.latitude, place.longitude, 0.0)
    assert "frozen" in still
    yard = Yard()
    for second in range(70):
        # Due east: its latitude is the same all the time.
        moves = yard.heard("base/fix", place.latitude, place.longitude + second * 1e-9, 0.0)
    assert moves == ""


def test_a_reading_without_a_whole_position_is_refused() -> None:
    yard = Yard()
    yard.readings["base/fix"] = ChannelReading(41.3875, yard.now + SECOND)
    assert "no place on Earth" in yard.refusal()


def test_another_zone_locks_until_it_is_judged_anew() -> None:
    yard = Yard()
    assert yard.at(50, 50) == ""
    smaller = DESCRIPTION.replace(YARD, ring((0, 0), (10, 0), (10, 10), (0, 10)))
    yard.interlocks.redescribe(load_site(smaller), yard.now)
    assert "Position is outside Yard" in yard.refusal()


def test_zones_of_one_position_are_conditions_of_their_own_for_overrides() -> None:
    both = f"{OUTSIDE}, {{signal: base/fix, inside: pit}}"
    site = Yard(both).site
    ids = [condition_id(one) for one in site.interlocks["fence"].when]
    assert ids == ["base/fix+zone:yard", "base/fix+zone:pit"]
    assert condition_label(site, ids[0]) == "Position and Yard"


@given(st.floats(-500, 600), st.floats(-500, 600))
def test_only_what_is_surely_inside_is_permitted(x: float, y: float) -> None:
    yard = Yard()
    refused = yard.at(x, y)
    edge = min(x, y, 100 - x, 100 - y)
    # Nearer than a millimetre to the margin both are right.
    if abs(edge - 2) > 0.001:
        assert (refused == "") == (edge > 2)


WRONG = {
    "{signal: base/fix, outside: yrd}": "yrd",
    "{signal: base/fix, outside: yard, inside: pit}": "both inside and outside",
    "{signal: base/fix, outside: yard, margin: -1}": "expected 0 to 1000 m",
    "{signal: base/fix, outside: yard, above: 3}": "a position beside a zone has none",
    "{signal: base/fix, margin: 3}": "it names no zone",
    "{signal: base/speed, outside: yard}": "base/speed",
    "{signal: base/fix, outside: line}": "nothing is inside of it",
    "{signal: base/fix, outside: bow}": "lines of bow cross",
    "{signal: base/fix, outside: flat}": "encloses no ground",
    "{signal: base/fix, outside: land}": "wider than 20 km",
}
MORE = {
    "line": "{type: LineString, coordinates: [[2.168, 41.387], [2.169, 41.387]]}",
    "bow": f"{{type: Polygon, coordinates: [{ring((0, 0), (9, 9), (9, 0), (0, 5))}]}}",
    "flat": f"{{type: Polygon, coordinates: [{ring((0, 0), (9, 9), (5, 5))}]}}",
    "land": f"{{type: Polygon, coordinates: [{ring((0, 0), (3e4, 0), (3e4, 3e4))}]}}",
}


@pytest.mark.parametrize(("condition", "said"), WRONG.items())
def test_check_says_what_a_fence_cannot_go_by(condition: str, said: str) -> None:
    zones = "".join(f"    {name}: {{name: {name}, geometry: {at}}}\n" for name, at in MORE.items())
    text = DESCRIPTION.replace(OUTSIDE, condition).replace("  zones:\n", f"  zones:\n{zones}")
    found = [str(one) for one in check_site(load_site(text))]
    assert any(said in one for one in found), found
    assert all(one.startswith("$.interlocks.fence.when[0]") for one in found)


def test_a_position_in_metres_needs_to_be_told_where_its_zero_lies() -> None:
    text = DESCRIPTION.replace(OUTSIDE, "{signal: base/pose, outside: yard}")
    text = text.replace("  origin: {latitude: 41.387, longitude: 2.168}\n", "")
    (found,) = check_site(load_site(text))
    assert "nothing says where its zero lies" in found.problem
