"""Reads the type descriptions that robots give, and those that packages install as JSON. Pure.

``type_description_interfaces`` of REP-2011: each field with the number of its type, and the
texts that the types were made from, which alone have constants and comments.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import msgspec

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TYPE_IDS,
    BadDefinition,
    FieldForm,
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
)
from talaia.gateway.adapters.ros2.type_definitions.message_text import parts_in

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

__all__ = ["definition_in_json", "definition_of_description"]

_NESTED, _LAST = 1, 192
_WORDS = {number: word for word, number in TYPE_IDS.items()}
# Texts with a bound: 21 and 22.
_BOUNDED_TEXTS = {21: "string", 22: "wstring"}
_FILLER = "structure_needs_at_least_one_member"
# An answer that is longer than this is not looked at.
_MAX_TYPES = 1000


class _FieldType(Protocol):
    """``FieldType``, as a message or from JSON."""

    @property
    def type_id(self) -> int: ...
    @property
    def capacity(self) -> int: ...
    @property
    def string_capacity(self) -> int: ...
    @property
    def nested_type_name(self) -> str: ...


class _Field(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def type(self) -> _FieldType: ...


class _One(Protocol):
    """``IndividualTypeDescription``."""

    @property
    def type_name(self) -> str: ...
    @property
    def fields(self) -> Sequence[_Field]: ...


class _Whole(Protocol):
    """``TypeDescription``."""

    @property
    def type_description(self) -> _One: ...
    @property
    def referenced_type_descriptions(self) -> Sequence[_One]: ...


class _Text(Protocol):
    """``TypeSource``."""

    @property
    def type_name(self) -> str: ...
    @property
    def encoding(self) -> str: ...
    @property
    def raw_file_contents(self) -> str: ...


class _JsonKind(msgspec.Struct, frozen=True):
    type_id: int
    capacity: int = 0
    string_capacity: int = 0
    nested_type_name: str = ""


class _JsonField(msgspec.Struct, frozen=True):
    name: str
    type: _JsonKind


class _JsonOne(msgspec.Struct, frozen=True):
    type_name: str
    fields: tuple[_JsonField, ...]


class _JsonWhole(msgspec.Struct, frozen=True):
    type_description: _JsonOne
    referenced_type_descriptions: tuple[_JsonOne, ...] = ()


class _JsonFile(msgspec.Struct, frozen=True):
    type_description_msg: _JsonWhole


def definition_of_description(
    described: _Whole, texts: Iterable[_Text], source: str
) -> TypeDefinition:
    """Read a robot's answer.

    Args:
        described: the type, and those that it is made of.
        texts: what they were made from; those that say other fields are left aside.
        source: who says so, in words.

    Raises:
        BadDefinition: it is none, or has a type that cannot be decoded here.

    """
    if len(described.referenced_type_descriptions) > _MAX_TYPES:
        raise BadDefinition(f"{source} describes more than {_MAX_TYPES} types at once")
    written = _read_texts(texts)
    parts = {}
    for one in (described.type_description, *described.referenced_type_descriptions):
        fields = tuple(_field_of(one.type_name, field) for field in one.fields)
        if [field.name for field in fields] == [_FILLER]:
            fields = ()
        # The text has what the description lacks, but only the description is hashed.
        author = written.get(one.type_name)
        if author is not None and author.fields == fields:
            parts[one.type_name] = author
        else:
            parts[one.type_name] = PartDefinition(fields, {})
    return TypeDefinition(described.type_description.type_name, parts, source).checked()


def definition_in_json(data: bytes, type_name: str, source: str) -> TypeDefinition:
    """Read what a package installs beside a ``.msg`` file, for a type that has none.

    Raises:
        BadDefinition: see `definition_of_description`; or it describes another type.

    """
    try:
        described = msgspec.json.decode(data, type=_JsonFile).type_description_msg
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise BadDefinition(f"{source} describes no type: {error}") from error
    if described.type_description.type_name != type_name:
        raise BadDefinition(f"{source} describes another type than {type_name}")
    return definition_of_description(described, (), source)


def _read_texts(texts: Iterable[_Text]) -> Mapping[str, PartDefinition]:
    found: dict[str, PartDefinition] = {}
    for text in texts:
        if text.encoding not in ("msg", "srv", "action") or text.type_name.count("/") != 2:
            continue
        try:
            found |= parts_in(text.raw_file_contents, text.type_name)
        except BadDefinition:
            # The description itself has the fields.
            continue
    return found


def _field_of(owner: str, field: _Field) -> MessageField:
    kind = field.type
    number = kind.type_id
    form = next((form for form in reversed(FieldForm) if number > form), FieldForm.ONE)
    plain = number - form
    where = f"{owner[:120]}.{field.name[:80]}"
    if not 0 < number <= _LAST:
        raise BadDefinition(f"{where}: there is no field type {number}")
    if plain == _NESTED:
        base, bound = kind.nested_type_name, 0
    elif plain in _BOUNDED_TEXTS:
        base, bound = _BOUNDED_TEXTS[plain], kind.string_capacity
    elif plain in _WORDS:
        base, bound = _WORDS[plain], 0
    else:
        raise BadDefinition(f"{where}: a field of type {number} cannot be decoded here")
    count = kind.capacity if form in (FieldForm.ARRAY, FieldForm.BOUNDED) else 0
    return MessageField(field.name, FieldType(base, form, count, bound))
