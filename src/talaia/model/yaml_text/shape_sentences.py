"""A mistake of shape in plain words: what msgspec says of it, and where that is. Pure."""

from __future__ import annotations

import functools
import re
from typing import NamedTuple, TypeAlias

import msgspec

from talaia.model.base import FOREIGN_KEYS
from talaia.model.connection import Connection, ConnectionKind
from talaia.model.errors import DescriptionError, UnknownWord
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.site import Site
from talaia.model.yaml_text.meant_words import list_words, meant_word
from talaia.model.yaml_text.value_remedies import example_of_key, remedy_of_value, words_of_value

__all__ = ["ANY_KEY", "SURELY_MEANT", "ShapeError", "Step", "path_of", "shape_error"]

Step: TypeAlias = "str | int"

# msgspec's sentence: what is wrong, and behind ``- at`` the path.
_AT = re.compile(r"^(?P<problem>.*?)(?: - at `(?P<path>.*)`)?$", re.DOTALL)
_UNKNOWN_FIELD = re.compile(r"unknown field `(.*)`")
_UNKNOWN_ENUM = re.compile(r"Invalid enum value '(.*)'")
# Of a connection's kind, which is no enumeration for msgspec.
_UNKNOWN_TAG = re.compile(r"Invalid value '(.*)'\Z")
_MISSING = re.compile(r"missing required field `(.*)`")
_WRONG_TYPE = re.compile(r"Expected `(?P<expected>[^`]*)`, got `(?P<found>[^`]*)`")
# A field, an index, or ``[...]``, which is how msgspec writes any key of a mapping.
_STEP = re.compile(r"\.([A-Za-z_]\w*)|\[(\d+|\.\.\.)\]")
# A key of a mapping that could not be told.
ANY_KEY = "…"
# Nearer than this, a key that nobody knows is read as the one that was meant.
SURELY_MEANT = 0.7
# Of roles, which are alike in many letters: ``dome.opening`` is not ``dome.turning``.
_SURE_ROLE = 0.85


class ShapeError(NamedTuple):
    """A mistake, and where it is.

    Attributes:
        error: what people are told.
        steps: keys and indices from the document to the wrong value, or to a key that is not known
            or missing.
        shape: what is expected there, as of `msgspec.inspect`; None if that is not known.
        is_needed: that key may not be left out.

    """

    error: DescriptionError
    steps: tuple[Step, ...]
    shape: object
    is_needed: bool


def shape_error(message: str, document: object) -> ShapeError:
    """Turn msgspec's sentence into ours, with the names of the mapping's keys in the path."""
    match = _AT.match(message)
    problem, path = (match["problem"], match["path"] or "$") if match else (message, "$")
    steps, shape, value, is_needed = _follow_path(path, document, problem)
    inner = _inner_type(shape, (msgspec.inspect.StructType, msgspec.inspect.EnumType), value)
    where = path_of(steps)
    if unknown := _UNKNOWN_FIELD.search(problem):
        key = unknown[1]
        error: DescriptionError = UnknownWord(f"{where}.{key}", "key", key, _keys_of(inner))
        meant = getattr(error, "meant", "")
        is_needed = _field_type(inner, meant)[1]
        return ShapeError(error, (*steps, key), None, is_needed=is_needed)
    # Told at what it is missing in: there is no other place for it.
    if missing := _MISSING.search(problem):
        key = missing[1]
        shape, is_needed = _field_type(inner, key)
        example = example_of_key(shape)
        # It tells the connections apart, so none of them has it as a field.
        if key == "kind" and shape is None:
            example = f"one of {', '.join(kind.value for kind in ConnectionKind)}"
        error = DescriptionError(where, f"the key {key!r} is missing", f"add {key}: … ({example})")
        return ShapeError(error, (*steps, key), shape, is_needed)
    if enum := _UNKNOWN_ENUM.search(problem):
        error = _unknown_word(where, steps, enum[1], _words_of(inner))
    elif (tag := _UNKNOWN_TAG.search(problem)) and where.startswith("$.connections."):
        error = UnknownWord(where, "kind of connection", tag[1], [*ConnectionKind])
    elif wrong := _WRONG_TYPE.search(problem):
        kinds = [kind.strip() for kind in wrong["expected"].split("|")]
        remedy = _remedy_of(where, kinds, value, shape, is_needed=is_needed)
        error = _wrong_type(where, kinds, words_of_value(value, wrong["found"]), remedy)
    else:
        error = DescriptionError(where, problem[:1].lower() + problem[1:].replace("`", ""))
    return ShapeError(error, steps, shape, is_needed)


def _unknown_word(
    where: str, steps: tuple[Step, ...], word: str, known: list[str]
) -> DescriptionError:
    # The key says best what the word is: a kind, a role, a severity.
    what = str(steps[-1]) if steps and isinstance(steps[-1], str) else "word"
    error = UnknownWord(where, what, word, known)
    if what != "role":
        return error
    for names, here, other in (
        (SignalRole, "command", "signal"),
        (CommandRole, "signal", "command"),
    ):
        if word in {*names} and word not in known:
            # Commands and signals have roles of one device in common, as far as the point.
            error.problem = f"{word!r} is a role of a {other}, and this is a {here}"
            error.meant = ""
    beside = [one for one in known if one.partition(".")[0] == word.partition(".")[0]]
    # Of letters alone ``vehicle.height`` is near to ``telescope.right``.
    if beside and not meant_word(word, [error.meant], _SURE_ROLE):
        error.remedy = f"use one of: {list_words(beside)}"
        error.meant = ""
    return error


