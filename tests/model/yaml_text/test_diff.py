"""From one description to the next: renames, touched devices, differences, places."""

from __future__ import annotations

import msgspec

from talaia.model.checks.site_checks import check_site
from talaia.model.renames import changed_devices, former_addresses, list_renames
from talaia.model.schema import site_schema
from talaia.model.yaml_text.diff import ChangeKind, Difference, list_differences, unified_diff
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.source_lines import SourcePositions

TEXT = """talaia: 1
site: agv
name: Robot
ros2: {}
devices:
  base:
    name: Base
    signals:
      speed: {name: Speed, source: {topic: /s, type: std_msgs/msg/Float64, field: data}}
      pose:
        name: Pose
        type: position
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: pose.pose.position}
  arm:
    name: Arm
"""
RENAMED = TEXT.replace("pose:\n", "place:\n        was: pose\n")


def test_renamed_signal_takes_all_its_channels_along_and_back_again() -> None:
    before, after = load_site(TEXT), load_site(RENAMED)
    forward = {f"base/pose.{part}": f"base/place.{part}" for part in ("x", "y", "yaw")}
    assert list_renames(before, after) == forward
    assert list_renames(after, before) == {new: old for old, new in forward.items()}
    assert former_addresses(after) == forward
    assert list_renames(after, after) == {}


def test_was_that_names_a_signal_of_the_description_is_refused_and_so_are_two_of_one() -> None:
    there = TEXT.replace("{name: Speed,", "{name: Speed, was: pose,")
    found = check_site(load_site(there))
    assert found[0].where == "$.devices.base.signals.speed.was"
    two = RENAMED.replace("{name: Speed,", "{name: Speed, was: base/pose,")
    assert "already" in check_site(load_site(two))[0].problem


def test_only_devices_that_differ_are_touched_and_all_of_a_changed_connection() -> None:
    before = load_site(TEXT)
    assert changed_devices(before, load_site(RENAMED)) == {"base"}
    assert changed_devices(before, load_site(TEXT.replace("name: Robot", "name: R"))) == frozenset()
    other = load_site(TEXT.replace("ros2: {}", "ros2: {node: other}"))
    assert changed_devices(before, other) == {"base", "arm"}


def test_difference_names_each_part_once() -> None:
    after = RENAMED.replace("name: Base", "name: Wheels").replace("  arm:\n    name: Arm\n", "")
    found = list_differences(load_site(TEXT), load_site(after))
    assert (
        Difference(ChangeKind.RENAMED, "$.devices.base.signals.place", "base/pose", "base/place")
        in found
    )
    assert Difference(ChangeKind.CHANGED, "$.devices.base.name", "Base", "Wheels") in found
    assert Difference(ChangeKind.REMOVED, "$.devices.arm", "Arm") in found
    assert list_differences(load_site(TEXT), load_site(TEXT)) == []
    assert "-    name: Base" in unified_diff(TEXT, after)


def test_path_leads_to_its_line_and_what_is_missing_to_what_it_would_stand_in() -> None:
    places = SourcePositions(TEXT)
    assert places.position_of("$.devices.base.signals.pose.type") == (12, 9)
    assert places.position_of("$.devices.base.drive.topic") == (6, 3)
    assert places.position_of("line 4, column 2") == (4, 2)
    assert SourcePositions("a: [").position_of("$.a") == (0, 0)


def test_schema_says_of_each_attribute_what_the_model_does() -> None:
    signal = site_schema()["$defs"]["Signal"]["properties"]
    assert "(Hz)" in signal["max_rate"]["description"]


def test_description_without_was_is_what_it_was_before_there_was_one() -> None:
    assert "was" not in msgspec.to_builtins(load_site(TEXT))["devices"]["arm"]
