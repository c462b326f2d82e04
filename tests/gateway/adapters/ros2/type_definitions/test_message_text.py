"""Texts of definitions: what their authors may write."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    FieldForm,
    FieldType,
)
from talaia.gateway.adapters.ros2.type_definitions.message_text import (
    message_in,
    messages_in_bundle,
    parts_in,
)

pytestmark = pytest.mark.pure
TEXT = """
# Of an arm that nobody else has.
uint8 MODE_IDLE = 0
uint8 MODE_MOVING=0x1   # on its way
string GREETING= it's # here
float64 FACTOR=1.5
Header header
uint8 mode 1            # see above
char[4] code
wstring<=8[<=3] words ["a", "# b"]
string<=10 name 'x # y'
Joint[] joints
other_msgs/Part[2] parts
other_msgs/msg/Part one
"""


def test_fields_bounds_constants_and_comments_are_told_apart() -> None:
    found = message_in(TEXT, "own_msgs/msg/Arm")
    assert found.constants == {"MODE_IDLE": 0, "MODE_MOVING": 1}
    assert {field.name: field.type for field in found.fields} == {
        "header": FieldType("std_msgs/msg/Header"),
        "mode": FieldType("uint8"),
        "code": FieldType("uint8", FieldForm.ARRAY, 4),
        "words": FieldType("wstring", FieldForm.BOUNDED, 3, 8),
        "name": FieldType("string", text_bound=10),
        "joints": FieldType("own_msgs/msg/Joint", FieldForm.SEQUENCE),
        "parts": FieldType("other_msgs/msg/Part", FieldForm.ARRAY, 2),
        "one": FieldType("other_msgs/msg/Part"),
    }


def test_a_bundle_holds_each_type_once_by_its_full_name() -> None:
    rule = "=" * 80
    bundle = f"Part[] parts\n{rule}\nMSG: a/Part\nint8 x\n{rule}\nMSG: b/msg/Other\nbool y\n"
    found = messages_in_bundle(bundle, "a/msg/Whole")
    assert list(found) == ["a/msg/Whole", "a/msg/Part", "b/msg/Other"]
    assert found["a/msg/Whole"].fields[0].type.base == "a/msg/Part"


def test_services_and_actions_come_in_parts() -> None:
    service = parts_in("bool on\n---\nstring message\n", "a/srv/Switch")
    assert list(service) == ["a/srv/Switch_Request", "a/srv/Switch_Response"]
    action = parts_in("int32 order\n---\n---\nfloat32 share\n", "a/action/Count")
    assert [len(part.fields) for part in action.values()] == [1, 0, 1]
    with pytest.raises(BadDefinition, match="found 1 parts, expected 2"):
        parts_in("bool on\n", "a/srv/Switch")


def test_a_line_that_says_nothing_is_named_with_its_number() -> None:
    with pytest.raises(BadDefinition, match="a/msg/A, line 2: '7up x'"):
        message_in("bool on\n7up x\n", "a/msg/A")


@given(st.text(max_size=200) | st.lists(st.sampled_from(TEXT.splitlines())).map("\n".join))
def test_any_text_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(BadDefinition):
        messages_in_bundle(text, "a/msg/A")
