"""What to write where a value is not of the type that is expected. Pure."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

import msgspec

from talaia.model.yaml_text.foreign_letters import with_own_letters
from talaia.model.yaml_text.key_units import number_remedy
from talaia.model.yaml_text.meant_words import quoted_text

if TYPE_CHECKING:
    from collections.abc import Collection

__all__ = ["example_of_key", "remedy_of_value", "words_of_value"]

# msgspec's words for the types of JSON, and ours.
_WORDS = {
    "array": "a list",
    "bool": "true or false",
    "float": "a number",
    "int": "a whole number",
    "null": "nothing",
    "object": "a mapping",
    "str": "a text",
}
# Of a text that stands in the wrong place: enough to find it again.
_LONGEST_SHOWN = 60
# What people write for numbers, each with its own remedy.
_NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_PLAIN_NUMBER = re.compile(rf"{_NUMBER}(?:[eE][-+]?[0-9]+)?\Z")
# For some languages to the base of 8.
_WITH_ZERO = re.compile(r"[-+]?0[0-9]+(?:\.[0-9]*)?\Z")
_WITH_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+\Z")
_POINTS = re.compile(r"[-+]?[0-9]+(?:\.[0-9]+){2,}\Z")
_NO_NUMBERS = {"nan", "none", "null", "n/a", "na", "inf", "infinity", "undefined", "unknown"}
_WITH_COLON = re.compile(r"[-+]?[0-9]+(?::[0-9.]+)+\Z")
_OTHER_BASE = re.compile(r"0(?:o[0-7]+|b[01]+)\Z", re.IGNORECASE)
_UNSEEN = re.compile("[\u00a0\u2000-\u200f\u202f\u2060\u3000\ufeff]")
_QUOTE_MARKS = "\u201c\u201d\u2018\u2019\u00ab\u00bb\u201e"
# Anything behind a number that is no part of one.
_WITH_UNIT = re.compile(rf"(?P<number>{_NUMBER})\s*(?P<unit>[^\d\s,:.].*)\Z")
# Those that a key of any unit may have: of the others the number would have to be converted.
_OWN_UNITS = {"px", "%", "V", "A", "N", "E", "°C"}
# As a word processor writes what stands before a number below zero.
_MINUS_SIGNS = "\u2212\u2013\u2014"
# YAML's bare words for true and false, which are texts in quotes.
_TRUTHS = {"yes", "no", "true", "false", "on", "off"}
_AS_CONDITION = "{signal: device/name, above: 1}"
# Of these YAML makes no text.
_BARE = re.compile(r"[A-Za-z_/][\w/.-]*\Z")


def words_of_value(value: object, found: str) -> str:
    """Say what stands there, in no language's words for it; ``found`` is msgspec's word."""
    # Before numbers, for Python takes truth values for some.
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return f"the number {value}"
    if isinstance(value, str):
        cut = value if len(value) <= _LONGEST_SHOWN else f"{value[:_LONGEST_SHOWN]}…"
        return f"the text {quoted_text(cut)}"
    return _WORDS.get(found, found)


def remedy_of_value(
    kinds: Collection[str], value: object, shape: object, *, key: str = "", is_needed: bool = False
) -> str:
    """Say what to write instead.

    Args:
        kinds: what is expected, in msgspec's words: ``float``, ``array``.
        value: what stands there; None for nothing.
        shape: what is expected, as of `msgspec.inspect`.
        key: behind which it stands, or empty.
        is_needed: the key may not be left out.

    """
    # Somebody wrote the key and went on.
    if value is None:
        instead = "" if is_needed else ", or leave the key out"
        if "object" in kinds:
            return f"write its parts below it, further to the right{instead}"
        return f"write it behind the colon{instead}"
    # A value of any plain type is expected: nothing more is known of it.
    if len(kinds) > 1:
        return "write one of them, without brackets" if isinstance(value, list) else "write one"
    if "object" in kinds:
        return _as_mapping(value, shape)
    if "array" in kinds:
        return _as_list(value, shape)
    if "str" in kinds:
        return _as_text(value)
    if "bool" in kinds and "float" not in kinds:
        if isinstance(value, str) and value.lower() in _TRUTHS:
            return "leave out the quotes"
        return "write true or false"
    if "float" in kinds or "int" in kinds:
        return _as_number(value, key, whole="float" not in kinds)
    return ""


def _as_number(value: object, key: str, *, whole: bool) -> str:
    # Rounding is theirs to choose.
    if isinstance(value, float) and whole:
        return "leave out the fraction"
    if not isinstance(value, str):
        return "write one number"
    text = value.strip()
    if (unseen := _UNSEEN.search(value)) is not None:
        return f"delete the character that is not seen (U+{ord(unseen[0]):04X})"
    bare = with_own_letters(text.strip(_QUOTE_MARKS).replace("_", ""))
    # In the quotes of a word processor, with the digits in groups, or those of another alphabet.
    if bare != text and _PLAIN_NUMBER.match(bare):
        return f"write: {bare}"
    if text[:1] in _MINUS_SIGNS and _PLAIN_NUMBER.match(text[1:]):
        return f"write the minus of the keyboard: -{text[1:]}"
    if _OTHER_BASE.match(text):
        return f"write it in the digits of ten: {int(text.lower(), 0)}"
    if _WITH_ZERO.match(text):
        digits = text.lstrip("+-")
        sign = text[: len(text) - len(digits)]
        bare = f"{sign}{digits.lstrip('0') or '0'}"
        if whole or "." in text:
            return f"leave out the zero before it: {bare}"
        # Half of a speed or ten times that: only who wrote it knows.
        return f"write {bare}, or {sign}{digits[0]}.{digits[1:]} if a point is missing"
    # A right number, and only its quotes are too much.
    if _PLAIN_NUMBER.match(text):
        if math.isinf(float(text)):
            return "no number is as large here"
        return f"leave out the quotes: {text}"
    if _POINTS.match(text):
        return "write one number with one point"
    if text.lower().lstrip("+-.") in _NO_NUMBERS:
        return "write a number that there is; leave the key out if nobody knows it"
    # As half of the world writes numbers.
    if _WITH_COMMA.match(text):
        return f"write a point: {text.replace(',', '.')}"
    # A time, or degrees and minutes; which one nobody can tell here.
    if _WITH_COLON.match(text):
        return "write one number without a colon, such as 1.5 or 90"
    if (unit := _WITH_UNIT.match(text)) and unit["unit"][0] not in "/-":
        if unit["unit"] in _OWN_UNITS or not any(map(_is_of_unit, unit["unit"])):
            return f"write the number alone: {unit['number']}"
        return number_remedy(key, unit["number"], unit["unit"])
    return "write it in digits"


def _is_of_unit(letter: str) -> bool:
    return letter.isalpha() or letter == "°"


def _as_text(value: object) -> str:
    if isinstance(value, bool):
        return "put it in quotes: without them yes, no, on and off are true or false"
    if isinstance(value, int | float):
        return f'put it in quotes: "{value}"'
    if isinstance(value, list) and len(value) == 1 and isinstance(value[0], str):
        return f"leave out the brackets: {value[0]}"
    return "write one text"


def _as_list(value: object, shape: object) -> str:
    # Each item has keys of its own: the same text in brackets would be as wrong.
    item = getattr(shape, "item_type", None)
    if isinstance(item, msgspec.inspect.StructType) and not isinstance(value, dict):
        keys = [field.encode_name for field in item.fields]
        needed = [field.encode_name for field in item.fields if field.required] or keys[:2]
        if "until_below" in keys:
            return f"write: [{_AS_CONDITION}], or below, is, is_not"
        return f"write it in brackets: [{{{', '.join(f'{key}: …' for key in needed)}}}]"
    if isinstance(value, str):
        # One item, or several as people list them in a sentence.
        items = [item.strip() for item in value.split(",")]
        bare = all(_BARE.match(item) and item.lower() not in _TRUTHS for item in items)
        written = ", ".join(item if bare else f'"{item}"' for item in items)
        return f"write it in brackets: [{written}]" if '"' not in value else "write it in brackets"
    if isinstance(value, dict):
        if value and all(isinstance(one, str) and _BARE.match(one) for one in value.values()):
            return f"write it in brackets: [{', '.join(value.values())}]"
        return "begin each item with a dash and a space: - …"
    return f"write it in brackets: [{words_of_item(value)}]"


def words_of_item(value: object) -> str:
    """Write a plain value as YAML has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value)


