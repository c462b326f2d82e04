"""Decoders made of definitions, judged by rclpy with the real classes."""

from __future__ import annotations

import contextlib
import importlib.util

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import decoder_of
from talaia.gateway.errors import FieldError

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("rclpy") is None, reason="needs ROS 2's packages"
)


def serialized(name: str, **fields: object) -> bytes:
    from rclpy.serialization import serialize_message
    from test_msgs import msg

    return serialize_message(getattr(msg, name)(**fields))


def assert_same(ours: object, theirs: object, path: str = "") -> None:
    """Hold what we decoded against an object of rosidl's class."""
    if hasattr(theirs, "get_fields_and_field_types"):
        for field in theirs.get_fields_and_field_types():
            assert_same(getattr(ours, field), getattr(theirs, field), f"{path}.{field}")
    elif isinstance(theirs, str | bytes) or not hasattr(theirs, "__len__"):
        assert ours == (theirs[0] if isinstance(theirs, bytes) else theirs), path
    else:
        assert len(ours) == len(theirs), path
        for at, pair in enumerate(zip(ours, theirs, strict=True)):
            assert_same(*pair, f"{path}[{at}]")


def test_every_sort_of_field_is_what_rclpy_reads() -> None:
    from rclpy.serialization import deserialize_message
    from test_msgs import msg

    sequences = msg.UnboundedSequences(
        bool_values=[True], float64_values=[1.5, -2.0], string_values=["a", "bcdé"],
        byte_values=[b"\xff"], alignment_check=7,
    )  # fmt: skip
    bounded = msg.BoundedSequences(string_values=["q"], int64_values=[-1], alignment_check=9)
    wide = {"wstring_value": "añ✓😀", "unbounded_sequence_of_wstrings": ["", "ハロー"]}
    for name, fields in (
        ("Arrays", {"string_values": ["a", "", "ccc"]}),
        ("MultiNested", {"unbounded_sequence_of_unbounded_sequences": [sequences] * 2,
                         "bounded_sequence_of_bounded_sequences": [bounded]}),
        ("WStrings", wide),
        ("Defaults", {}), ("Constants", {}), ("Empty", {}), ("Nested", {}), ("Builtins", {}),
        ("Strings", {"bounded_string_value": "x" * 22}),
    ):  # fmt: skip
        raw = serialized(name, **fields)
        theirs = deserialize_message(raw, getattr(msg, name))
        decode = decoder_of(installed_definition(f"test_msgs/msg/{name}"), proven=True)
        assert_same(decode(raw), theirs)
        if name == "Builtins":
            # Fast DDS writes in this machine's order; words of four bytes are turned by hand.
            words = (raw[at : at + 4][::-1] for at in range(4, len(raw), 4))
            assert_same(decode(bytes(4) + b"".join(words)), theirs)


def test_bytes_that_are_left_over_are_an_error_where_no_hash_was_compared() -> None:
    raw = serialized("Strings") + bytes(8)
    definition = installed_definition("test_msgs/msg/Strings")
    decoder_of(definition, proven=True)(raw)
    with pytest.raises(FieldError, match="what came is not a test_msgs/msg/Strings"):
        decoder_of(definition, proven=False)(raw)


@given(st.data())
def test_damaged_messages_are_refused_and_nothing_worse(data: st.DataObject) -> None:
    raw = bytearray(serialized("WStrings", wstring_value="words"))
    decode = decoder_of(installed_definition("test_msgs/msg/WStrings"), proven=True)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(raw) - 1))
        raw[at] = data.draw(st.integers(0, 255))
    with contextlib.suppress(FieldError):
        decode(bytes(raw[: data.draw(st.integers(0, len(raw)))]))
