"""What a ROS 1 message definition says: fields, constants, parts and comments. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple, cast

from rosbags.interfaces import Nodetype
from rosbags.typesys import TypesysError, get_types_from_msg

from talaia.gateway.adapters.message_fields import RosMessageType
from talaia.gateway.adapters.ros2.type_definitions.field_comments import comments_in
from talaia.gateway.errors import FieldError
from talaia.ros_definitions import OutOfBounds, check_names, check_type_name

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosbags.interfaces.typing import FieldDesc

__all__ = ["MessageDefinition", "definition_of"]

_MAX = 1_000_000
_RULE = re.compile(r"^={40,}\s*$", re.MULTILINE)
_NAMED = re.compile(r"\s*MSG:\s*(\S+)[^\n]*\n?")


class MessageDefinition(NamedTuple):
    """A definition's types by ``package/Name``, and what stands beside their fields."""

    kinds: dict[str, RosMessageType]
    comment_of: Callable[[str, str], str]


def definition_of(text: str, type_name: str) -> MessageDefinition:
    """Read a definition with those of its parts, as a publisher tells it.

    Args:
        text: the definition.
        type_name: ``package/Name``.

    Raises:
        FieldError: it is not understood.

    """
    if len(text) > _MAX:
        raise FieldError("", f"the definition of {type_name} is too long")
    try:
        check_type_name(type_name)
        found = get_types_from_msg(text, type_name)
        check_names(found)
    except (OutOfBounds, TypesysError, ValueError, KeyError, RecursionError) as error:
        raise FieldError("", f"the definition of {type_name} is not understood") from error
    kinds = {
        _short_name(name): RosMessageType(
            tuple((field, _declared_type(kind)) for field, kind in fields),
            {
                name: value
                for name, _, value in constants
                if isinstance(value, int) and not isinstance(value, bool)
            },
        )
        for name, (constants, fields) in found.items()
    }
    comments = _read_comments(text, type_name)
    return MessageDefinition(kinds, lambda kind, field: comments.get(kind, {}).get(field, ""))


def _read_comments(text: str, type_name: str) -> dict[str, dict[str, str]]:
    first, *others = _RULE.split(text)
    found = {type_name: comments_in(first)}
    for part in others:
        named = _NAMED.match(part)
        if named is not None:
            found[_short_name(named[1])] = comments_in(part[named.end() :])
    return found


def _short_name(name: str) -> str:
    return name.replace("/msg/", "/")


def _declared_type(kind: FieldDesc) -> str:
    """Write a type as ROS 2 does."""
    node, inner = kind
    if node == Nodetype.NAME:
        return _short_name(str(inner))
    if node == Nodetype.BASE:
        return str(inner[0])
    item, size = cast("tuple[FieldDesc, int]", inner)
    named = _declared_type(item)
    return f"{named}[{size}]" if node == Nodetype.ARRAY else f"sequence<{named}>"
