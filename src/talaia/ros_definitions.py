"""What may be made of a message definition that a robot, a gateway or a file tells. Pure.

`rosbags` writes Python source for each type and runs it: whatever becomes a name in it must be one.
And a type says how much there is to read: an array of a thousand million things that take no bytes
would be read for hours. Every store is made of types that were looked at here.
"""

from __future__ import annotations

import keyword
import re
from typing import TYPE_CHECKING, Any

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from rosbags.interfaces.typing import FieldDesc, Typesdict

__all__ = [
    "MOST_DEFINITION",
    "MOST_VALUES",
    "OutOfBounds",
    "check_names",
    "check_text",
    "check_type_name",
    "check_types",
]

# ``geometry_msgs/msg/Twist``, and ROS 1's own form without the middle.
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*){1,2}", re.ASCII)
# Of a field or a constant, and of rosbags' own words for numbers and texts.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
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
    check_type_name(name)
    if len(definition) > MOST_DEFINITION:
        raise OutOfBounds(f"its definition has more than {MOST_DEFINITION} characters")


def check_type_name(name: str) -> None:
    """Look at a type's name.

    Raises:
        OutOfBounds: it is none.

    """
    # A keyword of Python would not be run; it would not be read either.
    if not _TYPE.fullmatch(name) or keyword.iskeyword(name):
        raise OutOfBounds(f"{name[:200]!r} is no name of a type")


def check_names(types: Typesdict) -> None:
    """Look at all that becomes a name, or a value, in what is written and run.

    Raises:
        OutOfBounds: something of it is none.

    """
    for name, (constants, fields) in types.items():
        check_type_name(name)
        for field, kind in fields:
            _check_name(name, field)
            _check_kind(name, field, kind)
        for constant, word, value in constants:
            _check_name(name, constant)
            _check_name(name, str(word))
            # Written as Python writes it; of other kinds nobody knows how that is.
            if type(value) not in {bool, int, float, str}:
                raise OutOfBounds(f"{name}.{constant}: no number and no text")


def check_types(types: Typesdict) -> None:
    """Look at all names, and at how much there is to read of each type.

    Raises:
        OutOfBounds: see `check_names`; or more than may be, without end, or an array of what takes
            no bytes.

    """
    if len(types) > _MOST_TYPES:
        raise OutOfBounds(f"its definition has more than {_MOST_TYPES} types")
    check_names(types)
    known: dict[str, int] = {}
    for name in types:
        _count_values(name, types, known, ())


def _check_name(owner: str, name: str) -> None:
    if not _NAME.fullmatch(name):
        raise OutOfBounds(f"{owner}: {name[:200]!r} is no name")


def _check_kind(owner: str, field: str, kind: FieldDesc) -> None:
    from rosbags.interfaces import Nodetype

    described: Any = kind
    node, of = described
    if node == Nodetype.BASE:
        _check_name(f"{owner}.{field}", of[0])
    elif node == Nodetype.NAME:
        check_type_name(of)
    else:
        element, length = of
        # A length is written as it is.
        if type(length) is not int or length < 0:
            raise OutOfBounds(f"{owner}.{field}: {str(length)[:80]!r} is no length")
        _check_kind(owner, field, element)


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

    described: Any = kind
    node, of = described
    if node == Nodetype.BASE:
        return 1
    if node == Nodetype.NAME:
        return _count_values(of, types, known, around)
    element, length = of
    values = _values_of(element, types, known, around)
    if not values:
        raise OutOfBounds(f"{around[-1]}: a list of {element[1]}, which takes no bytes")
    return values * length if node == Nodetype.ARRAY else 1
