"""Robots described as data, and what a probe finds of one: by its types, not by our words.

A robot's file says which topics, services, actions and parameters it has, with one message of each
topic where that matters. Which fields there are, the same code reads that a probe uses, from the
definitions of ROS's distributions and those in `robots/definitions`.
"""

from __future__ import annotations

import functools
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from talaia.gateway.adapters.message_fields import ReadableFields, RosMessageType, shape_of
from talaia.model.discovery.left_out_parameters import reason_to_leave
from talaia.model.discovery.probe_report import (
    ActionFound,
    Found,
    JointFound,
    NodeFound,
    ParameterFound,
    PoseFound,
    ServiceFound,
    TopicFound,
)

__all__ = ["FOLDER", "DescribedRobot", "class_of", "found_of", "read_robot", "robots_in"]

FOLDER = Path(__file__).parent / "robots"
_FILLER = "structure_needs_at_least_one_member"
_BASES = {"float64": "double", "float32": "float", "bool": "boolean"}
_ZERO = {"string": "", "wstring": "", "bool": False, "float32": 0.0, "float64": 0.0}


class DescribedRobot(NamedTuple):
    """One file.

    Attributes:
        published: by topic, its type, how often (Hz; ``latched``; 0 for silent) and a message.
        heard: by topic, the type that somebody listens to.
        services, actions: types by name.
        joints: by name, their type in the URDF, then limits: lower, upper, velocity, effort.
        parameters: by node, values by name.
        poses: by name, the group and the joints' places.

    """

    name: str
    published: dict[str, list[Any]]
    heard: dict[str, str]
    services: dict[str, str]
    actions: dict[str, str]
    joints: dict[str, list[Any]]
    parameters: dict[str, dict[str, Any]]
    poses: dict[str, dict[str, Any]]


def robots_in(folder: str) -> list[str]:
    """Name the robots of a folder below `FOLDER`."""
    return sorted(path.stem for path in (FOLDER / folder).glob("*.yaml"))


def class_of(type_name: str) -> Any:
    """Give a type's class; none of a package that is not installed."""
    package, middle, name = type_name.split("/")
    try:
        return getattr(import_module(f"{package}.{middle}"), name)
    except (ImportError, AttributeError):
        return None


def read_robot(folder: str, name: str) -> DescribedRobot:
    """Read a robot's file."""
    read = yaml.safe_load((FOLDER / folder / f"{name}.yaml").read_text())
    return DescribedRobot(
        read["name"], *(read.get(key) or {} for key in DescribedRobot._fields[1:])
    )


@functools.cache
def _definitions() -> dict[str, RosMessageType]:
    # The distribution that brings most, and packages that it does not bring.
    types: dict[str, Any] = {}
    for path in sorted((FOLDER / "definitions").glob("*.yaml")):
        for name, text in yaml.safe_load(path.read_text()).items():
            package, _, short = name.split("/")
            # Of a service or an action only what is asked: as a message, whatever it is.
            (kind,) = get_types_from_msg(text or "bool nothing", f"{package}/msg/{short}").values()
            types[name] = kind if text else ([], [])
    stored = get_typestore(Stores.ROS2_JAZZY).fielddefs
    return {name: _kind(definition) for name, definition in {**stored, **types}.items()}


def _kind(definition: Any) -> RosMessageType:
    constants, fields = definition
    return RosMessageType(
        tuple((name, _word(of)) for name, of in fields if name != _FILLER),
        {name: value for name, _, value in constants if isinstance(value, int)},
    )


def _word(described: Any) -> str:
    node, of = described
    if node.name == "NAME":
        package, _, short = of.split("/")
        return f"{package}/{short}"
    if node.name == "BASE":
        return _BASES.get(of[0], of[0])
    inner, length = of
    if node.name == "ARRAY":
        return f"{_word(inner)}[{length}]"
    return f"sequence<{_word(inner)}, {length}>" if length else f"sequence<{_word(inner)}>"


def _find(name: str) -> RosMessageType | None:
    package, _, short = name.partition("/")
    return _definitions().get(f"{package}/msg/{short}")


