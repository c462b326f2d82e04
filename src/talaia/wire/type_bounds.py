"""Bounds of message definitions of robots, gateways and files, before they are read. Pure.

`rosbags` writes Python source for each type and runs it: a type's name must be one. And a type
says how much there is to read: an array of a thousand million things that take no bytes would be
read for hours.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc, Typesdict

__all__ = ["MOST_DEFINITION", "MOST_VALUES", "OutOfBounds", "check_text", "check_types"]

# ``geometry_msgs/msg/Twist``, and ROS 1's own form without the middle.
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*){1,2}", re.ASCII)
# Characters; the longest of MoveIt's have some 60 000, with all their comments.
MOST_DEFINITION = 128 * 1024
# Types in one definition; a robot's largest has some dozens.
_MOST_TYPES = 500
# Values that the fixed lengths of a type may come to.
MOST_VALUES = 1_000_000


class OutOfBounds(TalaiaError):
    """A definition of which nothing may be made; a sentence for people."""


def check_text(name: str, definition: str) -> None:
    """Look at a type's name and the length of its definition.

    Raises:
        OutOfBounds: it is no type's name, or too long.

    """
    if not _TYPE.fullmatch(name):
        raise OutOfBounds(f"{name[:200]!r} is no name of a type")
    if len(definition) > MOST_DEFINITION:
        raise OutOfBounds(f"its definition has more than {MOST_DEFINITION} characters")


def check_types(types: Typesdict) -> None:
    """Look at how much there is to read of each type.

    Raises:
        OutOfBounds: more than may be, without end, or an array of what takes no bytes.

    """
    if len(types) > _MOST_TYPES:
        raise OutOfBounds(f"its definition has more than {_MOST_TYPES} types")
    known: dict[str, int] = {}
    for name in types:
        if not _TYPE.fullmatch(name):
            raise OutOfBounds(f"{name[:200]!r} is no name of a type")
        _count_values(name, types, known, ())


def _count_values(
    name: str, types: Typesdict, known: dict[str, int], around: tuple[str, ...]
) -> int:
    """Count the values that a type has at least; what is not defined here counts as one."""
    if name in around:
        raise OutOfBounds(f"{name} is in itself")
    if name not in known and name in types:
        count = 0
        for field, kind in types[name][1]:
            count += _values_of(kind, types, known, (*around, name))
            if count > MOST_VALUES:
                raise OutOfBounds(f"{name}.{field}: more than {MOST_VALUES} values of fixed number")
        known[name] = count
    return known.get(name, 1)


def _values_of(
    kind: FieldDesc, types: Typesdict, known: dict[str, int], around: tuple[str, ...]
) -> int:
    from rosbags.interfaces import Nodetype

    if kind[0] == Nodetype.BASE:
        return 1
    if kind[0] == Nodetype.NAME:
        return _count_values(kind[1], types, known, around)
    node, (element, length) = kind
    values = _values_of(element, types, known, around)
    if not values:
        raise OutOfBounds(f"{around[-1]}: a list of {element[1]}, which takes no bytes")
    return values * length if node == Nodetype.ARRAY else 1
