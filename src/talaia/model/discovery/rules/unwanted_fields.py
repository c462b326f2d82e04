"""Which topics and fields are no signals, and why: constants, settings, names, layouts. Pure.

Nothing is left out without a word: each rule says why, and the description's first lines carry it.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from talaia.model.discovery.probe_report import FieldFound, TopicFound

__all__ = ["WantedFields", "hidden_reason", "wanted_fields"]

QUATERNION = "an orientation as a quaternion; a position shows where it points"
_SURE = "how sure a number is, not a number of its own"
_CONSTANT = "it does not change while the robot runs"
_TIME = "a time; each sample has its own"
_NAMES = "names of what its other lists carry"
_OWN_NAME = "the name of what the values beside it are of"
_NO_SENSOR = "every value that came was NaN, so there is probably no such sensor"
_PADDING = "it fills room"
_LAYOUT = "how the numbers lie in the message"
# What a type says of itself again and again, by type: the first step of the path.
_CONSTANTS = {
    "sensor_msgs/msg/BatteryState": {
        "capacity",
        "design_capacity",
        "power_supply_technology",
        "present",
        "location",
        "serial_number",
    },
    "sensor_msgs/msg/Range": {"radiation_type", "field_of_view", "min_range", "max_range"},
    "sensor_msgs/msg/NavSatFix": {"position_covariance_type"},
}
_FIRST_STEPS = {
    # Which systems of satellites the receiver knows.
    ("sensor_msgs/msg/NavSatFix", "status.service"): _CONSTANT,
}
_MOVING = ("nav_msgs/msg/Odometry", "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
# Lists of names beside lists of numbers.
_NAME_LISTS = re.compile(r"(?:.*_)?names?\[\d+\]\Z")
_TIMES = re.compile(
    r"(?:.*\.)?(?:timestamp|time_?stamp|(?:\w+_)?stamp|timestamp_sample|seq|time_usec|time_ref)\Z"
)
_SURE_FIELDS = re.compile(r"(?:.*[._])?(?:variance|covar|covariance|covariance_type)(?:\[\d+\])?\Z")
_FILLING = re.compile(r"(?:.*\.)?_?(?:padding|reserved)\d*(?:\[\d+\])?\Z")
_QUATERNION_LIST = re.compile(r"(?P<base>(?:.*\.)?(?:q|quaternion|orientation))\[[0-3]\]\Z")
_PART = re.compile(r"(?P<base>.+)\.[xyzw]\Z")


class WantedFields(NamedTuple):
    """The fields that are signals, and in words what is not."""

    fields: tuple[FieldFound, ...]
    left_out: tuple[str, ...]


def hidden_reason(name: str) -> str:
    """Say that a topic, service or action is hidden by its name; empty of one that is not."""
    hidden = any(part.startswith("_") for part in name.strip("/").split("/"))
    return "hidden by its name (ROS's rule for what begins with _)" if hidden else ""


def wanted_fields(topic: TopicFound, *, level: bool) -> WantedFields:
    """Part the fields of a topic into signals and what is none.

    Args:
        topic: what was found.
        level: the robot moves on level ground, and neither climbs, rolls nor pitches.

    """
    paths = {field.path for field in topic.fields}
    kept: list[FieldFound] = []
    # By reason, in the order of the message; several of one reason are one line.
    why: dict[str, list[str]] = {}
    for field in topic.fields:
        base = _quaternion_of(field.path, paths)
        reason = QUATERNION if base else _reason(topic, field, level=level)
        if not reason:
            kept.append(field)
            continue
        named = why.setdefault(reason, [])
        shown = base or field.path
        if shown not in named:
            named.append(shown)
    said = tuple(f"{topic.topic} {', '.join(named)}: {reason}" for reason, named in why.items())
    return WantedFields(tuple(kept), said)


def _quaternion_of(path: str, paths: set[str]) -> str:
    """Give the path of the quaternion that a number belongs to; empty where it is none's."""
    listed = _QUATERNION_LIST.match(path)
    if listed is not None:
        base = listed["base"]
        return base if {f"{base}[{index}]" for index in range(4)} <= paths else ""
    part = _PART.match(path)
    if part is None:
        return ""
    base = part["base"]
    return base if {f"{base}.{axis}" for axis in "xyzw"} <= paths else ""


def _reason(topic: TopicFound, field: FieldFound, *, level: bool) -> str:
    path = field.path
    if field.name and path.endswith("].name"):
        return _OWN_NAME
    if field.empty:
        return _NO_SENSOR
    if path.split(".", 1)[0].split("[", 1)[0] in _CONSTANTS.get(topic.type, ()):
        return _CONSTANT
    if (topic.type, path) in _FIRST_STEPS:
        return _FIRST_STEPS[topic.type, path]
    if level and topic.type in _MOVING and _is_still(path):
        return "always 0 for what drives on level ground"
    for pattern, reason in (
        (_SURE_FIELDS, _SURE),
        (_TIMES, _TIME),
        (_FILLING, _PADDING),
        (_NAME_LISTS, _NAMES if field.type == "text" else ""),
    ):
        if reason and pattern.match(path):
            return reason
    return _LAYOUT if path.startswith("layout.") else ""


def _is_still(path: str) -> bool:
    return path.endswith(("linear.z", "angular.x", "angular.y")) or path == "pose.pose.position.z"
