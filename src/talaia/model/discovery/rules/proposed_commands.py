"""Commands of services, actions and topics, by what their requests hold. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.discovery.ros_units import readable_name, unit_in_name, word_of
from talaia.model.discovery.rules.field_names import joint_title, plain_name
from talaia.model.discovery.topic_words import free_word, last_part, path_in_words
from talaia.model.site import Argument, ArgumentType, Command, CommandKind, CommandRole

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.model.discovery.probe_report import (
        ActionFound,
        FieldFound,
        Found,
        JointFound,
        PoseFound,
        TopicFound,
    )

__all__ = [
    "FOLLOW",
    "command_of",
    "goal_command",
    "is_servo",
    "jog_command",
    "lists_reason",
    "pose_commands",
    "stays_reason",
]

FOLLOW = "control_msgs/action/FollowJointTrajectory"
_ARGUMENT_TYPES = {
    "number": ArgumentType.NUMBER,
    "integer": ArgumentType.INTEGER,
    "boolean": ArgumentType.BOOLEAN,
    "text": ArgumentType.TEXT,
}
# Last parts that say nothing of what a topic commands: `/gripper/command`.
_NO_NAME = ("command", "commands", "cmd", "set", "data", "reference")
# Of one number: what a motor does as long as it is told nothing else.
_MOVING = re.compile(
    r"(?:^|_)(?:speed|velocity|vel|e?rpm|thrust|throttle|duty(?:_cycle)?|torque|effort)\Z"
)
# A step of a jog, at most: m/s and rad/s. A servo holds it for a fraction of a second.
_JOG_SPEED, _JOG_TURN = 0.05, 0.2
# Time that a pose may take (s): slow, until the owner says otherwise.
_POSE_S = 8
_MOST_POSES = 30
# By type: where the pose is, what the command is for, and words of a topic's name.
_GOALS: dict[str, tuple[str, CommandRole, tuple[str, ...]]] = {
    "geometry_msgs/msg/PoseStamped": ("pose.", CommandRole.VEHICLE_GOAL, ("goal",)),
    "nav2_msgs/action/NavigateToPose": ("pose.pose.", CommandRole.VEHICLE_GOAL, ()),
    "geometry_msgs/msg/PoseWithCovarianceStamped": (
        "pose.pose.",
        CommandRole.VEHICLE_INITIAL_POSE,
        ("initialpose", "initial_pose", "set_pose"),
    ),
}


def command_of(
    target: str, type_name: str, kind: CommandKind, fields: Iterable[FieldFound]
) -> Command:
    """Make a command of what a request, a goal or a message holds."""
    arguments: dict[str, Argument] = {}
    last = last_part(target, _NO_NAME)
    for field in fields:
        unit = field.unit
        if field.path == "data" and field.type == "number" and not unit:
            # `/mast/pan_rad` of type Float64: only the topic's name tells it.
            said = unit_in_name(last)
            unit = said.unit if said is not None and said.scale == 1.0 else ""
        arguments[free_word(word_of(field.path), arguments)] = Argument(
            type=_ARGUMENT_TYPES[field.type],
            field=field.path,
            name=_argument_name(field),
            # What is sent is not scaled: a share stays one.
            unit=unit if field.scale == 1.0 else "",
            default=_default_of(field),
        )
    return Command(
        name=plain_name(last) or last,
        target=target,
        type=type_name,
        kind=kind,
        arguments=arguments,
        # Nobody knows yet what it does; the owner takes the question away.
        confirm=True,
    )


def _argument_name(field: FieldFound) -> str:
    if field.path == "data":
        # std_msgs and std_srvs/SetBool call their one field so.
        return {"boolean": "On", "text": "Text"}.get(field.type, "Value")
    return path_in_words(field.path)


def _default_of(field: FieldFound) -> float | None:
    """Give where a quaternion starts: as it is, for all zeros would be no direction."""
    *_, above, last = ("", *field.path.split("."))
    if above != "orientation" or last not in "xyzw":
        return None
    return 1.0 if last == "w" else 0.0


def is_servo(topic: TopicFound) -> bool:
    """Tell whether a topic takes steps of an arm's tool (MoveIt Servo)."""
    return (
        topic.type == "geometry_msgs/msg/TwistStamped"
        and topic.subscribers > 0
        and last_part(topic.topic) in ("delta_twist_cmds", "twist_cmds", "servo_twist")
    )


def jog_command(topic: TopicFound, frame: str) -> Command:
    """Make the jog of an arm's tool: one step, which its servo ends by itself.

    Args:
        topic: what the servo listens to.
        frame: in which the step is meant.

    """
    axes = (("linear", "m/s", _JOG_SPEED, "Move"), ("angular", "rad/s", _JOG_TURN, "Turn about"))
    arguments = {
        f"{part}_{axis}": Argument(
            type=ArgumentType.NUMBER,
            field=f"twist.{part}.{axis}",
            name=f"{verb} {axis}",
            unit=unit,
            minimum=-most,
            maximum=most,
            default=0.0,
        )
        for part, unit, most, verb in axes
        for axis in "xyz"
    }
    sides = [side for side in ("left", "right") if side in topic.topic.lower()]
    return Command(
        # Which arm moves stands on the button.
        name=" ".join(["Jog", *sides]),
        target=topic.topic,
        type=topic.type,
        kind=CommandKind.TOPIC,
        description=f"One step of the tool in {frame}; the servo ends it by itself.",
        fixed={"header.frame_id": frame},
        arguments=arguments,
        confirm=True,
    )