def _message(kind: RosMessageType, values: dict[str, Any]) -> Any:
    """Make a message with zeros but for the values."""
    made = SimpleNamespace()
    for name, declared in kind.fields:
        value = values.get(name)
        nested = _find(declared)
        if declared.startswith("sequence<"):
            inner = _find(declared[9:-1].split(",")[0])
            items = value or []
            value = [_message(inner, item) for item in items] if inner else items
        elif declared.endswith("]"):
            value = value or [0] * int(declared.rpartition("[")[2][:-1])
        elif nested is not None:
            value = _message(nested, value or {})
        elif value is None:
            value = "" if "string" in declared else declared == "x"
        setattr(made, name, value)
    return made


def _shape(type_name: str, values: dict[str, Any] | None) -> tuple[ReadableFields, str]:
    kind = _definitions().get(type_name)
    if kind is None:
        return ReadableFields((), ()), f"the package of {type_name} is not installed here"
    package, _, short = type_name.split("/")
    message = None if values is None else _message(kind, values)
    return shape_of(kind=kind, type_name=f"{package}/{short}", find=_find, message=message), ""


def _asked(type_name: str) -> tuple[ReadableFields, str]:
    shape, problem = _shape(type_name, {})
    lists = [field.split(":", 1)[0] for field in shape.left_out]
    if lists:
        problem = f"its request holds lists ({', '.join(lists)})"
    return shape, problem


def _topic(robot: DescribedRobot, topic: str) -> TopicFound:
    heard = topic in robot.heard
    if topic not in robot.published:
        shape, problem = _asked(robot.heard[topic])
        return TopicFound(
            topic, robot.heard[topic], 0, 1, fields=shape.fields, stamped=shape.stamped,
            problem=problem,
        )  # fmt: skip
    type_name, often, *values = robot.published[topic]
    silent = often == 0
    shape, problem = _shape(type_name, None if silent else (values[0] if values else {}))
    names = ()
    if type_name == "diagnostic_msgs/msg/DiagnosticArray" and values:
        names = tuple(status["name"] for status in values[0]["status"])
    return TopicFound(
        topic=topic,
        type=type_name,
        publishers=1,
        subscribers=int(heard),
        rate=0.0 if often == "latched" else float(often),
        latched=often == "latched",
        fields=shape.fields,
        names=names,
        left_out=shape.left_out,
        stamped=shape.stamped,
        problem=problem,
    )


_PARAMETERS = {bool: "boolean", int: "integer", float: "number", str: "text"}
_LISTS = {bool: "booleans", int: "integers", float: "numbers", str: "texts"}


def _node(name: str, values: dict[str, Any]) -> NodeFound:
    parameters, left_out = [], []
    for parameter, value in values.items():
        listed = isinstance(value, list)
        kind = _LISTS[type(value[0])] if listed else _PARAMETERS[type(value)]
        reason = reason_to_leave(parameter, kind, len(str(value)))
        if reason:
            left_out.append(f"{parameter}: {reason}")
        else:
            parameters.append(ParameterFound(parameter, kind))
    return NodeFound(name, parameters=tuple(parameters), left_out=tuple(left_out))


def _joint(name: str, said: list[Any]) -> JointFound:
    kind, *limits = said
    lower, upper, velocity, effort = (*limits, *[None] * 4)[:4]
    return JointFound(name, kind, lower, upper, velocity, effort)


def found_of(robot: DescribedRobot) -> Found:
    """Give what a probe finds of a robot."""
    services = {name: (kind, *_asked(kind)) for name, kind in robot.services.items()}
    actions = {name: (kind, *_asked(kind)) for name, kind in robot.actions.items()}
    return Found(
        talaia_probe=1,
        protocol="ros2",
        where=f"the described {robot.name}",
        seconds=5.0,
        domain=0,
        topics=tuple(_topic(robot, name) for name in sorted({*robot.published, *robot.heard})),
        services=tuple(
            ServiceFound(name, kind, shape.fields, problem)
            for name, (kind, shape, problem) in services.items()
        ),
        actions=tuple(
            ActionFound(name, kind, shape.fields, problem)
            for name, (kind, shape, problem) in actions.items()
        ),
        nodes=tuple(_node(name, values) for name, values in robot.parameters.items()),
        poses=tuple(
            PoseFound(name, said["group"], said["joints"]) for name, said in robot.poses.items()
        ),
        joints=tuple(_joint(name, said) for name, said in robot.joints.items()),
    )
