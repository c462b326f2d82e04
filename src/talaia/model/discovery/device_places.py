"""Which device a topic, service or action belongs to. Pure.

The same name and type always give the same place, whatever was asked before: so what a robot says
under one namespace comes together on one page.
"""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.connections.ros import DIAGNOSTICS
from talaia.model.discovery.ros_units import readable_name, word_of
from talaia.model.site import DeviceKind, DriveMessage

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.discovery.probe_report import TopicFound

__all__ = [
    "ODOMETRY",
    "PICTURES",
    "TWISTS",
    "DevicePlace",
    "is_no_base",
    "place_of",
    "place_order",
    "robot_namespace",
    "spoken_space",
]

PICTURES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
# Velocities that a base may listen to.
TWISTS = {
    "geometry_msgs/msg/Twist": DriveMessage.TWIST,
    "geometry_msgs/msg/TwistStamped": DriveMessage.TWIST_STAMPED,
}
ODOMETRY = "nav_msgs/msg/Odometry"
# ROS's own packages of messages: their names say nothing of the device.
_COMMON_PACKAGES = ("std_msgs", "sensor_msgs", "geometry_msgs")
# What people look for first comes first; all others follow by their words.
_FIRST_KINDS = (DeviceKind.VEHICLE, DeviceKind.CAMERA, DeviceKind.POWER)


# Of an arm, a head, a camera or a turret: its velocities are no vehicle's.
_NO_BASE = re.compile(
    r"servo|delta_twist|twist_controller|tool|tcp|gripper|end_effector"
    r"|(?:^|_)(?:arm|ee|head|turret|gimbal|ptz)"
)


# What people write in capitals, where a topic has small letters.
_ABBREVIATIONS = {
    *("bms", "can", "cctv", "cpu", "dvl", "ekf", "fmu", "gnss", "gps", "hmi", "imu", "io", "led"),
    *("mcu", "pdu", "ptz", "rc", "rgb", "rov", "rtk", "tcp", "ups", "usb", "usv", "utm"),
}
# Namespaces that say what is in them, whatever its type: `/rov/camera/tilt` is of the camera.
_KINDS_OF_SPACES = {
    "allsky": DeviceKind.CAMERA,
    "battery": DeviceKind.POWER,
    "camera": DeviceKind.CAMERA,
    "cctv": DeviceKind.CAMERA,
    "dome": DeviceKind.DOME,
    "pdu": DeviceKind.POWER,
    "telescope": DeviceKind.TELESCOPE,
    "weather": DeviceKind.WEATHER,
    "weather_station": DeviceKind.WEATHER,
}
# Of topics in a namespace, so many in a hundred are in the robot's own if it has one.
_OWN_SHARE = 80


class DevicePlace(NamedTuple):
    """A device that something belongs to: its word in addresses, its name, its kind."""

    word: str
    name: str
    kind: DeviceKind


def place_of(topic: str, type_name: str, found: Iterable[TopicFound]) -> DevicePlace:
    """Give the device of a topic, service or action, by its type first and then its namespace.

    Args:
        topic: its name.
        type_name: ``package/msg/Name``, or with ``srv`` or ``action``.
        found: all topics of the robot.

    """
    spaces = topic.strip("/").split("/")[:-1]
    if type_name in PICTURES or type_name == "sensor_msgs/msg/CameraInfo":
        if spaces and _KINDS_OF_SPACES.get(spaces[-1]) is DeviceKind.CAMERA:
            return _named_place("", "", DeviceKind.CAMERA, spaces)
        # A camera's topics share its namespace (`/front/image_raw`, `/front/camera_info`), and
        # that names the picture; what stands before it names the device.
        return _named_place("camera", "Camera", DeviceKind.CAMERA, spaces[:-1])
    if type_name == "sensor_msgs/msg/BatteryState":
        return _named_place("power", "Battery", DeviceKind.POWER, spaces)
    if type_name.startswith("nav_msgs/") or (
        type_name.startswith("geometry_msgs/msg/Twist") and not is_no_base(topic)
    ):
        # A controller has no page of its own: `/mobile_base_controller/odom` is the base's.
        own = [space for space in spaces if not space.endswith("_controller")]
        spaces = _driven_space(own, found)
        return _named_place("base", "Vehicle base", DeviceKind.VEHICLE, spaces)
    if type_name == "sensor_msgs/msg/JointState" and (
        not spaces or _is_robot("/".join(spaces), found)
    ):
        # All joints of a message move together: they are one thing on a page.
        return _named_place("joints", "Joints", DeviceKind.OTHER, spaces)
    if type_name == DIAGNOSTICS:
        return _named_place("diagnostics", "Diagnostics", DeviceKind.OTHER, spaces)
    if spaces:
        if _is_robot("/".join(spaces), found):
            # Its namespace is the robot's: an IMU in it is a part of what drives.
            driven = _driven_space(spaces, found)
            return _named_place("base", "Vehicle base", DeviceKind.VEHICLE, driven)
        return _named_place("", "", _KINDS_OF_SPACES.get(spaces[-1], DeviceKind.OTHER), spaces)
    package = type_name.split("/", 1)[0]
    if "/srv/" in type_name or "/action/" in type_name:
        # A service without a namespace belongs to what drives: it is the robot as a whole.
        velocities = [other.topic for other in found if _is_driven_by(other)]
        if not velocities:
            return _named_place("robot", "Robot", DeviceKind.OTHER, ())
        return place_of(velocities[0], "geometry_msgs/msg/Twist", found)
    if package in _COMMON_PACKAGES:
        return _named_place("sensors", "Sensors", DeviceKind.OTHER, ())
    # A package of the maker's own is named after the device: `gripper_msgs`.
    trimmed = package.removesuffix("_msgs").removesuffix("_interfaces") or package
    return _named_place(trimmed, readable_name(trimmed), DeviceKind.OTHER, ())


