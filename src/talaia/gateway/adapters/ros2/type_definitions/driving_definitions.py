"""Definitions of the messages that drive and that neither a wheel nor a distribution here brings.

Written by us as their packages have them, so that a vehicle with steered wheels or an arm is driven
from a machine without `ackermann_msgs` or `control_msgs`. Listeners that speak another version have
another hash, and are never written to by these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    PartDefinition,
    TypeDefinition,
)
from talaia.gateway.adapters.ros2.type_definitions.message_text import parts_in

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["DrivingDefinitions"]

_SOURCE = "Talaia's own definition"
_TEXTS = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "ackermann_msgs/msg/AckermannDrive": (
        "float32 steering_angle\n"
        "float32 steering_angle_velocity\n"
        "float32 speed\n"
        "float32 acceleration\n"
        "float32 jerk\n"
    ),
    "ackermann_msgs/msg/AckermannDriveStamped": "std_msgs/Header header\nAckermannDrive drive\n",
    "control_msgs/msg/JointJog": (
        "std_msgs/Header header\n"
        "string[] joint_names\n"
        "float64[] displacements\n"
        "float64[] velocities\n"
        "float64 duration\n"
    ),
}


class DrivingDefinitions:
    """A `DefinitionSource` of few types."""

    def find(self, type_name: str) -> Iterable[TypeDefinition]:
        """See `DefinitionSource.find`."""
        if type_name not in _TEXTS:
            return []
        parts: dict[str, PartDefinition] = {}
        for name, text in _TEXTS.items():
            parts |= parts_in(text, name)
        # Which takes of them what the type is made of.
        return [TypeDefinition(type_name, parts, _SOURCE).checked()]
