"""The definition of a type whose Python package is installed, from the class itself."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TYPE_IDS,
    BadDefinition,
    FieldForm,
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
    collect_parts,
)

__all__ = ["constants_of", "installed_definition", "type_of_word"]

_SEQUENCE = re.compile(r"sequence<(?P<of>.+?)(?:, (?P<most>\d+))?>\Z")
_ARRAY = re.compile(r"(?P<of>.+)\[(?P<size>\d+)\]\Z")
_TEXT = re.compile(r"(?P<of>w?string)<(?P<most>\d+)>\Z")
# rosidl's own words for what ``.msg`` files call otherwise.
_WORDS = {"boolean": "bool", "double": "float64", "float": "float32", "octet": "byte"}
_FILLER = "structure_needs_at_least_one_member"


def installed_definition(type_name: str) -> TypeDefinition | None:
    """Read ``package/msg/Name`` off its class, with all it is made of; none if it has no class.

    Raises:
        BadDefinition: a field's type is none that can be decoded here.

    """
    if _class_named(type_name) is None:
        return None

    def read_part(name: str) -> dict[str, PartDefinition]:
        kind = _class_named(name)
        # Parts of other packages are installed with it; a broken installation says so.
        if kind is None:
            raise BadDefinition(f"{type_name} is made of {name}, which is not installed")
        fields = tuple(
            MessageField(field, type_of_word(declared))
            for field, declared in kind.get_fields_and_field_types().items()
            if field != _FILLER
        )
        return {name: PartDefinition(fields, constants_of(kind))}

    parts = collect_parts(type_name, read_part)
    package = type_name.split("/", 1)[0]
    return TypeDefinition(type_name, parts, f"the installed package {package}").checked()


def constants_of(kind: Any) -> dict[str, int]:  # noqa: ANN401 - generated classes are untyped
    """Read a class's whole numbers; they stand on its metaclass."""
    if isinstance(told := getattr(kind, "constants", None), dict):
        # It stands for a class of another Python's.
        return dict(told)
    found = {}
    for name in dir(type(kind)):
        value = getattr(kind, name, None)
        if name.isupper() and isinstance(value, bytes) and len(value) == 1:
            # How rosidl has a ``byte``.
            found[name] = value[0]
        elif name.isupper() and isinstance(value, int) and not isinstance(value, bool):
            found[name] = value
    return found


def _class_named(name: str) -> Any:  # noqa: ANN401
    package, middle, short = name.split("/")
    try:
        return getattr(import_module(f"{package}.{middle}"), short)
    except (ImportError, AttributeError):
        return None


def type_of_word(declared: str) -> FieldType:
    """Read a field's type as rosidl's classes name it: ``sequence<double, 4>``.

    Raises:
        BadDefinition: it is none that can be decoded here.

    """
    sequence = _SEQUENCE.match(declared)
    if sequence is not None:
        form = FieldForm.BOUNDED if sequence["most"] else FieldForm.SEQUENCE
        return type_of_word(sequence["of"])._replace(form=form, size=int(sequence["most"] or 0))
    array = _ARRAY.match(declared)
    if array is not None:
        return type_of_word(array["of"])._replace(form=FieldForm.ARRAY, size=int(array["size"]))
    text = _TEXT.match(declared)
    if text is not None:
        return FieldType(text["of"], text_bound=int(text["most"]))
    word = _WORDS.get(declared, declared)
    if word in TYPE_IDS:
        return FieldType(word)
    if word.count("/") != 1:
        raise BadDefinition(f"a field of type {declared!r} cannot be decoded here")
    package, short = word.split("/")
    return FieldType(f"{package}/msg/{short}")
