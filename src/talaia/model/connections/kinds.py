"""The robot protocols by name."""

from __future__ import annotations

from enum import StrEnum

__all__ = ["ROS_KINDS", "ConnectionKind"]


class ConnectionKind(StrEnum):
    """The robot protocols."""

    ROS2 = "ros2"
    ROS1 = "ros1"
    ROSBRIDGE = "rosbridge"
    INDI = "indi"
    PROCESS = "process"
    VIDEO = "video"
    MQTT = "mqtt"
    HTTP = "http"
    SOCKETIO = "socketio"
    ALPACA = "alpaca"
    ONVIF = "onvif"
    # Whatever an installed extension speaks; see docs/how-to/extend.
    EXTENSION = "extension"


# These name things as ROS does: topics, services, types.
ROS_KINDS = frozenset({ConnectionKind.ROS2, ConnectionKind.ROS1, ConnectionKind.ROSBRIDGE})