def _as_mapping(value: object, shape: object) -> str:
    struct = shape
    if isinstance(shape, msgspec.inspect.UnionType):
        structs = [one for one in shape.types if isinstance(one, msgspec.inspect.StructType)]
        # Of several nothing can be said of their keys.
        if len(structs) > 1:
            return "write its keys below it; which ones goes by the kind of the connection"
        struct = structs[0] if structs else None
    if isinstance(struct, msgspec.inspect.StructType):
        # The needed ones are the least that makes it right.
        needed = [field.encode_name for field in struct.fields if field.required]
        # A condition: most often somebody wrote it as a sum, ``base/speed > 1``.
        if "until_below" in (names := [field.encode_name for field in struct.fields]):
            return f"write: {_AS_CONDITION}, or below, is, is_not"
        if needed:
            keys = ", ".join(f"{key}: …" for key in needed)
            return f"write its keys: {{{keys}}}"
        # ``ros2: true``: all of its keys may be left out, yet a mapping it is.
        if isinstance(value, bool):
            return "write {} where there is nothing more to say"
        keys = ", ".join(names[:6])
        return f"write its keys, such as {keys}"
    # Parts with names of their own: devices, signals, interlocks.
    if isinstance(value, list):
        return "write no list: begin each part with its name and a colon"
    return "write each part below it, with its name, a colon and its own keys"


def example_of_key(shape: object) -> str:
    """Say what is written behind a key."""
    if isinstance(shape, msgspec.inspect.EnumType):
        return f"one of {', '.join(str(member.value) for member in shape.cls)}"
    # No examples of numbers: how fast a robot may go nobody but its owner can say.
    for kind, word in (
        (msgspec.inspect.StrType, "a text"),
        (msgspec.inspect.BoolType, "true or false"),
        (msgspec.inspect.IntType, "a whole number"),
        (msgspec.inspect.FloatType, "a number"),
        (msgspec.inspect.VarTupleType, "a list"),
        (msgspec.inspect.ListType, "a list"),
    ):
        if isinstance(shape, kind):
            return word
    if isinstance(shape, msgspec.inspect.StructType):
        needed = [field.encode_name for field in shape.fields if field.required]
        if needed:
            return f"{{{', '.join(f'{key}: …' for key in needed)}}}"
    return "its keys below it"
