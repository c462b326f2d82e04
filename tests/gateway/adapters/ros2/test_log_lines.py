"""Which lines of a robot's log go on: those that have room, each once a minute."""

from __future__ import annotations

import pytest
from rcl_interfaces.msg import Log
from rclpy.serialization import serialize_message

from talaia.clock import SECOND
from talaia.gateway.adapters.ros2.nodes.log_lines import LogBounds, level_word, read_head
from talaia.model.closed_lists import LogLevel

pytestmark = pytest.mark.pure
MINUTE = 60 * SECOND


@pytest.mark.parametrize("name", ["", "a", "lidar", "front.lidar", "robot.añ✓"])
def test_the_head_is_what_ros_serialized(name: str) -> None:
    raw = serialize_message(Log(level=40, name=name, msg="x" * 1000, line=3))
    assert read_head(raw) == (40, name)
    assert read_head(raw[:17]) is None


def test_levels_are_those_of_ros() -> None:
    words = {Log.DEBUG: "debug", Log.INFO: "info", Log.WARN: "warning", Log.FATAL: "fatal"}
    assert {
        level: level_word(ord(level) if isinstance(level, bytes) else level) for level in words
    } == words
    bounds = LogBounds(LogLevel.WARNING, 0)
    assert [bounds.is_wanted(level) for level in (10, 20, 30, 40)] == [False, False, True, True]


def test_a_node_that_talks_much_takes_nothing_from_others_and_is_counted() -> None:
    bounds = LogBounds(LogLevel.INFO, 0)
    much = [bounds.has_room("talker", number * 1000) for number in range(10_000)]
    assert much.count(True) == 5
    assert bounds.has_room("lidar", SECOND)
    assert bounds.left_out(SECOND) == ""
    assert bounds.left_out(MINUTE) == (
        "9995 more lines of the robot's log were left out: 9995 of talker"
    )
    assert bounds.left_out(2 * MINUTE) == ""
    # It is heard again after a while.
    assert bounds.has_room("talker", MINUTE)


def test_all_nodes_together_have_a_bound() -> None:
    bounds = LogBounds(LogLevel.INFO, 0)
    assert [bounds.has_room(f"node{n}", 0) for n in range(1000)].count(True) == 20


def test_the_same_line_is_one_for_a_minute() -> None:
    bounds = LogBounds(LogLevel.INFO, 0)
    said = [bounds.is_new("lidar", "no echo", second * SECOND) for second in (0, 30, 60, 121)]
    # Each time anew: a line that never stops stands there once.
    assert said == [True, False, False, True]
    assert bounds.is_new("sonar", "no echo", 31 * SECOND)