def goal_command(target: str, type_name: str, kind: CommandKind) -> Command | None:
    """Make the command that the page Scene draws a goal with; none of what is no goal.

    A place on the plane and a heading are all that a vehicle's goal needs; the frame is asked.
    """
    found = _GOALS.get(type_name)
    if found is None:
        return None
    # An arm's tool has poses, too: a topic has to be called a goal.
    base, role, words = found
    last = last_part(target).lower()
    if kind is CommandKind.TOPIC and not any(word in last for word in words):
        return None
    places = {
        "x": (f"{base}position.x", "m", None),
        "y": (f"{base}position.y", "m", None),
        "qz": (f"{base}orientation.z", "", 0.0),
        "qw": (f"{base}orientation.w", "", 1.0),
    }
    frame = Argument(
        type=ArgumentType.TEXT,
        # An action's goal holds a stamped pose, which has the header.
        field="pose.header.frame_id" if kind is CommandKind.ACTION else "header.frame_id",
        name="Frame",
        default="map",
    )
    arguments = {
        name: Argument(type=ArgumentType.NUMBER, field=path, name=name, unit=unit, default=start)
        for name, (path, unit, start) in places.items()
    }
    return Command(
        name="Set position" if role is CommandRole.VEHICLE_INITIAL_POSE else plain_name(last),
        target=target,
        type=type_name,
        kind=kind,
        role=role,
        arguments={"frame": frame, **arguments},
        confirm=True,
    )


def pose_commands(action: ActionFound, found: Found) -> Iterator[tuple[str, Command]]:
    """Give a command for each named pose that an arm's controller can take, with its word."""
    known = {joint.joint: joint for joint in found.joints}
    chosen = [pose for pose in found.poses if _is_of(pose, action)]
    for pose in chosen[:_MOST_POSES]:
        if not _is_within(pose, known):
            continue
        # Names and places are two lists of one order.
        fixed: dict[str, float | int | bool | str] = {}
        for index, (joint, place) in enumerate(pose.joints.items()):
            fixed[f"trajectory.joint_names[{index}]"] = joint
            fixed[f"trajectory.points[0].positions[{index}]"] = place
        fixed["trajectory.points[0].time_from_start.sec"] = _POSE_S
        name = f"Move {readable_name(pose.group).lower()} to {readable_name(pose.pose).lower()}"
        yield (
            word_of(f"to {pose.group} {pose.pose}"),
            Command(
                name=name,
                target=action.action,
                type=action.type,
                kind=CommandKind.ACTION,
                description=f"{', '.join(map(joint_title, pose.joints))}, in {_POSE_S} s.",
                fixed=fixed,
                timeout=_POSE_S * 4.0,
                confirm=True,
            ),
        )


def _is_of(pose: PoseFound, action: ActionFound) -> bool:
    """Tell whether a pose is of the arm that an action moves: by its name where there are sides."""
    sides = [side for side in ("left", "right") if side in action.action.lower()]
    joints = " ".join(pose.joints).lower()
    return not sides or all(side in pose.group.lower() or side in joints for side in sides)


def _is_within(pose: PoseFound, known: dict[str, JointFound]) -> bool:
    for name, place in pose.joints.items():
        joint = known.get(name)
        # A joint that the model does not have, or a place beyond its end, is a mistake in it.
        if joint is None or not _lies_within(joint, place):
            return False
    return True


def _lies_within(joint: JointFound, place: float) -> bool:
    return joint.lower is None or joint.upper is None or joint.lower <= place <= joint.upper


def stays_reason(topic: TopicFound) -> str:
    """Say why a topic that takes lists is no command; empty of one that takes none."""
    last = topic.topic.lower()
    if _is_velocity(topic):
        return "it moves something until another value comes: somebody has to hold it, no form does"
    if topic.type.endswith("MultiArray") and "velocity" in last:
        return (
            "velocities of joints in an order that nobody tells: name them in it, each with its "
            "max_speed, under `drive` with this message"
        )
    return ""


def _is_velocity(topic: TopicFound) -> bool:
    """Tell whether a message moves something until another comes."""
    paths = {field.path for field in topic.fields}
    # A velocity within a message of the robot's own.
    twists = [path.removesuffix(".linear.x") for path in paths if path.endswith(".linear.x")]
    if any(f"{twist}.angular.z" in paths for twist in twists):
        return True
    # Or one number, of a wheel, a motor or a propeller.
    numbers = topic.type.startswith("std_msgs/msg/") and paths == {"data"}
    return numbers and _MOVING.search(last_part(topic.topic, _NO_NAME).lower()) is not None


def lists_reason(topic: TopicFound) -> str:
    """Say which lists of a message no form can fill; empty where there are none."""
    lists = [said.split(":", 1)[0] for said in topic.left_out]
    return f"its message holds lists ({', '.join(lists)})" if lists else ""
