"""Joints and named poses in a robot's model: URDF and SRDF, as robots publish them. Pure.

The text is a robot's, and nobody has looked at it: it is bounded, declares nothing of its own, and
what is no number is no limit.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree as ET

from talaia.model.discovery.probe_report import JointFound, PoseFound

__all__ = ["joints_in", "poses_in"]

_MOST_TEXT = 4 * 1024 * 1024
_MOST_JOINTS = 500
_MOVING = ("revolute", "continuous", "prismatic")


def joints_in(urdf: str) -> tuple[JointFound, ...]:
    """List the joints that can move; none of a text that is no model."""
    model = _model_of(urdf)
    if model is None:
        return ()
    found = [_joint_of(joint) for joint in model.findall("joint")[:_MOST_JOINTS]]
    return tuple(joint for joint in found if joint is not None)


def poses_in(srdf: str) -> tuple[PoseFound, ...]:
    """List the poses that have a name; none of a text that is no model."""
    model = _model_of(srdf)
    if model is None:
        return ()
    found = []
    for state in model.findall("group_state")[:_MOST_JOINTS]:
        joints = {
            joint.get("name", ""): _number(joint.get("value"))
            for joint in state.findall("joint")[:_MOST_JOINTS]
        }
        # One that is not told whole would move the others somewhere.
        whole = {name: value for name, value in joints.items() if name and value is not None}
        if whole and len(whole) == len(joints):
            found.append(PoseFound(state.get("name", ""), state.get("group", ""), whole))
    return tuple(found)


def _model_of(text: str) -> ET.Element | None:
    # Entities grow without end; no model needs to declare any.
    if len(text) > _MOST_TEXT or "<!DOCTYPE" in text or "<!ENTITY" in text:
        return None
    try:
        model = ET.fromstring(text)  # noqa: S314 - nothing is declared in it
    except (ET.ParseError, ValueError):
        return None
    return model if model.tag == "robot" else None


def _joint_of(joint: ET.Element) -> JointFound | None:
    name, kind = joint.get("name", ""), joint.get("type", "")
    if not name or kind not in _MOVING:
        return None
    limit = joint.find("limit")
    said = {} if limit is None else limit.attrib
    ends = kind != "continuous"
    # As URDF has it: an end that is not told is 0.
    lower = _number(said.get("lower", "0")) if ends and said else None
    upper = _number(said.get("upper", "0")) if ends and said else None
    if lower is None or upper is None or lower >= upper:
        lower = upper = None
    return JointFound(
        name, kind, lower, upper, _number(said.get("velocity")), _number(said.get("effort"))
    )


def _number(text: str | None) -> float | None:
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if math.isfinite(value) else None
