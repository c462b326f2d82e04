"""An extension's keys as people are shown them: name, what it may be, and what it means."""

from __future__ import annotations

import re
from inspect import cleandoc
from typing import TYPE_CHECKING, NamedTuple

import msgspec

if TYPE_CHECKING:
    from talaia.extensions.declarations import ExtensionKeys

__all__ = ["ShownKey", "keys_shown"]

# A line below ``Attributes:``, with the lines that are indented further behind it.
_ATTRIBUTE = re.compile(r"^ {4}(\w+): (.*(?:\n {8,}.*)*)", re.MULTILINE)
_WORDS = {
    msgspec.inspect.BoolType: "true or false",
    msgspec.inspect.IntType: "whole number",
    msgspec.inspect.FloatType: "number",
    msgspec.inspect.StrType: "text",
}


class ShownKey(NamedTuple):
    """One key.

    Attributes:
        name: as it is written.
        type: what it may be, in words.
        about: what it means; empty where the extension does not say.
        required: it must be given.
        default: what stands where it is not given, as text.

    """

    name: str
    type: str
    about: str
    required: bool
    default: str


def keys_shown(shape: type[ExtensionKeys]) -> list[ShownKey]:
    """List the keys of an extension in the order in which it declares them."""
    _, _, attributes = cleandoc(shape.__doc__ or "").partition("Attributes:")
    about = {
        name: " ".join(said.replace("`", "").split())
        for name, said in _ATTRIBUTE.findall(attributes)
    }
    info = msgspec.inspect.type_info(shape)
    fields = info.fields if isinstance(info, msgspec.inspect.StructType) else ()
    return [
        ShownKey(
            field.encode_name,
            _type_text(field.type),
            about.get(field.name, ""),
            field.required,
            "" if field.default is msgspec.NODEFAULT else _plain_text(field.default),
        )
        for field in fields
    ]


def _type_text(kind: msgspec.inspect.Type) -> str:
    if isinstance(kind, msgspec.inspect.LiteralType):
        return "one of " + ", ".join(_plain_text(value) for value in kind.values)
    word = _WORDS.get(type(kind), "text")
    if isinstance(kind, msgspec.inspect.IntType | msgspec.inspect.FloatType):
        low = kind.ge if kind.ge is not None else kind.gt
        high = kind.le if kind.le is not None else kind.lt
        # A bound on one side alone is left to the extension's own words.
        if low is not None and high is not None:
            return f"{word}, {low:g} to {high:g}"
    return word


def _plain_text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
