"""Which definition is taken of many, and that none of another hash is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from mcap.writer import Writer

from talaia.gateway.adapters.ros2.type_definitions.definition_finder import (
    DefinitionFinder,
    DefinitionMismatch,
)
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TypeDefinition,
    type_hash,
)
from talaia.gateway.adapters.ros2.type_definitions.message_text import messages_in_bundle
from talaia.gateway.errors import TypeMissing

if TYPE_CHECKING:
    from pathlib import Path

ARM = "own_msgs/msg/Arm"
TEXT = "Joint[] joints\nstring<=9 name\n"
JOINT = "float64 angle\nwstring label\n"
OTHER = TEXT.replace("string<=9", "string<=8")


def arm(text: str = TEXT, source: str = "a robot") -> TypeDefinition:
    bundle = f"{text}{'=' * 80}\nMSG: own_msgs/Joint\n{JOINT}"
    return TypeDefinition(ARM, messages_in_bundle(bundle, ARM), source).checked()


def folder_with(path: Path, text: str) -> Path:
    where = path / "src" / "own_msgs" / "msg"
    where.mkdir(parents=True)
    (where / "Arm.msg").write_text(text)
    (where / "Joint.msg").write_text(JOINT)
    return path


def recording_with(path: Path, text: str) -> Path:
    bundle = f"{text}{'=' * 80}\nMSG: own_msgs/Joint\n{JOINT}"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", library="a test")
        schema = writer.register_schema(ARM, "ros2msg", bundle.encode())
        channel = writer.register_channel("/arm", "cdr", schema, {"offered_qos_profiles": ""})
        writer.add_message(channel, 1, b"\x00\x01\x00\x00", 1)
        writer.finish()
    return path


def test_a_folder_and_a_recording_that_are_named_define_an_own_type(tmp_path: Path) -> None:
    wanted = type_hash(arm())
    for named in (folder_with(tmp_path / "ws", TEXT), recording_with(tmp_path / "a.mcap", TEXT)):
        found = DefinitionFinder(named).find(ARM, wanted, "/arm")
        assert str(named) in found.source
        assert type_hash(found) == wanted
        # Of what it is made of, too.
        assert type_hash(DefinitionFinder(named).find("own_msgs/msg/Joint", "", "/joint"))


def test_a_folder_need_not_hold_the_installed_types_that_its_own_are_made_of(
    tmp_path: Path,
) -> None:
    where = tmp_path / "nav2_msgs" / "action"
    where.mkdir(parents=True)
    text = "geometry_msgs/PoseStamped pose\n---\nuint16 code\n---\nfloat32 distance_remaining\n"
    (where / "NavigateToPose.action").write_text(text)
    found = DefinitionFinder(tmp_path).find_action("nav2_msgs/action/NavigateToPose", "/go")
    assert "geometry_msgs/msg/PoseStamped" in found.send_goal.request.parts


def test_what_the_robot_says_comes_before_files(tmp_path: Path) -> None:
    finder = DefinitionFinder(folder_with(tmp_path, TEXT))
    assert finder.find(ARM, type_hash(arm()), "/arm", arm()).source == "a robot"


def test_another_version_is_refused_with_both_hashes(tmp_path: Path) -> None:
    finder = DefinitionFinder(folder_with(tmp_path, OTHER))
    wanted = type_hash(arm())
    with pytest.raises(DefinitionMismatch) as refused:
        finder.find(ARM, wanted, "/arm")
    said = str(refused.value)
    assert said.startswith(f"/arm: its publisher's {ARM} is {wanted}")
    assert type_hash(arm(OTHER)) in said
    assert str(tmp_path) in said
    # And the right one is found behind a wrong one.
    assert finder.find(ARM, wanted, "/arm", arm()).source == "a robot"


def test_the_version_of_the_distribution_that_the_robot_has_is_found() -> None:
    """``Marker`` has other fields in Foxy than from Humble on."""
    finder = DefinitionFinder(None)
    newest = finder.find("visualization_msgs/msg/Marker", "", "/marker")
    old = next(
        found
        for found in finder._distributions.find("visualization_msgs/msg/Marker")
        if type_hash(found) != type_hash(newest)
    )
    found = finder.find("visualization_msgs/msg/Marker", type_hash(old), "/marker")
    assert type_hash(found) == type_hash(old)


def test_a_type_that_nobody_defines_is_missing_and_says_what_helps(tmp_path: Path) -> None:
    with pytest.raises(TypeMissing, match=r"own_msgs.*'definitions'"):
        DefinitionFinder(None).find(ARM, "RIHS01_" + "ab" * 32, "/arm")
    with pytest.raises(TypeMissing, match="is empty"):
        DefinitionFinder(tmp_path / "nowhere_here").find(ARM, "", "/arm")
    (tmp_path / "broken.mcap").write_bytes(b"noise")
    with pytest.raises(TypeMissing, match="is no recording of ROS 2"):
        DefinitionFinder(tmp_path / "broken.mcap").find(ARM, "", "/arm")
