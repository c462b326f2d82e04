"""Definitions of a gateway that would run code in the hub, or be read for hours."""

from __future__ import annotations

import struct
import sys

import pytest

from talaia.hub.clients.rosbridge.ros_types import (
    MessageUnreadable,
    TypeText,
    describe_type,
    message_reader,
)
from talaia.wire.frames import TapSchema
from talaia.wire.type_bounds import MOST_DEFINITION

pytestmark = pytest.mark.pure

RULE = "=" * 80
KIND = "robot_msgs/msg/Thing"


def schema_of(definition: str, kind: str = KIND, form: str = "ros1") -> TapSchema:
    encoding = "ros1msg" if form == "ros1" else "ros2msg"
    return TapSchema(type=kind, encoding=encoding, definition=definition, message_encoding=form)


def test_name_of_a_type_that_is_source_code_is_run_nowhere() -> None:
    # rosbags writes a class of this name and runs what it wrote.
    name = "a/msg/B:\n    x: int\nimport sys\nsys.forged_type = True\nclass C"
    for refused in (
        lambda: message_reader(schema_of("float64 x", name)),
        lambda: describe_type(name, TypeText(name, "ros2msg", "float64 x")),
    ):
        with pytest.raises(MessageUnreadable, match="no name of a type"):
            refused()
    assert not hasattr(sys, "forged_type")


def test_list_of_things_that_take_no_bytes_is_not_read() -> None:
    # Four bytes would be four thousand million things.
    hostile = f"robot_msgs/Nothing[] many\n{RULE}\nMSG: robot_msgs/Nothing\n"
    with pytest.raises(MessageUnreadable, match="takes no bytes"):
        message_reader(schema_of(hostile))
    fixed = f"robot_msgs/Nothing[999999999] many\n{RULE}\nMSG: robot_msgs/Nothing\n"
    with pytest.raises(MessageUnreadable, match="takes no bytes"):
        message_reader(schema_of(fixed))


def test_fixed_lengths_that_multiply_are_not_read() -> None:
    hostile = "\n".join(
        [
            "robot_msgs/T1[1000] x",
            *(
                f"{RULE}\nMSG: robot_msgs/T{at}\nrobot_msgs/T{at + 1}[1000] x\n"
                for at in range(1, 6)
            ),
            f"{RULE}\nMSG: robot_msgs/T6\nuint8 x",
        ]
    )
    with pytest.raises(MessageUnreadable, match="values of fixed number"):
        message_reader(schema_of(hostile.replace("\n\n", "\n")))


def test_type_that_is_in_itself_and_one_that_is_too_long_are_not_read() -> None:
    with pytest.raises(MessageUnreadable, match="in itself"):
        message_reader(schema_of("robot_msgs/Thing[] parts\n"))
    with pytest.raises(MessageUnreadable, match="characters"):
        message_reader(schema_of("# " + "a" * MOST_DEFINITION + "\nuint8 x\n"))


def test_robots_own_lists_are_read_as_before() -> None:
    definition = f"robot_msgs/Spot[] spots\nfloat64[3] pose\n{RULE}\nMSG: robot_msgs/Spot\nint8 x\n"
    written = struct.pack("<Ibb3d", 2, 4, -5, 1.0, 2.0, 3.0)
    found = message_reader(schema_of(definition))(written)
    assert [spot["x"] for spot in found["spots"]] == [4, -5]
    assert found["pose"].tolist() == [1.0, 2.0, 3.0]
