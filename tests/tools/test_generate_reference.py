"""The reference of the site description has an example for each key, and each is of its type."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from talaia.model.base import FOREIGN_KEYS, SOURCE_TAG, SourceShape
from talaia.model.connection import Connection
from talaia.model.yaml_text.document import read_document

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from generate_reference import EXAMPLES, insert_parts, read_examples, site_shapes  # noqa: E402

SHAPES = site_shapes()
EXAMPLES_BY_NAME = read_examples(EXAMPLES.read_text())


def tag_sources(value: object) -> object:
    """Say of each source inside that it is one of ROS, as the connection of a device would."""
    if isinstance(value, list):
        return [tag_sources(part) for part in value]
    if not isinstance(value, dict):
        return value
    tagged = {key: tag_sources(part) for key, part in value.items()}
    if "topic" in tagged and "type" in tagged:
        tagged[SOURCE_TAG] = "ros"
    return tagged


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.__name__)
def test_each_key_of_a_part_has_an_example_of_its_type(shape: type[msgspec.Struct]) -> None:
    example = read_document(EXAMPLES_BY_NAME[shape.__name__])
    assert isinstance(example, dict)
    names = {field.encode_name for field in msgspec.structs.fields(shape)} - {FOREIGN_KEYS}
    assert set(example) == names
    tagged = {key: tag_sources(value) for key, value in example.items()}
    if issubclass(shape, SourceShape):
        tagged[SOURCE_TAG] = shape.__struct_config__.tag
    elif shape in get_args(Connection):
        tagged["kind"] = shape.__struct_config__.tag
    made = msgspec.convert(tagged, shape)
    # What was not understood would be kept as somebody else's.
    assert not getattr(made, "foreign", None)


def test_no_example_is_of_a_part_that_is_gone() -> None:
    assert set(EXAMPLES_BY_NAME) == {shape.__name__ for shape in SHAPES}


class Inner(msgspec.Struct):
    size: float


class Outer(msgspec.Struct):
    first: Inner
    more: dict[str, list[Inner]]


class Last(msgspec.Struct):
    inner: Inner | None = None


def test_a_part_stands_right_behind_the_first_that_holds_it_and_only_once() -> None:
    assert insert_parts([Outer, Last]) == [Outer, Inner, Last]
