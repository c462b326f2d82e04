"""Hashes of definitions, judged by those that ROS's own generator installed."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from installed_types import installed_types

from talaia.gateway.adapters.ros2.type_definitions.definition_files import (
    FolderDefinitions,
    ros_prefixes,
)
from talaia.gateway.adapters.ros2.type_definitions.definition_text import definition_text
from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    FieldForm,
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
    type_hash,
)
from talaia.gateway.adapters.ros2.type_definitions.message_text import messages_in_bundle
from talaia.gateway.adapters.ros2.type_definitions.robot_description import definition_in_json

TYPES = installed_types()
needs_ros = pytest.mark.skipif(
    not TYPES or importlib.util.find_spec("rclpy") is None, reason="needs ROS 2's packages"
)


def one(name: str, *fields: MessageField, **others: PartDefinition) -> TypeDefinition:
    parts = {name: PartDefinition(fields, {})}
    parts |= {f"a/msg/{short}": part for short, part in others.items()}
    return TypeDefinition(name, parts)


@needs_ros
def test_every_installed_type_has_ros_own_hash_from_file_class_and_description() -> None:
    files = FolderDefinitions.of_prefixes(ros_prefixes())
    assert len(TYPES) > 100
    for name, (path, told) in TYPES.items():
        definitions = [
            *files.find(name),
            installed_definition(name),
            definition_in_json(path.read_bytes(), name, "a test"),
        ]
        assert [type_hash(each) for each in definitions] == [told] * 3, name


@needs_ros
def test_a_definitions_text_defines_the_same_type() -> None:
    files = FolderDefinitions.of_prefixes(ros_prefixes())
    for name, (_, told) in TYPES.items():
        for definition in (installed_definition(name), *files.find(name)):
            parts = messages_in_bundle(definition_text(definition), name)
            assert type_hash(TypeDefinition(name, parts).checked()) == told, name


@needs_ros
def test_a_field_of_another_name_or_order_is_another_type() -> None:
    definition = installed_definition("geometry_msgs/msg/Vector3")
    part = definition.parts[definition.name]
    for fields in (part.fields[::-1], (part.fields[0]._replace(name="q"), *part.fields[1:])):
        other = definition._replace(parts={definition.name: part._replace(fields=fields)})
        assert type_hash(other) != type_hash(definition)


def test_a_type_that_contains_itself_is_refused() -> None:
    loop = one("a/msg/A", MessageField("b", FieldType("a/msg/B")))
    loop.parts["a/msg/B"] = PartDefinition((MessageField("a", FieldType("a/msg/A")),), {})
    with pytest.raises(BadDefinition, match="contains itself"):
        loop.checked()


@pytest.mark.parametrize(
    ("field", "problem"),
    [
        (MessageField("x", FieldType("b/msg/Gone")), "nothing is known of b/msg/Gone"),
        (MessageField("x=1\nimport os", FieldType("bool")), "is not the name of a field"),
        (MessageField("x", FieldType('b/msg/"""')), "is not a type"),
        (
            MessageField("x", FieldType("string", FieldForm.ARRAY, 10**9)),
            "an array of 1000000000 string; at most 4096",
        ),
    ],
)
def test_a_definition_that_cannot_be_decoded_says_why(field, problem) -> None:
    with pytest.raises(BadDefinition, match=problem):
        one("a/msg/A", field).checked()
