"""Messages written by their definitions, judged by rclpy with the real classes."""

from __future__ import annotations

import importlib.util

import pytest

from talaia.gateway.adapters.ros2.requests import fill
from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.message_definition import TypeDefinition
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder
from talaia.gateway.adapters.ros2.type_definitions.message_text import message_in
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


def test_wide_texts_are_written_as_ros_reads_them() -> None:
    """By the middleware's own CDR; what lies beyond 16 bits is two of its characters."""
    from rclpy.serialization import deserialize_message
    from test_msgs.msg import WStrings

    encoder = MessageEncoder(installed_definition("test_msgs/msg/WStrings"))
    message = encoder.new_message()
    assert deserialize_message(encoder.encode_message(message), WStrings).wstring_value == ""
    message.unbounded_sequence_of_wstrings = ["", "b✓", "€"]
    fields = {"wstring_value": "añ✓😀", "array_of_wstrings[1]": "c", "array_of_wstrings[2]": "dd"}
    fill(message, fields)
    for _ in range(2):
        theirs = deserialize_message(encoder.encode_message(message), WStrings)
        assert theirs.wstring_value == "añ✓😀"
        assert theirs.array_of_wstrings == ["", "c", "dd"]
        assert theirs.unbounded_sequence_of_wstrings == ["", "b✓", "€"]
        assert theirs.bounded_sequence_of_wstrings == []


def test_a_wide_text_beyond_its_bound_is_refused_with_its_field() -> None:
    name = "own_msgs/msg/Word"
    encoder = MessageEncoder(TypeDefinition(name, {name: message_in("wstring<=3 word", name)}))
    for word, good in (("abc", True), ("abcd", False), ("a😀", True), ("ab😀", False)):
        message = encoder.new_message()
        fill(message, {"word": word})
        if good:
            assert len(encoder.encode_message(message)) == 4 + 4 + 3 * 4
        else:
            with pytest.raises(FieldError, match="'word': a text of 4 characters, and at most 3"):
                encoder.encode_message(message)
