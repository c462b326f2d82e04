"""Message classes of types that are not installed, by which raw messages are subscribed to.

rclpy wants a class for a subscription, and the middleware takes from it nothing but the type's
name and hash as long as messages are taken as bytes. So the class of ``std_msgs/msg/String`` is
copied at the C level and gets another name: the functions in it are never called for messages.
Nothing is ever published with such a class: its objects hold nothing.

Only ``rmw_fastrtps_cpp``: other middlewares ask for more than a name. The structs are those of
rosidl from Humble to Rolling, where they only grew at their ends. rcl keeps bare pointers, so what
is made is kept for ever.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

import rclpy
from std_msgs.msg import String

from talaia.gateway.adapters.ros2.made_types.rosidl_structs import (
    Callbacks,
    Support,
    capsule_of,
    introspect_if_wanted,
    keep_for_ever,
    string_support,
    tell_hash,
)
from talaia.gateway.adapters.ros2.system_ros.start import is_bridged
from talaia.gateway.errors import GatewayError

__all__ = ["CannotMakeTypes", "forget_error", "is_made", "made_class", "problem_here"]

_MIDDLEWARE = "rmw_fastrtps_cpp"
# What rclpy wants a class to have, beside its type support.
_FOR_OBJECTS = (
    "_CREATE_ROS_MESSAGE",
    "_DESTROY_ROS_MESSAGE",
    "_CONVERT_FROM_PY",
    "_CONVERT_TO_PY",
)


class CannotMakeTypes(GatewayError):
    """Classes for types that are not installed cannot be made here."""


class _Made:
    """What all made classes are."""


def problem_here() -> str:
    """Say why no classes can be made with the middleware in use; empty where they can."""
    if is_bridged():
        return "the system's ROS 2 is used by a process of its own, which knows its packages alone"
    used = rclpy.get_rmw_implementation_identifier()
    if used != _MIDDLEWARE:
        return f"the middleware is {used}, and only {_MIDDLEWARE} takes types by name"
    return ""


@functools.cache
def made_class(type_name: str, type_hash: str) -> Any:  # noqa: ANN401 - as rosidl's classes
    """Make the class of ``package/msg/Name``; the same one for the same type.

    Args:
        type_name: which.
        type_hash: what its publisher says, ``RIHS01_…``; empty where nobody says it.

    Raises:
        CannotMakeTypes: ROS's libraries are not as they are known.

    """
    try:
        support = _support_of(type_name, type_hash)
    except (OSError, AttributeError, ValueError) as error:
        raise CannotMakeTypes(f"no class can be made of {type_name}: {error}") from error
    meta = type(String)
    if vars(meta)["_TYPE_SUPPORT"] is None:
        meta.__import_type_support__()
    # Those for objects are never called: nothing is taken or published but bytes.
    parts = {name: vars(meta)[name] for name in _FOR_OBJECTS}
    parts["_TYPE_SUPPORT"] = capsule_of(ctypes.addressof(support))
    name = type_name.rsplit("/", 1)[1]
    return type(f"Metaclass_{name}", (type,), parts)(name, (_Made,), {})


def is_made(kind: Any) -> bool:  # noqa: ANN401
    """Tell whether a message's class is one that was made here."""
    return isinstance(kind, type) and issubclass(kind, _Made)


def forget_error() -> None:
    """Forget the error that the middleware leaves after it has made something of such a class.

    From Kilted on it looks for an introspection of the type, finds none, and goes on; rclpy would
    raise what it left behind at the next opportunity.
    """
    ctypes.CDLL("librcutils.so").rcutils_reset_error()


def _support_of(type_name: str, type_hash: str) -> Support:
    package, middle, name = type_name.split("/")
    model = string_support()
    like = ctypes.cast(model.data, ctypes.POINTER(Callbacks)).contents
    callbacks = keep_for_ever(
        Callbacks(
            f"{package}::{middle}".encode(),
            name.encode(),
            like.serialize,
            like.deserialize,
            like.size,
            like.most,
            None,
        )
    )
    support: Support = keep_for_ever(
        Support(model.identifier, ctypes.addressof(callbacks), model.find)
    )
    tell_hash(support, type_name, type_hash)
    introspect_if_wanted(support, callbacks)
    return support
