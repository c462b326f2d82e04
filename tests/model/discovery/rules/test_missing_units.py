"""What a description's head says of numbers that have no unit."""

from __future__ import annotations

import pytest

from talaia.model.discovery.rules.missing_units import numbers_without_unit, unit_lines
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure
SITE = """\
talaia: 1
site: dome
name: Dome
ros2: {}
devices:
  dome:
    name: Dome
    signals:
      azimuth: {name: A, source: {topic: /azimuth, type: std_msgs/msg/Float64, field: data}}
      gain: {name: G, source: {topic: /gain, type: std_msgs/msg/Float64, field: data}}
      count: {name: C, decimals: 0, source: {topic: /c, type: std_msgs/msg/UInt8, field: data}}
      wind: {name: W, unit: m/s, source: {topic: /w, type: std_msgs/msg/Float64, field: data}}
      open: {name: O, type: state, states: ["off", "on"],
             source: {topic: /open, type: std_msgs/msg/Bool, field: data}}
"""


def test_numbers_whose_unit_nobody_says_are_listed_and_angles_apart() -> None:
    addresses = list(numbers_without_unit(load_site(SITE)))
    assert addresses == ["dome/azimuth", "dome/gain"]
    said = "\n".join(unit_lines(addresses))
    assert said.index("angles") < said.index("dome/azimuth") < said.index("others:")
    assert said.endswith("dome/gain")


def test_where_each_has_one_nothing_is_said_and_no_line_is_long() -> None:
    assert unit_lines([]) == []
    many = [f"device_{number}/a_signal_of_it" for number in range(50)]
    lines = unit_lines(many)
    assert max(map(len, lines)) < 100
    assert sum(line.count("a_signal_of_it") for line in lines) == len(many)
