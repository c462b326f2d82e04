"""What this machine knows of ROS types: files of packages, and the distributions' definitions."""

from pathlib import Path

import pytest

from talaia.ros_type_library import FieldKind, RosTypeLibrary


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    folder = tmp_path / "my_robot"
    for name, text in {
        "msg/State.msg": "# how it is\nstd_msgs/Header header\nfloat64[3] arm\nstring<=8 word\n"
        "uint8 OFF=0\nWheel[] wheels",
        "srv/Ask.srv": "# nothing is asked\n---\nbool done",
        "action/Go.action": "float64 x\n---\n---\nfloat32 left",
        "msg/Broken.msg": "float64 [",
    }.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


def test_fields_are_read_from_a_folder_of_definitions(workspace: Path) -> None:
    library = RosTypeLibrary([workspace])
    assert list(library.versions_of("my_robot/msg/State")) == [
        {
            "header": FieldKind("std_msgs/msg/Header"),
            "arm": FieldKind("float64", many=True, length=3),
            "word": FieldKind("string"),
            "wheels": FieldKind("my_robot/msg/Wheel", many=True),
        }
    ]
    assert list(library.versions_of("my_robot/srv/Ask", "_Request")) == [{}]
    assert list(library.versions_of("my_robot/srv/Ask", "_Response")) == [
        {"done": FieldKind("bool")}
    ]
    assert list(library.versions_of("my_robot/action/Go", "_Goal")) == [{"x": FieldKind("float64")}]
    assert list(library.versions_of("my_robot/action/Go", "_Result")) == [{}]
    assert list(library.versions_of("my_robot/action/Go", "_Feedback")) == [
        {"left": FieldKind("float32")}
    ]


def test_a_file_that_cannot_be_read_tells_nothing_but_its_name(workspace: Path) -> None:
    library = RosTypeLibrary([workspace, workspace / "missing"])
    assert list(library.versions_of("my_robot/msg/Broken")) == []
    assert library.names_in("my_robot", "msg") == ["Broken", "State"]
    assert "my_robot" in library.packages()


def test_common_types_are_known_without_a_ros_on_the_machine() -> None:
    library = RosTypeLibrary()
    assert any("linear" in fields for fields in library.versions_of("geometry_msgs/msg/Twist"))
    assert "LaserScan" in library.names_in("sensor_msgs", "msg")
    assert library.names_in("nobody_has_it", "msg") == []
    assert list(library.versions_of("nobody_has_it/msg/Thing")) == []
