"""Definitions as text (``ros2msg``), as recordings carry them. Pure.

The type's own text, then each that it is made of, after a line of ``=`` and one of
``MSG: package/Name``: the form that rosbag 2 writes and that Foxglove and Lichtblick read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.ros2.type_definitions.message_definition import TYPE_IDS, FieldForm

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
        FieldType,
        PartDefinition,
        TypeDefinition,
    )

__all__ = ["definition_text", "rosidl_word"]

_RULE = "=" * 80
# rosidl's words for the classes' own lists of fields.
_ROSIDL = {"bool": "boolean", "float64": "double", "float32": "float", "byte": "octet"}


def definition_text(definition: TypeDefinition) -> str:
    """Write a definition with all that it is made of; by its author's texts where there are any."""
    lines = [_text_of(definition.parts[definition.name])]
    for name, part in definition.parts.items():
        if name != definition.name:
            lines += [_RULE, f"MSG: {_short(name)}", _text_of(part)]
    return "\n".join(lines) + "\n"


def rosidl_word(kind: FieldType) -> str:
    """Give a field's type as rosidl's Python classes name it: ``sequence<double, 4>``."""
    word = _ROSIDL.get(kind.base, kind.base if kind.base in TYPE_IDS else _short(kind.base))
    if kind.text_bound:
        word = f"{word}<{kind.text_bound}>"
    match kind.form:
        case FieldForm.ARRAY:
            return f"{word}[{kind.size}]"
        case FieldForm.BOUNDED:
            return f"sequence<{word}, {kind.size}>"
        case FieldForm.SEQUENCE:
            return f"sequence<{word}>"
        case _:
            return word


def _text_of(part: PartDefinition) -> str:
    if part.text:
        return part.text.strip("\n")
    return "\n".join(f"{_word(field.type)} {field.name}" for field in part.fields)


def _word(kind: FieldType) -> str:
    word = kind.base if kind.base in TYPE_IDS else _short(kind.base)
    if kind.text_bound:
        word = f"{word}<={kind.text_bound}"
    match kind.form:
        case FieldForm.ARRAY:
            return f"{word}[{kind.size}]"
        case FieldForm.BOUNDED:
            return f"{word}[<={kind.size}]"
        case FieldForm.SEQUENCE:
            return f"{word}[]"
        case _:
            return word


def _short(name: str) -> str:
    package, _, short = name.split("/")
    return f"{package}/{short}"
