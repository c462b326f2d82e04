"""Names of sensors: CloudConnect's own, the signal's, or the address where that tells nothing."""

from __future__ import annotations

import math

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.clients.signal_subscriptions import ClientSample
from talaia.hub.clients.socketio.offer import (
    OfferedSensor,
    make_socketio_offer,
    sensor_magnitude,
)
from talaia.model.yaml_text.load import load_site

SITE = """
talaia: 1
site: agv
name: Vehicle
ros2: {}
devices:
  base:
    name: Base
    signals:
      forward:
        name: Forward
        unit: m/s
        source: {topic: /metric, type: std_msgs/msg/String, name: speed1}
      heat:
        name: Heat
        source: {topic: /diagnostics, type: diagnostic_msgs/msg/DiagnosticArray, name: "cpu heat"}
      place:
        name: Place
        type: position
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: pose.pose}
  arm:
    name: Arm
    signals:
      heat:
        name: Heat
        source: {topic: /h, type: std_msgs/msg/Float64, field: data}
"""


def test_sensor_goes_by_its_name_on_the_wire_else_by_the_signals() -> None:
    offer = make_socketio_offer(load_site(SITE), Grants(frozenset({Permission(Right.VIEW)})))
    names = {address: sensor.name for address, sensor in offer.sensors.items()}
    assert names["base/forward"] == "speed1"
    assert (names["base/heat"], names["arm/heat"]) == ("base/heat", "arm/heat")
    assert names["base/place.x"] == "place.x"
    assert offer.describe_site(load_site(SITE))["units"]["speed1"] == "m/s"


def test_what_is_not_for_an_account_changes_no_name() -> None:
    seen = make_socketio_offer(
        load_site(SITE), Grants(frozenset({Permission(Right.VIEW, "agv", "arm")}))
    ).sensors
    assert {address: sensor.name for address, sensor in seen.items()} == {"arm/heat": "heat"}


def test_magnitude_is_a_number_a_text_or_the_word_of_a_state() -> None:
    state = OfferedSensor("dome", "", ("open", "shut"))
    plain = OfferedSensor("speed1", "m/s")
    assert sensor_magnitude(plain, ClientSample("a", 1, 1.5, None)) == 1.5
    assert sensor_magnitude(plain, ClientSample("a", 1, math.nan, None)) is None
    assert sensor_magnitude(plain, ClientSample("a", 1, math.nan, "words")) == "words"
    assert sensor_magnitude(state, ClientSample("a", 1, 1.0, None)) == "shut"
    assert sensor_magnitude(state, ClientSample("a", 1, 7.0, None)) == "7"
