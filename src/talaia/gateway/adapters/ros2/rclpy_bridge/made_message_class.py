"""Message classes of types that are not installed, by which raw messages are subscribed to.

rclpy wants a class for a subscription, and the middleware takes from it nothing but the type's
name and hash as long as messages are taken as bytes. So the class of ``std_msgs/msg/String`` is
copied at the C level and gets another name: the functions in it are never called for messages.
Nothing is ever published with such a class but bytes: its objects hold nothing.

Only ``rmw_fastrtps_cpp``: other middlewares ask for more than a name. Also used by a bridge's own
Python; nothing of ROS is loaded before a class is made, for a bridged gateway imports this, too.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

from .rosidl_structs import (
    Callbacks,
    Support,
    capsule_of,
    introspect_if_wanted,
    keep_for_ever,
    string_support,
    tell_hash,
)

__all__ = ["CannotMakeClass", "forget_error", "is_made", "made_class"]

# What rclpy wants a class to have, beside its type support.
_FOR_OBJECTS = (
    "_CREATE_ROS_MESSAGE",
    "_DESTROY_ROS_MESSAGE",
    "_CONVERT_FROM_PY",
    "_CONVERT_TO_PY",
)


class CannotMakeClass(RuntimeError):
    """ROS's libraries are not as they are known."""


class _Made:
    """What all made classes are."""


@functools.lru_cache(maxsize=None)  # noqa: UP033 - Python 3.8
def made_class(type_name: str, type_hash: str) -> Any:  # noqa: ANN401 - as rosidl's classes
    """Make the class of ``package/msg/Name``; the same one for the same type.

    Args:
        type_name: which.
        type_hash: what its publisher says, ``RIHS01_…``; empty where nobody says it.

    Raises:
        CannotMakeClass: ROS's libraries are not as they are known.

    """
    try:
        from std_msgs.msg import String

        support = _support_of(type_name, type_hash)
    except (ImportError, OSError, AttributeError, ValueError) as error:
        raise CannotMakeClass(f"no class can be made of {type_name}: {error}") from error
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
