"""Raw ROS 1 messages decoded by the definition that comes with them: any type, no package."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from talaia.gateway.errors import FieldError
from talaia.wire.type_bounds import OutOfBounds, check_text, check_types

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["decoder_of", "full_name"]


def full_name(ros1: str) -> str:
    """Write ``std_msgs/String`` as descriptions do: ``std_msgs/msg/String``."""
    package, _, name = ros1.partition("/")
    return f"{package}/msg/{name}"


def decoder_of(type_name: str, definition: str) -> Callable[[bytes], object]:
    """Make a decoder of a message definition as the publisher of ``type_name`` told it.

    Raises:
        FieldError: the definition is not understood.

    """
    # A store of its own: another publisher's type of the same name may have other fields.
    store = get_typestore(Stores.EMPTY)
    try:
        # Before anything is made of it: rosbags writes a class of this name, and runs it.
        check_text(type_name, definition)
        types = get_types_from_msg(definition, type_name)
        check_types(types)
        store.register(types)
    except OutOfBounds as error:
        raise FieldError("", f"{type_name[:200]!r} is not read: {error}") from error
    except (TypesysError, ValueError, KeyError, SyntaxError, RecursionError) as error:
        raise FieldError("", f"the definition of {type_name} is not understood") from error
    decode = store.deserialize_ros1

    def read(raw: bytes) -> object:
        try:
            return decode(raw, type_name)
        except (SerdeError, KeyError, ValueError, IndexError) as error:
            raise FieldError("", f"a message is not of {type_name}: {error}") from error

    return read
