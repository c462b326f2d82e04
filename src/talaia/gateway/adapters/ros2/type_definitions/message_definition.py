"""What a ROS 2 message type is made of, and the hash by which two sides know the same type. Pure.

A definition comes from whoever knows it (a package, the robot itself, a file); the hash of
REP-2011 (``RIHS01_…``) tells whether it is the one that a publisher speaks. It covers names and
types of fields, all the way down, and neither constants nor comments.
"""

from __future__ import annotations

import hashlib
import json
import re
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.errors import GatewayError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = [
    "TYPE_IDS",
    "BadDefinition",
    "FieldForm",
    "FieldType",
    "MessageField",
    "PartDefinition",
    "TypeDefinition",
    "collect_parts",
    "is_type_name",
    "type_hash",
]

# type_description_interfaces/msg/FieldType; ``char`` is IDL's, a ``.msg`` file's is an uint8.
TYPE_IDS = {
    "int8": 2,
    "uint8": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "char": 13,
    "bool": 15,
    "byte": 16,
    "string": 17,
    "wstring": 18,
}
_NESTED = 1
# A string with a bound has another id: 17 → 21, 18 → 22.
_BOUNDED_TEXT = 4
# An empty message has one byte all the same.
_FILLER = "structure_needs_at_least_one_member"
# ``package/msg/Name``, or with srv or action; the parts of those end in _Request, _Goal and so on.
_TYPE_NAME = re.compile(r"[a-zA-Z]\w*/(msg|srv|action)/[a-zA-Z]\w*\Z", re.ASCII)
_FIELD_NAME = re.compile(r"[a-zA-Z]\w*\Z", re.ASCII)
# Decoders have a line of code for each element of an array of messages or texts.
_MAX_ELEMENTS = 4096
_MAX_TYPES = 1000
_MAX_DEPTH = 40


class BadDefinition(GatewayError):
    """What was read defines no type, or one that cannot be decoded here."""


class FieldForm(IntEnum):
    """How many of a field's type there are; the value is what is added to the type's id."""

    ONE = 0
    ARRAY = 48
    BOUNDED = 96
    SEQUENCE = 144


class FieldType(NamedTuple):
    """The type of a field.

    Attributes:
        base: a key of `TYPE_IDS`, or ``package/msg/Name``.
        form: one, or how many.
        size: of an array its length, of a bounded sequence the most.
        text_bound: of a text the most characters; 0 sets no bound.

    """

    base: str
    form: FieldForm = FieldForm.ONE
    size: int = 0
    text_bound: int = 0


class MessageField(NamedTuple):
    """A field: its name and type."""

    name: str
    type: FieldType


class PartDefinition(NamedTuple):
    """One message type, without those that it is made of.

    Attributes:
        fields: in order; none of an empty message.
        constants: whole numbers by name.
        text: as its author wrote it (``.msg``); empty where that is not known.

    """

    fields: tuple[MessageField, ...]
    constants: Mapping[str, int]
    text: str = ""


class TypeDefinition(NamedTuple):
    """A message type with all that it is made of.

    Attributes:
        name: ``package/msg/Name``.
        parts: itself and the types below it, by their names.
        source: where it comes from, in words.

    """

    name: str
    parts: Mapping[str, PartDefinition]
    source: str = ""

    def checked(self) -> TypeDefinition:
        """Give it with what it is made of alone, if that can be decoded.

        Raises:
            BadDefinition: its name is none, a part is missing, contains itself, or has a field
                that no type has.

        """
        if not is_type_name(self.name):
            raise BadDefinition(f"{self.name[:200]!r} is no name of a type")
        found: dict[str, PartDefinition] = {}
        self._collect(self.name, (), found)
        return self._replace(parts=found)

    def _collect(self, name: str, above: tuple[str, ...], found: dict[str, PartDefinition]) -> None:
        if name in above or len(above) > _MAX_DEPTH or len(found) > _MAX_TYPES:
            raise BadDefinition(f"{self.name}: {name} contains itself, or too much")
        if name in found:
            return
        part = self.parts.get(name)
        if part is None:
            raise BadDefinition(f"{self.name}: nothing is known of {name}, which it is made of")
        for field in part.fields:
            self._check_field(name, field)
            if field.type.base not in TYPE_IDS:
                self._collect(field.type.base, (*above, name), found)
        # After its own parts: decoders are made in this order.
        found[name] = part

    def _check_field(self, owner: str, field: MessageField) -> None:
        kind = field.type
        if not _FIELD_NAME.match(field.name):
            raise BadDefinition(f"{owner}: {field.name[:80]!r} is not the name of a field")
        if kind.base not in TYPE_IDS and not is_type_name(kind.base):
            raise BadDefinition(f"{owner}.{field.name}: {kind.base[:80]!r} is not a type")
        plain = kind.base in TYPE_IDS and kind.base not in ("string", "wstring")
        if kind.form is FieldForm.ARRAY and not plain and kind.size > _MAX_ELEMENTS:
            raise BadDefinition(
                f"{owner}.{field.name}: an array of {kind.size} {kind.base}; "
                f"at most {_MAX_ELEMENTS} can be decoded"
            )


def collect_parts(
    type_name: str, read_parts: Callable[[str], Mapping[str, PartDefinition]]
) -> dict[str, PartDefinition]:
    """Read a type and all that it is made of, each once.

    Args:
        type_name: of the type.
        read_parts: gives what stands where a type is defined, by names; nothing where none is.

    """
    parts: dict[str, PartDefinition] = {}
    wanted = [type_name]
    while wanted:
        name = wanted.pop()
        if name in parts:
            continue
        read = read_parts(name)
        parts |= read
        wanted += [
            field.type.base
            for part in read.values()
            for field in part.fields
            if field.type.base not in TYPE_IDS
        ]
    return parts


def is_type_name(name: str) -> bool:
    """Tell whether this is ``package/msg/Name``, or with ``srv`` or ``action``."""
    return _TYPE_NAME.match(name) is not None


def type_hash(definition: TypeDefinition) -> str:
    """Give the hash of a checked definition, ``RIHS01_`` and 64 hexadecimal digits (REP-2011)."""
    parts = definition.parts
    described = {
        "type_description": _described(definition.name, parts[definition.name]),
        "referenced_type_descriptions": [
            _described(name, parts[name]) for name in sorted(parts) if name != definition.name
        ],
    }
    return f"RIHS01_{hashlib.sha256(json.dumps(described).encode()).hexdigest()}"


def _described(name: str, part: PartDefinition) -> dict[str, object]:
    fields = part.fields or (MessageField(_FILLER, FieldType("uint8")),)
    return {
        "type_name": name,
        "fields": [{"name": field.name, "type": _described_type(field.type)} for field in fields],
    }


def _described_type(kind: FieldType) -> dict[str, object]:
    number = TYPE_IDS.get(kind.base, _NESTED) + (_BOUNDED_TEXT if kind.text_bound else 0)
    return {
        "type_id": number + kind.form,
        "capacity": kind.size,
        "string_capacity": kind.text_bound,
        "nested_type_name": "" if kind.base in TYPE_IDS else kind.base,
    }