def is_no_base(topic: str) -> bool:
    """Tell whether a topic is an arm's, a head's or a tool's, by its name."""
    return any(_NO_BASE.search(part) for part in topic.strip("/").lower().split("/"))


def place_order(place: DevicePlace) -> tuple[int, str]:
    """Give a key to sort places by: vehicles, cameras, batteries, then all others."""
    kinds = _FIRST_KINDS
    return (kinds.index(place.kind) if place.kind in kinds else len(kinds), place.word)


def _named_place(word: str, name: str, kind: DeviceKind, spaces: Iterable[str]) -> DevicePlace:
    # The namespace goes before: two bases of one robot have different pages.
    parts = [space for space in spaces if space]
    # None twice: `/gps/gps`, `/imu/imu`.
    parts = [part for part, after in pairwise([*parts, ""]) if part != after]
    named = [spoken_space(part) for part in parts]
    if named and _is_said(name, named[-1]):
        # `/robot/battery/status` is of its battery, and not of its battery's battery.
        if len(name.split()) > len(named[-1].split()):
            named[-1] = name.lower()
        name = word = ""
    whole = "_".join([*parts, word] if word else parts)
    title = " ".join([*named, name.lower()] if name and named else named or [name])
    return DevicePlace(word_of(whole), title[:1].upper() + title[1:], kind)


def spoken_space(part: str) -> str:
    """Say a part of a namespace as within a name: in small letters, but for abbreviations."""
    words = readable_name(part).split()
    return " ".join(
        word.upper() if word.lower() in _ABBREVIATIONS else word if word.isupper() else word.lower()
        for word in words
    )


def _is_said(name: str, part: str) -> bool:
    """Tell whether the last word of a device's name is in a part before it: `/front_camera`."""
    last = name.lower().rpartition(" ")[2]
    return bool(last) and last in part.lower().replace("cameras", "camera").split()


def _driven_space(spaces: list[str], found: Iterable[TopicFound]) -> list[str]:
    """Give the namespace of the robot that drives, at or above another; else that one itself.

    So the odometry of a controller or a filter is the base's: `/platform/odom` under `/cmd_vel`.
    """
    driven = {
        topic.topic
        for topic in found
        # What the robot's own programs command is inside it.
        if topic.type in TWISTS and topic.subscribers > 0 and not topic.publishers
    }
    for length in range(len(spaces), -1, -1):
        if "/" + "/".join([*spaces[:length], "cmd_vel"]) in driven:
            return spaces[:length]
    return spaces


def _is_robot(space: str, found: Iterable[TopicFound]) -> bool:
    """Tell whether a namespace is that of something that drives."""
    return any(
        topic.topic.strip("/").rpartition("/")[0] == space
        and (_is_driven_by(topic) or (topic.type == ODOMETRY and topic.publishers > 0))
        for topic in found
    )


def robot_namespace(found: Iterable[TopicFound]) -> str:
    """Give the namespace of the one robot that was found; empty for none and for several.

    It holds what the robot says as a whole: that of what drives alone, beside others of its arms
    and its head, is none.
    """
    topics = tuple(found)
    driving = {
        topic.topic.strip("/").split("/", 1)[0] for topic in topics if _drives(topic, topics)
    }
    if len(driving) != 1:
        return ""
    space = driving.pop()
    spaces = [topic.topic.split("/")[1] for topic in topics if topic.topic.count("/") > 1]
    return space if spaces.count(space) * 100 >= len(spaces) * _OWN_SHARE else ""


def _drives(topic: TopicFound, found: Iterable[TopicFound]) -> bool:
    space = topic.topic.strip("/").rpartition("/")[0]
    return bool(space) and _is_robot(space, found)


def _is_driven_by(topic: TopicFound) -> bool:
    return topic.type in TWISTS and topic.subscribers > 0 and "cmd_vel" in topic.topic
