"""Which velocity topics drive a robot on the ground, and why others do not. Pure.

A velocity is a velocity only by its topic's name: the same message is roll, pitch and thrust for a
small drone, a step of a tool for an arm, and the inside of a chain of limiters for a stack that
navigates. Offered is one topic for each robot; the others are named with the reason.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.discovery.device_places import ODOMETRY, TWISTS, is_no_base

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.discovery.probe_report import Found, TopicFound

__all__ = [
    "ACKERMANN",
    "DriveTopics",
    "choose_drive_topics",
    "flies",
    "is_commanded_velocity",
    "is_holonomic",
    "is_no_base",
]

# Speed and the angle of steered wheels.
ACKERMANN = ("ackermann_msgs/msg/AckermannDrive", "ackermann_msgs/msg/AckermannDriveStamped")
# Packages that only robots use which fly.
_FLYING_PACKAGES = ("mavros_msgs/", "px4_msgs/", "crazyflie_interfaces/", "tello_msgs/")
_FLYING_WORDS = ("takeoff", "take_off", "land", "arming")
# Programs beside an autopilot, by their namespaces: their packages may be on no machine that looks.
_FLYING_SPACES = {"mavros", "fmu"}
# A velocity by this name is how fast it rolls, pitches and turns.
_TILTS = re.compile(r"attitude|body_rate|thrust")
# `cmd_vel`, `cmd_vel_unstamped`, `vel_cmd`, `cmdvel`.
_SAYS_VELOCITY = re.compile(r"cmd_?vel|vel(?:ocity)?_cmd|teleop_twist")
# Inputs of a multiplexer that are meant for a person, the surest first.
_BY_HAND = ("teleop", "key", "web", "manual", "tab", "joy")
_HAND_VELOCITY = re.compile(rf"(?:{'|'.join(_BY_HAND)})\w*_vel\Z")
# These say it together with the part before them: `/commands/velocity`, `/command/twist`.
_VELOCITY = ("velocity", "twist", "vel", "cmd", "drive")
_COMMAND = ("command", "commands", "cmd", "cmds", "base", "drive", "control", "reference")


# What only a base that moves sideways has: wheels, a controller, or a planner's own parameters.
_SIDEWAYS = re.compile(r"mecanum|omni_?wheel|omnidirectional|omni_drive|holonomic|swerve")
_SWIMS = re.compile(r"thruster|ballast|propeller|(?:^|[/_])dvl(?:$|[/_])")


class DriveTopics(NamedTuple):
    """The topics that drive, and in words why others are not offered.

    Attributes:
        left_out: by topic.

    """

    driving: tuple[TopicFound, ...]
    left_out: dict[str, str]


def is_commanded_velocity(topic: TopicFound) -> bool:
    """Tell whether a topic carries velocities that somebody obeys; what is in it is no reading."""
    return topic.subscribers > 0 and (topic.type in TWISTS or topic.type in ACKERMANN)


def flies(found: Found, topic: str) -> bool:
    """Tell whether what a topic belongs to flies, by its packages, topics and services."""
    space = _robot_of(topic)
    said = [
        *((one.topic, one.type) for one in found.topics),
        *((one.service, one.type) for one in found.services),
        *((one.action, one.type) for one in found.actions),
    ]
    return any(
        (
            type_name.startswith(_FLYING_PACKAGES)
            or _last(name) in _FLYING_WORDS
            or not _FLYING_SPACES.isdisjoint(name.strip("/").split("/")[:-1])
        )
        # Of its own namespace, or of a robot that has none; what has none may be any robot's.
        and (not space or _robot_of(name) in ("", space))
        for name, type_name in said
    )


def is_level(found: Found, topic: str) -> bool:
    """Tell whether what a topic belongs to moves on level ground: it neither flies nor swims."""
    names = [
        *(one.topic for one in found.topics),
        *(one.node for one in found.nodes),
        *(one.joint for one in found.joints),
    ]
    if any(_SWIMS.search(name.lower()) for name in names):
        return False
    return not flies(found, topic) and not is_no_base(topic)


def is_holonomic(found: Found) -> bool:
    """Tell whether anything says that the robot's base moves sideways; a Twist alone does not."""
    names = [
        *(one.topic for one in found.topics),
        *(one.node for one in found.nodes),
        *(one.joint for one in found.joints),
        *(parameter.parameter for node in found.nodes for parameter in node.parameters),
    ]
    return any(_SIDEWAYS.search(name.lower()) for name in names)


