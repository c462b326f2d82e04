"""Types and fields of ROS that a description names, against those that something knows."""

from collections.abc import Mapping, Sequence

import pytest

from talaia.model.checks.ros_types.ros_type_checks import ros_type_findings
from talaia.model.checks.text_checks import check_text
from talaia.model.yaml_text.load import load_site
from talaia.ros_type_library import FieldKind

HEAD = """\
talaia: 1
site: robot
name: Robot
ros2: {}
devices:
  base:
    name: Base
"""
TWIST = "geometry_msgs/msg/Twist"


class Types:
    """Some types; of ``Twist`` two versions, of which the older has a header."""

    _all: Mapping[str, Sequence[Mapping[str, FieldKind]]] = {
        TWIST: [
            {name: FieldKind("geometry_msgs/msg/Vector3") for name in ("linear", "angular")},
            {"header": FieldKind("std_msgs/msg/Header")},
        ],
        "geometry_msgs/msg/Vector3": [{name: FieldKind("float64") for name in "xyz"}],
        "geometry_msgs/msg/Path": [
            {
                "points": FieldKind("geometry_msgs/msg/Vector3", many=True),
                "four": FieldKind("float64", many=True, length=4),
            }
        ],
        "std_msgs/msg/String": [{"data": FieldKind("string")}],
        "std_srvs/srv/SetBool_Request": [{"data": FieldKind("bool")}],
        "nav/action/Go_Goal": [{"x": FieldKind("float64")}],
        "nav/action/Go_Feedback": [{"left": FieldKind("float64")}],
    }

    def versions_of(self, type_name: str, part: str = "") -> Sequence[Mapping[str, FieldKind]]:
        return self._all.get(type_name + part, [])

    def names_in(self, package: str, middle: str) -> list[str]:
        start = f"{package}/{middle}/"
        return [name.removeprefix(start) for name in self._all if name.startswith(start)]

    def packages(self) -> list[str]:
        return ["geometry_msgs", "nav", "std_srvs"]


def told(part: str) -> tuple[list[str], list[str]]:
    """Give what is wrong with a device's part, and what is noted of it."""
    found = ros_type_findings(load_site(HEAD + part), Types())
    return [str(each) for each in found.mistakes], [str(each) for each in found.notes]


def signal(field: str, type_name: str = TWIST) -> str:
    source = f"{{topic: /t, type: {type_name}, field: '{field}'}}"
    return f"    signals:\n      a: {{name: A, source: {source}}}\n"


AT = "$.devices.base.signals.a.source"


@pytest.mark.parametrize(
    ("field", "type_name", "said"),
    [
        ("linaer.x", TWIST, f"{AT}.field: no field linaer in {TWIST}; did you mean linear?"),
        ("q", TWIST, f"{AT}.field: no field q in {TWIST}; it has: linear, angular"),
        (
            *("linear.w", TWIST),
            f"{AT}.field: no field w in geometry_msgs/msg/Vector3; it has: x, y, z",
        ),
        (
            *("linear.x.y", TWIST),
            f"{AT}.field: x of geometry_msgs/msg/Vector3 is a float64 and has no fields; "
            "leave out .y",
        ),
        ("linear[0].x", TWIST, f"{AT}.field: linear of {TWIST} is no list; write linear"),
        (
            *("points.x", "geometry_msgs/msg/Path"),
            f"{AT}.field: points of geometry_msgs/msg/Path is a list; write points[0].x",
        ),
        (
            *("four[4]", "geometry_msgs/msg/Path"),
            f"{AT}.field: four of geometry_msgs/msg/Path has 4 elements; write four[0] to four[3]",
        ),
        (
            *("x", "geometry_msgs/msg/Twits"),
            f"{AT}.type: no type Twits in geometry_msgs/msg; did you mean Twist?",
        ),
    ],
)
def test_what_no_version_of_a_type_has_is_wrong(field: str, type_name: str, said: str) -> None:
    assert told(signal(field, type_name)) == ([said], [])


@pytest.mark.parametrize(
    ("field", "type_name"),
    [
        ("linear.x", TWIST),
        # Of the other version; and nothing knows what a header is made of.
        ("header.stamp.sec", TWIST),
        ("points[7].x", "geometry_msgs/msg/Path"),
        ("four[3]", "geometry_msgs/msg/Path"),
        # Each has a finding of `check_site`.
        ("linear..x", TWIST),
        ("x", "no type"),
    ],
)
def test_what_some_version_has_is_right(field: str, type_name: str) -> None:
    assert told(signal(field, type_name)) == ([], [])


def test_fields_of_requests_goals_and_feedback_are_looked_for() -> None:
    mistakes, notes = told(
        """\
    commands:
      light: {name: Light, target: /on, type: std_srvs/srv/SetBool, fixed: {dat: true}}
      go:
        name: Go
        kind: action
        target: /go
        type: nav/action/Go
        progress: lefd
        arguments: {x: {type: number, field: y}}
"""
    )
    at = "$.devices.base.commands"
    assert mistakes == [
        f"{at}.light.fixed.dat: no field dat in std_srvs/srv/SetBool; did you mean data?",
        f"{at}.go.arguments.x.field: no field y in nav/action/Go; it has: x",
        f"{at}.go.progress: no field lefd in nav/action/Go; did you mean left?",
    ]
    assert notes == []


def test_a_package_that_nothing_knows_is_noted_once_and_is_no_mistake() -> None:
    part = signal("x", "my_robot/msg/State") + signal("y", "my_robot/msg/Other").replace(
        "    signals:\n      a:", "      b:"
    )
    mistakes, notes = told(part)
    assert mistakes == []
    assert len(notes) == 1
    assert "nothing here knows the package my_robot" in notes[0]


def test_a_package_that_is_spelled_nearly_as_a_known_one_is_told() -> None:
    _, notes = told(signal("x", "geometry_msg/msg/Twist"))
    assert notes[0].endswith("did you mean geometry_msgs?")


def test_they_stand_among_the_mistakes_of_a_text_with_their_lines() -> None:
    text = HEAD + signal("linaer.x").replace("name: A", "name: A, unit: m/z, feild: 1")
    report = check_text(text, known=Types())
    assert [(each.line, each.problem.split(" in ")[0]) for each in report.mistakes] == [
        (9, "unknown key 'feild'"),
        (9, "no field linaer"),
    ]
    assert [each.problem for each in report.notes] == [
        "the unit 'm/z' is shown as written; Talaia does not know what it measures"
    ]
    assert report.site is None


def test_a_number_that_is_read_from_a_text_is_noted() -> None:
    wrong, notes = told(signal("data", "std_msgs/msg/String"))
    assert wrong == []
    assert notes == [
        f"{AT}.field: data of std_msgs/msg/String is a text, and the signal is a number: of a text "
        "that is no number nothing is shown; if it holds words, write: type: text, or type: state "
        "with its words as states"
    ]


def test_an_argument_that_fills_an_element_of_a_list_is_judged_by_the_element() -> None:
    command = (
        "    commands:\n      a: {name: A, target: /t, kind: topic, type: geometry_msgs/msg/Path, "
        "arguments: {p: {type: number, field: 'points[0]'}}}\n"
    )
    assert told(command)[0] == [
        "$.devices.base.commands.a.arguments.p.field: points[0] of geometry_msgs/msg/Path is more "
        "than one value; write which of it: points[0].x, points[0].y, points[0].z"
    ]
