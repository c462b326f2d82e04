"""Messages of ROS 1, as rospy wrote them, read by the definition that came with them."""

from __future__ import annotations

import pytest

from talaia.hub.clients.rosbridge.ros_types import describe_type, message_reader
from talaia.hub.live.taps.type_texts import TypeText
from talaia.wire.frames import TapSchema

pytestmark = pytest.mark.pure

RULE = "=" * 80
# geometry_msgs/PointStamped, as its publisher tells it, without the comments.
DEFINITION = f"""Header header
Point point
{RULE}
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
{RULE}
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"""
# Written by rospy: seq 9, stamp 5.000000006 s, frame "f", and 1.5, -2, 0.
WRITTEN = bytes.fromhex(
    "0900000005000000060000000100000066000000000000f83f00000000000000c00000000000000000"
)
NAME = "geometry_msgs/msg/PointStamped"


def test_message_of_ros_1_is_read_with_its_times() -> None:
    schema = TapSchema(
        type=NAME, encoding="ros1msg", definition=DEFINITION, message_encoding="ros1"
    )
    assert message_reader(schema)(WRITTEN) == {
        "header": {"seq": 9, "stamp": {"sec": 5, "nanosec": 6}, "frame_id": "f"},
        "point": {"x": 1.5, "y": -2.0, "z": 0.0},
    }


def test_type_of_ros_1_is_described_with_its_times() -> None:
    found = describe_type(NAME, TypeText(NAME, "ros1msg", DEFINITION))
    assert [one["type"] for one in found] == [
        NAME,
        "std_msgs/msg/Header",
        "geometry_msgs/msg/Point",
        "builtin_interfaces/msg/Time",
    ]
