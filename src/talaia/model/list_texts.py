"""Lists of values as one text: what a person types, and what a page shows. Pure."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING

import msgspec

from talaia.model.closed_lists import ArgumentType

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["LIST_TYPES", "Item", "list_text", "parse_list"]

Item = float | int | bool | str

LIST_TYPES = frozenset(
    {
        ArgumentType.NUMBERS,
        ArgumentType.INTEGERS,
        ArgumentType.BOOLEANS,
        ArgumentType.TEXTS,
        ArgumentType.BYTES,
    }
)
_WORDS = {"true": True, "on": True, "false": False, "off": False}
_EXPECTED = {
    ArgumentType.NUMBERS: "a number",
    ArgumentType.INTEGERS: "a whole number",
    ArgumentType.BOOLEANS: "true or false",
    ArgumentType.TEXTS: "a text",
    ArgumentType.BYTES: "a whole number from 0 to 255",
}
# What a 64-bit integer holds, as those of ROS 2 are.
_MOST = 2**63


def list_text(values: Iterable[Item | bytes]) -> str:
    """Write a list as JSON has it; a byte as a number. NaN and infinity stay words."""
    # rclpy has each byte of a list as bytes of length one.
    plain = [value[0] if isinstance(value, bytes) else value for value in values]
    return json.dumps(plain, ensure_ascii=False)


def parse_list(kind: ArgumentType, text: str) -> list[Item] | str:
    """Read a list: ``[1, 2.5]``, or ``1, 2.5``; empty is a list of none.

    Texts with commas or spaces at their ends have to be written as JSON: ``["a, b", "c"]``.

    Returns:
        The values, each of the type of ``kind``, or the sentence that says what is wrong.

    """
    stripped = text.strip()
    if stripped.startswith("["):
        try:
            found = msgspec.json.decode(stripped, type=list[object])
        except (msgspec.DecodeError, RecursionError) as error:
            return f"it begins with [ but is no JSON list: {error}"
    elif kind is ArgumentType.TEXTS:
        found = [word.strip() for word in stripped.split(",")] if stripped else []
    else:
        found = [_word_value(word.strip()) for word in stripped.split(",")] if stripped else []
    values: list[Item] = []
    for position, item in enumerate(found, 1):
        value = _item_of(kind, item)
        if value is None:
            return f"item {position}: expected {_EXPECTED[kind]}, found {item!r}"
        values.append(value)
    return values


def _word_value(word: str) -> object:
    """Read what stands between two commas; a word that is no number or truth stays one."""
    if word.lower() in _WORDS:
        return _WORDS[word.lower()]
    try:
        return msgspec.json.decode(word)
    except (msgspec.DecodeError, RecursionError):
        pass
    try:
        # What people write and JSON has not: +1, .5
        return word if "_" in word else float(word)
    except ValueError:
        return word


def _item_of(kind: ArgumentType, item: object) -> Item | None:
    """Give an item in the type of its list; None: it does not fit."""
    if kind is ArgumentType.BOOLEANS:
        return item if isinstance(item, bool) else None
    if kind is ArgumentType.TEXTS:
        return item if isinstance(item, str) else None
    # For Python True is an int.
    if isinstance(item, bool) or not isinstance(item, int | float):
        return None
    if kind is ArgumentType.NUMBERS:
        return _finite(item)
    # Infinity and NaN, too: neither is its own whole part.
    if isinstance(item, float) and not item.is_integer():
        return None
    low, high = (0, 256) if kind is ArgumentType.BYTES else (-_MOST, _MOST)
    return int(item) if low <= item < high else None


def _finite(number: float) -> float | None:
    try:
        value = float(number)
    # An int of hundreds of digits fits no float.
    except OverflowError:
        return None
    return value if math.isfinite(value) else None
