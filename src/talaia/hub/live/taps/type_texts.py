"""Definitions of ROS messages as their publishers tell them: texts to fields.

`rosbags` reads them. It is loaded when somebody first wants a message read.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from talaia.errors import TalaiaError
from talaia.wire.type_bounds import OutOfBounds, check_text, check_types

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict
    from rosbags.typesys.store import Typestore

__all__ = ["MessageUnreadable", "TypeText", "brought_store", "read_definitions"]

# What reads ROS 1's own ``time`` and ``duration``, as types of ROS 2.
_ROS1_TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")


class MessageUnreadable(TalaiaError):
    """A definition, or bytes, that cannot be read; a sentence for people."""


class TypeText(NamedTuple):
    """A definition's text and the form that it has, as MCAP names it (``ros2msg``)."""

    type: str
    encoding: str
    definition: str


def read_definitions(text: TypeText) -> Typesdict:
    """Give the fields of a type and of the types in it.

    Raises:
        MessageUnreadable: there is no definition, or none that can be read, or it is beyond what
            one may be.

    """
    from rosbags.typesys import TypesysError, get_types_from_idl, get_types_from_msg

    if not text.definition:
        raise MessageUnreadable(f"there is no definition of {text.type[:200]!r}")
    try:
        check_text(text.type, text.definition)
        if text.encoding == "ros2idl":
            found = get_types_from_idl(text.definition)
        else:
            found = get_types_from_msg(text.definition, text.type)
        check_types(found)
    except OutOfBounds as error:
        raise MessageUnreadable(f"{text.type[:200]!r} is not read: {error}") from error
    except (TypesysError, SyntaxError, RecursionError) as error:
        raise MessageUnreadable(f"{text.type}: {str(error)[:300]}") from error
    if text.encoding == "ros1msg":
        # There they are no messages, so no definition has them.
        found = {**{name: brought_store().fielddefs[name] for name in _ROS1_TIMES}, **found}
    return found


@cache
def brought_store() -> Typestore:
    """Give the types that come with ROS."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.LATEST)
