"""What a ROS message holds: every number, truth and text in it, by path. Pure.

Works on lists of fields and constants, as a ROS 2 class (`ros2_kinds`) or a ROS 1 definition
(`ros1_kinds`) tells them, and on one message for the lengths of lists. Long, because one descent
and what it makes of each kind of field are one thing.
"""

from __future__ import annotations

import math
import re
from numbers import Real
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.discovery.probe_report import FieldFound
from talaia.model.discovery.ros_units import (
    Meaning,
    meaning_of,
    readable_name,
    unit_in_comment,
    unit_in_name,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

__all__ = ["ReadableFields", "RosMessageType", "shape_of"]

# A list longer than this is a scan, a picture or a map, and its elements are no signals.
MAX_ELEMENTS = 16
# But of a list whose elements have names, each is a thing of its own: the joints of two arms.
MAX_NAMED = 64
# A text that is longer is a file: a robot's model, a program.
MAX_TEXT = 400
MAX_FIELDS = 400
MAX_DEPTH = 12
# As `get_fields_and_field_types` of ROS 2 writes them.
_INTEGERS = {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
_FLOATS = {"float", "double", "float32", "float64", "long double"}
# With its bound, if it has one: `string<10>`.
_TEXT = re.compile(r"w?string(<\d+>)?\Z")
# `sequence<double>`, `sequence<string, 4>` or `float[3]`; `.+?` leaves the bound to its own group.
_LIST = re.compile(
    r"(?:sequence<(?P<inner>.+?)(?:, (?P<bound>\d+))?>|(?P<item>.+)\[(?P<size>\d+)\])\Z"
)
# Texts that say what is in the lists beside them.
_NAME_LIST = re.compile(r"(?:.*_)?names?\Z")
# When, where from and how it lies in memory: not what a sensor says. Times stand beside every
# sample already.
_ABOUT = {
    "builtin_interfaces/Time",
    "builtin_interfaces/Duration",
    "std_msgs/Header",
    "std_msgs/MultiArrayLayout",
}


# A share of more than that is in percent already; a battery that is a little over full is not.
_WHOLE = 1.5


class ReadableFields(NamedTuple):
    """What can be read of a message, and in words what cannot.

    Attributes:
        stamped: it says itself of when it is, in a header.

    """

    fields: tuple[FieldFound, ...]
    left_out: tuple[str, ...]
    stamped: bool = False


class RosMessageType(NamedTuple):
    """A message type as its robot knows it.

    Attributes:
        fields: names, and types as ROS 2 writes them: ``double``, ``geometry_msgs/Point``,
            ``float[3]``, ``sequence<string, 4>``.
        constants: whole numbers by name.

    """

    fields: tuple[tuple[str, str], ...]
    constants: Mapping[str, int]


def shape_of(
    *,
    kind: RosMessageType,
    type_name: str,
    find: Callable[[str], RosMessageType | None],
    message: object = None,
    comment_of: Callable[[str, str], str] = lambda _type, _field: "",
) -> ReadableFields:
    """List the fields of a type.

    Args:
        kind: of a message, a request or a goal.
        type_name: ``package/Name``.
        find: gives the types of its parts, by ``package/Name``; none for one that is not known.
        message: one that was received, for the lengths of lists and the names of joints.
        comment_of: gives what the definition says beside a field of a type.

    """
    walk = _Walk(find, comment_of)
    fields = tuple(
        walk.walk_message(
            kind=kind, type_name=type_name, message=message, prefix="", above=None, depth=0
        )
    )
    stamped = ("header", "std_msgs/Header") in kind.fields
    return ReadableFields(fields[:MAX_FIELDS], tuple(walk.left_out), stamped)


class _Walk:
    """One descent through a message."""

    def __init__(
        self, find: Callable[[str], RosMessageType | None], comment_of: Callable[[str, str], str]
    ) -> None:
        self.left_out: list[str] = []  # Words for people: what was seen and is no field.
        self._find = find
        self._comment_of = comment_of

    def walk_message(
        self,
        *,
        kind: RosMessageType,
        type_name: str,
        message: object,
        prefix: str,
        above: Meaning | None,
        depth: int,
    ) -> Iterator[FieldFound]:
        # ROS forbids a type within itself; a peer's definition may say so all the same.
        if depth > MAX_DEPTH:
            self.left_out.append(f"{prefix}: nested deeper than {MAX_DEPTH}")
            return
        for field, declared in kind.fields:
            path = f"{prefix}.{field}" if prefix else field
            value = getattr(message, field, None)
            # A part takes the unit of the whole it belongs to, where it has none of its own.
            meaning = self._field_meaning(type_name, field, declared) or above
            # Names of coordinate frames are settings, no readings.
            if declared in _ABOUT or field.endswith("frame_id"):
                continue
            listed = _LIST.match(declared)
            if listed is None:
                yield from self._walk_field(
                    kind=kind,
                    field=field,
                    declared=declared,
                    path=path,
                    value=value,
                    meaning=meaning,
                    depth=depth,
                )
                continue
            # As in `sensor_msgs/JointState`, whose `name` says what the elements of the other lists
            # are.
            names = getattr(message, "name", None) if field != "name" else None
            yield from self._walk_list(
                listed=listed, path=path, value=value, meaning=meaning, names=names, depth=depth
            )

    def _field_meaning(self, type_name: str, field: str, declared: str) -> Meaning | None:
        listed = _LIST.match(declared)
        inner = declared if listed is None else listed["inner"] or listed["item"]
        return (
            # The known meaning of a type first, then what its author wrote, then what the name
            # suggests.
            meaning_of(type_name, field)
            or unit_in_comment(self._comment_of(type_name, field))
            or unit_in_name(field, whole=_simple_type(inner) == "integer")
        )

    def _walk_field(
        self,
        *,
        kind: RosMessageType,
        field: str,
        declared: str,
        path: str,
        value: object,
        meaning: Meaning | None,
        depth: int,
    ) -> Iterator[FieldFound]:
        simple = _simple_type(declared)
        if simple is None:
            nested = self._find(declared)
            if nested is None:
                self.left_out.append(f"{path}: the type {declared} is not known here")
            else:
                yield from self.walk_message(
                    kind=nested,
                    type_name=declared,
                    message=value,
                    prefix=path,
                    above=meaning,
                    depth=depth + 1,
                )
        elif simple == "text" and isinstance(value, str) and len(value) > MAX_TEXT:
            self.left_out.append(f"{path}: a text of {len(value)} characters")
        else:
            # States are counted by integers; a float with constants is none.
            words = _state_words(kind, field) if simple == "integer" else ()
            yield _field_found(path=path, simple=simple, meaning=meaning, value=value, words=words)

    def _walk_list(
        self,
        *,
        listed: re.Match[str],
        path: str,
        value: object,
        meaning: Meaning | None,
        names: object,
        depth: int,
    ) -> Iterator[FieldFound]:
        if path.endswith("covariance"):
            self.left_out.append(f"{path}: how sure a number is, not a number of its own")
            return
        inner = listed["inner"] or listed["item"]
        # The message's own length where there is one: sequences have none in their type.
        count = _length_of(value) if value is not None else int(listed["size"] or 0)
        if _TEXT.match(inner) and _NAME_LIST.match(path.rpartition(".")[2]):
            self.left_out.append(f"{path}: names of what its other lists carry")
            return
        if count > (MAX_NAMED if _length_of(names) == count else MAX_ELEMENTS):
            self.left_out.append(f"{path}: a list of {count}; name one of them as {path}[0]")
            return
        if count == 0:
            why = "no message came to tell its length" if value is None else "it is empty"
            self.left_out.append(f"{path}: a list, and {why}")
            return
        simple = _simple_type(inner)
        for index in range(count):
            item = _item_at(value, index)
            at = f"{path}[{index}]"
            if simple is not None:
                # Names only count where there is one for each element.
                named = _item_at(names, index) if _length_of(names) == count else None
                yield _field_found(
                    path=at,
                    simple=simple,
                    meaning=meaning,
                    value=item,
                    words=(),
                    name=named if isinstance(named, str) else "",
                )
                continue
            nested = self._find(inner)
            if nested is None:
                self.left_out.append(f"{path}: the type {inner} is not known here")
                return
            # A part with a name of its own: a motor, a battery.
            said = getattr(item, "name", "")
            for found in self.walk_message(
                kind=nested,
                type_name=inner,
                message=item,
                prefix=at,
                above=meaning,
                depth=depth + 1,
            ):
                is_named = isinstance(said, str) and said and not found.name
                yield msgspec.structs.replace(found, name=said[:100]) if is_named else found


def _field_found(
    *,
    path: str,
    simple: str,
    meaning: Meaning | None,
    value: object,
    words: tuple[str, ...],
    name: str = "",
) -> FieldFound:
    numeric = simple in ("number", "integer") and not words
    # Texts and states have no unit, whatever their name ends in.
    unit = meaning if meaning is not None and numeric else Meaning("")
    empty = isinstance(value, Real) and math.isnan(value)
    if unit.unit == "%" and isinstance(value, Real) and float(value) > _WHOLE:
        # ROS says 0 to 1; drivers that say 0 to 100 mean what they show.
        unit = Meaning("%")
    return FieldFound(path, simple, unit.unit, unit.scale, words, name[:100], empty)


def _simple_type(declared: str) -> str | None:
    if declared in _FLOATS:
        return "number"
    if declared in _INTEGERS or declared in ("octet", "byte", "char"):
        return "integer"
    if declared in ("boolean", "bool"):
        return "boolean"
    return "text" if _TEXT.match(declared) else None


def _state_words(kind: RosMessageType, field: str) -> tuple[str, ...]:
    """Name the states of a whole number by the type's constants that begin with its name.

    Only a list that counts from 0 without a gap is one; flags and commands with holes are not.
    """
    start = f"{field.upper()}_"
    found = {
        value: readable_name(name[len(start) :].lower())
        for name, value in kind.constants.items()
        if name.startswith(start)
    }
    if len(found) < 2 or sorted(found) != list(range(len(found))):
        return ()
    # Two states of one word could not be told apart.
    words = tuple(found[index] for index in range(len(found)))
    return words if len(set(words)) == len(words) else ()


def _length_of(value: object) -> int:
    try:
        return len(value)  # type: ignore[arg-type]
    except TypeError:
        return 0


def _item_at(value: object, index: int) -> object:
    try:
        return value[index]  # type: ignore[index]
    except (TypeError, IndexError, KeyError):
        return None