def choose_drive_topics(found: Found) -> DriveTopics:
    """Choose for each robot the topic that drives it."""
    left_out: dict[str, str] = {}
    fit: list[TopicFound] = []
    for topic in found.topics:
        if not is_commanded_velocity(topic):
            continue
        reason = _reason(found, topic)
        if reason:
            left_out[topic.topic] = reason
        else:
            fit.append(topic)
    # The surest first, so that the others are told by its name.
    driving: list[TopicFound] = []
    for topic in sorted(fit, key=_order):
        first = next((one for one in driving if _same_robot(one, topic, found.topics)), None)
        if first is None:
            driving.append(topic)
        elif topic.publishers:
            left_out[topic.topic] = (
                f"a velocity that the robot's own programs command; {first.topic} drives it"
            )
        else:
            left_out[topic.topic] = f"{first.topic} drives it already; name another under `drive`"
    return DriveTopics(tuple(driving), left_out)


def _reason(found: Found, topic: TopicFound) -> str:
    parts = topic.topic.strip("/").lower().split("/")
    if flies(found, topic.topic):
        return "by its other topics the robot flies: this may be roll, pitch and thrust, no driving"
    if any(_TILTS.search(part) for part in parts):
        return "by its name how it rolls, pitches and turns, and no driving"
    if is_no_base(topic.topic):
        return "by its name a velocity of an arm or a head, and no driving"
    # Speed and angle of steered wheels say by their type what they are.
    if topic.type not in ACKERMANN and not _says_velocity(parts):
        return "a velocity, by whose name nobody can say what moves; if a base, name it in `drive`"
    return ""


def _says_velocity(parts: list[str]) -> bool:
    if _SAYS_VELOCITY.search(parts[-1]) or _HAND_VELOCITY.match(parts[-1]):
        return True
    return len(parts) > 1 and parts[-1] in _VELOCITY and parts[-2] in _COMMAND


def _order(topic: TopicFound) -> tuple[bool, bool, bool, int, int, bool, str]:
    """Sort by how surely it is meant for whoever drives: the plain name, near the root."""
    parts = topic.topic.strip("/").lower().split("/")
    plain = parts[-1] == "cmd_vel"
    # What a multiplexer of the robot's own publishes comes behind what it chooses from: a person
    # who publishes there would talk against it, and its locks would not count.
    chosen = topic.publishers > 0 and not plain
    rank = next((at for at, word in enumerate(_BY_HAND) if word in parts[-1]), len(_BY_HAND))
    # A Twist is understood by tools and scripts, too.
    named = (not plain, chosen, rank, len(parts), topic.publishers > 0, topic.topic)
    return (topic.type in ACKERMANN, *named)


def _same_robot(first: TopicFound, other: TopicFound, found: Iterable[TopicFound]) -> bool:
    one, two = _robot_of(first.topic), _robot_of(other.topic)
    # What only says another way of steering is no robot of its own.
    if one == two or (not two and other.type in ACKERMANN):
        return True
    # Beside one without a namespace, another is a robot of its own only with its own odometry.
    space = other.topic.rpartition("/")[0]
    moves = any(
        one.type == ODOMETRY and one.publishers and one.topic.startswith(f"{space}/")
        for one in found
    )
    return not one and not (moves and _last(other.topic) == "cmd_vel" and not other.publishers)


def _robot_of(topic: str) -> str:
    first, _, rest = topic.strip("/").partition("/")
    return first if rest else ""


def _last(name: str) -> str:
    return name.rpartition("/")[2].lower()
