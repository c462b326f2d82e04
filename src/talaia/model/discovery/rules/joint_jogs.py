"""Topics that take velocities of joints: which are driven, by which joints and how fast. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.connection import RosSource
from talaia.model.discovery.rules.field_names import JOINTS, joint_title
from talaia.model.site import Drive, DriveMessage, DrivenJoint

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.discovery.probe_report import Found, JointFound, TopicFound
    from talaia.model.site import Signal

__all__ = ["is_joint_jog", "joint_drive"]

# Slow enough to look at what it does: rad/s, and m/s of a joint that slides; and never more than
# this share of what the model says that the joint can.
_CAREFUL = 0.1
_CAREFUL_SLIDE = 0.02
_SHARE = 0.2
# Wheels are driven by a base, and fingers have a command of their own.
_NO_ARM = re.compile(r"wheel|caster|finger|gripper|knuckle|thumb|hand")
_MOST_JOINTS = 32


def is_joint_jog(topic: TopicFound) -> bool:
    """Tell whether velocities of joints are listened to by their names (MoveIt Servo)."""
    return topic.subscribers > 0 and topic.type == DriveMessage.JOINT_JOG.value


def joint_drive(topic: TopicFound, found: Found, signals: Mapping[str, Signal]) -> Drive | str:
    """Make the driving of an arm's joints, or say why there is none.

    Args:
        topic: is a `is_joint_jog`.
        found: has the joints of the robot's model.
        signals: what is read of joints, by address.

    """
    names = [one for one in _arm_joints(topic, found) if not _NO_ARM.search(one.joint.lower())]
    if not names:
        return "velocities of joints, and no model of the robot (URDF) says which it has"
    joints = {one.joint: _driven(one, signals) for one in names[:_MOST_JOINTS]}
    return Drive(topic=topic.topic, message=DriveMessage.JOINT_JOG, joints=joints)


def _arm_joints(topic: TopicFound, found: Found) -> list[JointFound]:
    """Give the joints that named poses are of; of one side, where the topic names it."""
    posed = {joint for pose in found.poses for joint in pose.joints}
    known = [one for one in found.joints if not posed or one.joint in posed]
    sides = [side for side in ("left", "right") if side in topic.topic.lower()]
    return [one for one in known if all(side in one.joint.lower() for side in sides)]


def _driven(joint: JointFound, signals: Mapping[str, Signal]) -> DrivenJoint:
    slides = joint.type == "prismatic"
    limit = _CAREFUL_SLIDE if slides else _CAREFUL
    # What the model has no number for goes by ours.
    if joint.velocity:
        limit = min(limit, joint.velocity * _SHARE)
    position = _position_of(joint, signals)
    return DrivenJoint(
        name=joint_title(joint.joint),
        max_speed=limit,
        position=position,
        # An end holds only where it is known how the joint stands.
        minimum=joint.lower if position else None,
        maximum=joint.upper if position else None,
        slides=slides,
    )


def _position_of(joint: JointFound, signals: Mapping[str, Signal]) -> str:
    title = f"{joint_title(joint.joint)} position"
    for address, signal in signals.items():
        source = signal.source
        if isinstance(source, RosSource) and source.type == JOINTS and signal.name == title:
            return address
    return ""
