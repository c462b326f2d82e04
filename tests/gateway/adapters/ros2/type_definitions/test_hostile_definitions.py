"""A robot's, a file's or a recording's word for a name is run nowhere: rosbags writes source."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import TYPE_CHECKING

import pytest
from mcap.writer import Writer

from talaia.cli.importing.decoding import Definition, Undecodable, decoder_of as imported
from talaia.gateway.adapters.ros1.decode import decoder_of as ros1_decoder
from talaia.gateway.adapters.ros1.message_types import definition_of
from talaia.gateway.adapters.ros2.type_definitions.definition_files import (
    FolderDefinitions,
    RecordedDefinitions,
)
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import compiled_store, decoder_of
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    FieldForm,
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
)
from talaia.gateway.adapters.ros2.type_definitions.robot_description import (
    definition_of_description,
)
from talaia.gateway.errors import FieldError
from talaia.ros_definitions import OutOfBounds, check_names

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = pytest.mark.pure

RUN = "import sys; sys.forged_type = True"
# Each would be run in one of the places where rosbags writes a name.
NAMES = [
    # The base of a class is run as it is written, and this stays a text where a text is written.
    f'a/msg/B(exec("{RUN}") or object)',
    f"a/msg/B:\n    x: int\n{RUN}\nclass C",
    f'a/msg/B"""\n    x = 1\n{RUN}\n"""',
    "a/msg/B': ([], []), **(__import__('sys').__dict__.update(forged_type=True) or {}), 'c",
    "a/msg/B\\",
    "a/msg/ß",
    "a/msg/B\n",
    "",
]


@pytest.fixture(autouse=True)
def _nothing_is_run() -> Iterator[None]:
    yield
    assert not hasattr(sys, "forged_type")


def described(name: str, field: str = "x", nested: str = "") -> SimpleNamespace:
    kind = SimpleNamespace(
        type_id=1 if nested else 11, capacity=0, string_capacity=0, nested_type_name=nested
    )
    one = SimpleNamespace(type_name=name, fields=[SimpleNamespace(name=field, type=kind)])
    others = [SimpleNamespace(type_name=nested, fields=[])] if nested else []
    return SimpleNamespace(type_description=one, referenced_type_descriptions=others)


@pytest.mark.parametrize("name", NAMES)
def test_a_robots_description_names_no_source_code(name: str) -> None:
    for hostile in (
        described(name),
        described("a/msg/B", nested=name) if name else described(name),
        described("a/msg/B", field=name),
    ):
        with pytest.raises(BadDefinition):
            decoder_of(definition_of_description(hostile, (), "the robot"), proven=True)


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_compiled_that_was_not_looked_at(name: str) -> None:
    # As if a way to a definition forgot to check it.
    number = MessageField("x", FieldType("float64"))
    for parts in (
        {name: PartDefinition((number,), {})},
        {"a/msg/B": PartDefinition((number._replace(name=name),), {})},
        {"a/msg/B": PartDefinition((MessageField("x", FieldType(name)),), {})},
        {"a/msg/B": PartDefinition((MessageField("x", FieldType(name, FieldForm.SEQUENCE)),), {})},
    ):
        with pytest.raises(BadDefinition):
            compiled_store(TypeDefinition(next(iter(parts)), parts))


def test_a_msg_file_names_no_source_code(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "msg"
    folder.mkdir(parents=True)
    for line in (
        f"float64 x: int\n{RUN}",
        f"float64 x = {RUN}",
        "a/B';__import__('sys') x",
        f"string X=\"'''{RUN}'''\"\nfloat64 y:{RUN}",
    ):
        (folder / "B.msg").write_text(line)
        try:
            found = list(FolderDefinitions.of_folder(tmp_path).find("a/msg/B"))
        except BadDefinition:
            continue
        for definition in found:
            compiled_store(definition)


def test_texts_of_constants_stay_texts() -> None:
    text = f"string X=\"'; {RUN} #\nfloat64 y\n"
    read = ros1_decoder("a/msg/B", text)
    assert read(b"\0" * 8).y == 0.0  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", NAMES)
def test_a_recording_names_no_source_code(name: str, tmp_path: Path) -> None:
    path = tmp_path / "recording.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema(name, "ros2msg", b"float64 x")
        channel = writer.register_channel("/t", "cdr", schema)
        writer.add_message(channel, 1, b"\0\1\0\0" + b"\0" * 8, 1)
        writer.finish()
    try:
        found = list(RecordedDefinitions(path).find(name))
    except BadDefinition:
        found = []
    for definition in found:
        with pytest.raises(BadDefinition):
            compiled_store(definition)
    # And as files are brought in.
    for encoding in ("cdr", "ros1"):
        with pytest.raises(Undecodable):
            imported(Definition(encoding, name, "msg", "float64 x"))


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_of_ros1_names_no_source_code(name: str) -> None:
    with pytest.raises(FieldError):
        ros1_decoder(name, "float64 x")
    with pytest.raises(FieldError):
        definition_of("float64 x", name)
    # A part of another type.
    rule = "=" * 80
    for text in (f"a/C y\n{rule}\nMSG: {name}\nfloat64 x\n", f"float64 {name}"):
        if name in ("", "a/msg/B\n"):
            continue
        with pytest.raises(FieldError):
            ros1_decoder("a/msg/B", text)


def test_lengths_and_values_that_are_none_are_not_written() -> None:
    number = (1, ("float64", 0))
    for fields, constants in (
        ([("x", (3, (number, "2), __import__('sys')")))], []),
        ([("x", (3, (number, -1)))], []),
        ([("x", (3, (number, True)))], []),
        ([("x", (1, ("float64, exit()", 0)))], []),
        ([], [("X", "float64", SimpleNamespace())]),
        ([], [("X = exit()", "float64", 1.0)]),
        ([], [("X", "float64] = exit()", 1.0)]),
    ):
        with pytest.raises(OutOfBounds):
            check_names({"a/msg/B": (constants, fields)})  # type: ignore[dict-item]


def test_names_that_are_words_of_python_are_read_as_before() -> None:
    read = ros1_decoder("a/msg/B", "float64 lambda\nfloat64 class\n")
    message = read(b"\0" * 16)
    assert (message.lambda_, message.class_) == (0.0, 0.0)