def path_of(steps: tuple[Step, ...]) -> str:
    """Write a path as errors do: ``$.devices.base.states[0]``."""
    return "$" + "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)


def _wrong_type(where: str, kinds: list[str], found: str, remedy: str) -> DescriptionError:
    """Say what was expected, what stands there and what to write, in no language's words."""
    said = " or ".join(words_of_value(None, kind) for kind in _told_kinds(kinds))
    return DescriptionError(where, f"expected {said}, found {found}", remedy)


def _told_kinds(kinds: list[str]) -> list[str]:
    # Whole numbers are numbers; nothing is never what people forgot to write.
    left_out = {"int"} if "float" in kinds else set()
    return [kind for kind in kinds if kind not in left_out | {"null"}] or kinds


def _remedy_of(
    where: str, kinds: list[str], value: object, shape: object, *, is_needed: bool
) -> str:
    # An offset from UTC, most often, which quotes would not mend.
    if where == "$.zone":
        return "write the name of its region, as Europe/Madrid"
    key = where.rpartition(".")[2]
    return remedy_of_value(_told_kinds(kinds), value, shape, key=key, is_needed=is_needed)


def _keys_of(shape: object) -> list[str]:
    if isinstance(shape, msgspec.inspect.StructType):
        names = [field.encode_name for field in shape.fields]
        return [name for name in names if name != FOREIGN_KEYS]
    return []


def _words_of(shape: object) -> list[str]:
    if isinstance(shape, msgspec.inspect.EnumType):
        return [str(member.value) for member in shape.cls]
    return []


def _follow_path(
    path: str, document: object, problem: str
) -> tuple[tuple[Step, ...], object, object, bool]:
    """Walk msgspec's path, naming the mapping key it writes as ``[...]``.

    Gives the path, what is expected at its end and what stands there, and whether that key is
    needed.

    msgspec knows the path of types, not of keys: ``$.devices[...].signals[...].unit``. Of the
    keys at each ``[...]`` the first whose own value does not convert is the one it stopped at.
    """
    shape = _site_shape()
    value, steps, is_needed = document, list[Step](), False
    for name, index in _STEP.findall(path):
        shape = _inner_type(shape, msgspec.inspect.StructType, value)
        step: Step
        is_needed = False
        if name:
            (shape, is_needed), step = _field_type(shape, name), name
            value = value.get(name) if isinstance(value, dict) else None
        elif index == "...":
            shape = _value_type(shape)
            step = _first_wrong(value, shape, problem)
            value = value.get(step) if isinstance(value, dict) else None
        else:
            shape, step = _value_type(shape), int(index)
            value = value[step] if isinstance(value, list) else None
        steps.append(step)
    return tuple(steps), shape, value, is_needed


@functools.cache
def _site_shape() -> object:
    # Once: msgspec goes through all types anew each time, which takes longer than all the rest.
    return msgspec.inspect.type_info(Site)


def _inner_type(shape: object, wanted: type | tuple[type, ...], value: object) -> object:
    """Look through ``X | None``, and ``X | Y`` by the tag that ``value`` has, to one member."""
    if not isinstance(shape, msgspec.inspect.UnionType):
        return shape
    members = [member for member in shape.types if isinstance(member, wanted)]
    said = value if isinstance(value, dict) else {}
    tagged = [
        member
        for member in members
        if isinstance(member, msgspec.inspect.StructType)
        and member.tag is not None
        and member.tag == said.get(member.tag_field)
    ]
    return next(iter(tagged or members), shape)


def _field_type(shape: object, name: str) -> tuple[object, bool]:
    """Give a field's type, and whether it may not be left out."""
    fields = shape.fields if isinstance(shape, msgspec.inspect.StructType) else ()
    return next(((f.type, f.required) for f in fields if f.encode_name == name), (None, False))


def _value_type(shape: object) -> object:
    if isinstance(shape, msgspec.inspect.DictType):
        return shape.value_type
    if isinstance(shape, msgspec.inspect.VarTupleType):
        return shape.item_type
    return None


def _first_wrong(value: object, shape: object, problem: str) -> str:
    if not isinstance(value, dict):
        return ANY_KEY
    # Only connections are one of several shapes.
    union = isinstance(shape, msgspec.inspect.UnionType)
    kind = shape.cls if isinstance(shape, msgspec.inspect.StructType) else None
    if union or kind is not None:
        for key, part in value.items():
            try:
                msgspec.convert(part, Connection if union else kind)
            except msgspec.ValidationError as error:
                if str(error).startswith(problem):
                    return str(key)
    if kind is None:
        return next((str(key) for key, part in value.items() if not _fits(part, shape)), ANY_KEY)
    return ANY_KEY


def _fits(value: object, shape: object) -> bool:
    """Tell whether a plain value is of a plain type, or a mapping of such."""
    if isinstance(shape, msgspec.inspect.UnionType):
        return any(_fits(value, kind) for kind in shape.types)
    if isinstance(shape, msgspec.inspect.DictType):
        return isinstance(value, dict) and all(
            _fits(part, shape.value_type) for part in value.values()
        )
    if isinstance(value, bool):
        return isinstance(shape, msgspec.inspect.BoolType)
    return any(
        isinstance(shape, kind) and isinstance(value, made)
        for kind, made in (
            (msgspec.inspect.StrType, str),
            (msgspec.inspect.IntType, int),
            (msgspec.inspect.FloatType, (int, float)),
            (msgspec.inspect.NoneType, type(None)),
        )
    )
