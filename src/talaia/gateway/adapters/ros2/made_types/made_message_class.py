"""Message classes of types that are not installed, made by whichever process has rclpy.

Where ROS 2 is this process's own, by `rclpy_bridge.made_message_class`. Where it is a system's, the
bridge makes the class when a subscription or a publisher is made, and here stands the type's name
and hash.
"""

from __future__ import annotations

from typing import Any

import rclpy

from talaia.gateway.adapters.ros2.rclpy_bridge import made_message_class as own
from talaia.gateway.adapters.ros2.rclpy_bridge.made_message_class import is_made
from talaia.gateway.adapters.ros2.system_ros.entities import PackagelessMessage
from talaia.gateway.adapters.ros2.system_ros.start import is_bridged
from talaia.gateway.errors import GatewayError

__all__ = [
    "CannotMakeTypes",
    "forget_error",
    "is_made",
    "made_class",
    "problem_here",
]

_MIDDLEWARE = "rmw_fastrtps_cpp"


class CannotMakeTypes(GatewayError):
    """Classes for types that are not installed cannot be made here."""


def problem_here() -> str:
    """Say why no type can be used by its name; empty where it can."""
    used = rclpy.get_rmw_implementation_identifier()
    if used != _MIDDLEWARE:
        return f"the middleware is {used}, and only {_MIDDLEWARE} takes types by name"
    return ""


def made_class(type_name: str, type_hash: str) -> Any:  # noqa: ANN401 - as rosidl's classes
    """Make the class of ``package/msg/Name``, or what stands for it where ROS is the bridge's.

    Args:
        type_name: which.
        type_hash: what its publisher says, ``RIHS01_…``; empty where nobody says it.

    Raises:
        CannotMakeTypes: ROS's libraries are not as they are known.

    """
    if is_bridged():
        return PackagelessMessage(type_name, type_hash)
    try:
        return own.made_class(type_name, type_hash)
    except own.CannotMakeClass as error:
        raise CannotMakeTypes(str(error)) from error


def forget_error() -> None:
    """See `own.forget_error`; a bridge forgets its own, and this process has none of ROS's."""
    if not is_bridged():
        own.forget_error()
