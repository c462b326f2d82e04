"""Messages written by their definitions, judged by rclpy with the real classes."""

from __future__ import annotations

import importlib.util

import pytest

from talaia.gateway.adapters.ros2.requests import fill
from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder
from talaia.gateway.errors import FieldError

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("rclpy") is None, reason="needs ROS 2's packages"
)
FIELDS = {"string_values[1]": "é", "float64_values[2]": -2.5, "int8_values[0]": -8,
          "basic_types_values[1].uint64_value": 2**60, "bool_values[2]": True}  # fmt: skip


def test_rclpy_reads_what_was_filled_in() -> None:
    from rclpy.serialization import deserialize_message
    from test_msgs.msg import Arrays, Empty

    encoder = MessageEncoder(installed_definition("test_msgs/msg/Arrays"))
    message = encoder.new_message()
    fill(message, FIELDS)
    theirs = deserialize_message(encoder.encode_message(message), Arrays)
    assert theirs.string_values == ["", "é", ""]
    assert list(theirs.float64_values) == [0.0, 0.0, -2.5]
    assert theirs.int8_values[0] == -8
    assert theirs.basic_types_values[1].uint64_value == 2**60
    assert theirs.bool_values == [False, False, True]
    empty = MessageEncoder(installed_definition("test_msgs/msg/Empty"))
    assert deserialize_message(empty.encode_message(empty.new_message()), Empty) == Empty()


def written(fields: dict[str, object]) -> bytes:
    encoder = MessageEncoder(installed_definition("test_msgs/msg/BasicTypes"))
    message = encoder.new_message()
    fill(message, fields)
    return encoder.encode_message(message)


@pytest.mark.parametrize(
    ("path", "value"), [("int8_value", 200), ("nothing", 1), ("bool_value", "yes"), ("a[", 1)]
)
def test_a_value_that_does_not_fit_is_refused(path: str, value: object) -> None:
    with pytest.raises(FieldError):
        written({path: value})


def test_a_type_with_wide_texts_is_not_written() -> None:
    with pytest.raises(BadDefinition, match="wide texts cannot be sent"):
        MessageEncoder(installed_definition("test_msgs/msg/WStrings"))
