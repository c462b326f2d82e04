"""What does not have the shape of a description: msgspec's sentences in plain words. Pure.

msgspec stops at the first mistake. `list_shape_errors` takes each one out of a copy, or puts
something of the right shape in its place, and reads on, so that all are found in one run.
"""

from __future__ import annotations

import copy
import re
from typing import NamedTuple, TypeAlias

import msgspec

from talaia.model.base import FOREIGN_KEYS
from talaia.model.connection import Connection, ConnectionKind
from talaia.model.errors import DescriptionError, UnknownWord
from talaia.model.site import Site
from talaia.model.yaml_text.source_tags import with_tags

__all__ = ["ShapeError", "ShapeErrors", "list_shape_errors", "shape_error"]

# More than anybody mends before the next run.
MOST_ERRORS = 100

Step: TypeAlias = "str | int"

# msgspec's sentence: what is wrong, and behind ``- at`` the path.
_AT = re.compile(r"^(?P<problem>.*?)(?: - at `(?P<path>.*)`)?$", re.DOTALL)
_UNKNOWN_FIELD = re.compile(r"unknown field `(.*)`")
_UNKNOWN_ENUM = re.compile(r"Invalid enum value '(.*)'")
_UNKNOWN_TAG = re.compile(r"Invalid value '(.*)'\Z")
_MISSING = re.compile(r"missing required field `(.*)`")
_WRONG_TYPE = re.compile(r"Expected `(?P<expected>[^`]*)`, got `(?P<found>[^`]*)`")
# A field, an index, or ``[...]``, which is how msgspec writes any key of a mapping.
_STEP = re.compile(r"\.([A-Za-z_]\w*)|\[(\d+|\.\.\.)\]")
# A key of a mapping that could not be told.
_ANY = "…"
_WORDS = {
    "array": "a list",
    "bool": "true or false",
    "float": "a number",
    "int": "a whole number",
    "null": "nothing",
    "object": "a mapping",
    "str": "a text",
}
_LONGEST_SHOWN = 60


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


class ShapeErrors(NamedTuple):
    """All that does not have the right shape.

    Attributes:
        errors: in the order in which they were found.
        site: what is left without them; None if that is not enough for a description.

    """

    errors: list[DescriptionError]
    site: Site | None


def list_shape_errors(document: dict[str, object], most: int = MOST_ERRORS) -> ShapeErrors:
    """Find every mistake of shape in a description's plain values, which are left as they are."""
    document = copy.deepcopy(document)
    errors: list[DescriptionError] = []
    while len(errors) < most:
        tagged = with_tags(document)
        try:
            return ShapeErrors(errors, msgspec.convert(tagged, Site))
        except (msgspec.ValidationError, RecursionError) as error:
            found = shape_error(str(error), tagged)
        errors.append(found.error)
        if not found.steps or _ANY in found.steps or not _mend(document, found):
            break
    return ShapeErrors(errors, None)


def _mend(document: dict[str, object], found: ShapeError) -> bool:
    """Take a wrong value out, or put one of the right shape there; false if neither is possible."""
    # The tree is walked anew each time: what was mended before may have replaced a part of it.
    *way, last = found.steps
    holder: object = document
    for step in way:
        try:
            holder = holder[step]  # type: ignore[index]  # KeyError and the like tell what it is
        except (KeyError, IndexError, TypeError):
            return False
    stand_in = _stand_in(found.shape)
    if isinstance(holder, dict):
        # Without a needed key the next run would tell of its absence, which is nobody's mistake.
        if found.is_needed and stand_in is not None:
            holder[last] = stand_in
            return True
        return holder.pop(last, _ANY) is not _ANY
    if isinstance(holder, list) and isinstance(last, int) and last < len(holder):
        # Not taken out: the numbers of those behind it are people's to find them by.
        if stand_in is None:
            return False
        holder[last] = stand_in
        return True
    return False


def _stand_in(shape: object) -> object:
    """Give the plainest value of a type, or None."""
    if isinstance(shape, msgspec.inspect.UnionType):
        return next((made for kind in shape.types if (made := _stand_in(kind)) is not None), None)
    if isinstance(shape, msgspec.inspect.EnumType):
        return next(iter(shape.cls)).value
    for kind, value in _STAND_INS:
        if isinstance(shape, kind):
            return copy.copy(value)
    if isinstance(shape, msgspec.inspect.StructType):
        needed = [field for field in shape.fields if field.required]
        made = {field.encode_name: _stand_in(field.type) for field in needed}
        return None if None in made.values() else made
    return None


_STAND_INS: tuple[tuple[type, object], ...] = (
    (msgspec.inspect.StrType, "unknown"),
    (msgspec.inspect.BoolType, False),
    (msgspec.inspect.IntType, 1),
    (msgspec.inspect.FloatType, 1.0),
    (msgspec.inspect.DictType, {}),
    (msgspec.inspect.VarTupleType, []),
    (msgspec.inspect.ListType, []),
)


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
        return ShapeError(error, (*steps, key), None, is_needed=False)
    if missing := _MISSING.search(problem):
        key = missing[1]
        error = DescriptionError(where, f"the key {key!r} is missing", f"add {key}: …")
        return ShapeError(error, (*steps, key), *_field_type(inner, key))
    if enum := _UNKNOWN_ENUM.search(problem):
        error = UnknownWord(where, "word", enum[1], _words_of(inner))
    elif (tag := _UNKNOWN_TAG.search(problem)) and where.startswith("$.connections."):
        error = UnknownWord(where, "kind of connection", tag[1], ConnectionKind)
    elif wrong := _WRONG_TYPE.search(problem):
        error = _wrong_type(where, wrong["expected"], wrong["found"], value)
    else:
        error = DescriptionError(where, problem[:1].lower() + problem[1:].replace("`", ""))
    return ShapeError(error, steps, shape, is_needed)


def path_of(steps: tuple[Step, ...]) -> str:
    """Write a path as errors do: ``$.devices.base.states[0]``."""
    return "$" + "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)


def _wrong_type(where: str, expected: str, found: str, value: object) -> DescriptionError:
    """Say what was expected and what stands there, in no language's words for it."""
    kinds = [kind.strip() for kind in expected.split("|")]
    # Whole numbers are numbers; nothing is never what people forgot to write.
    if "float" in kinds and "int" in kinds:
        kinds.remove("int")
    if len(kinds) > 1 and "null" in kinds:
        kinds.remove("null")
    said = " or ".join(_WORDS.get(kind, kind) for kind in kinds)
    shown = _WORDS.get(found, found)
    # Before numbers, for Python takes truth values for some.
    if isinstance(value, bool):
        shown = "true" if value else "false"
    elif isinstance(value, int | float):
        shown = f"the number {value}"
    elif isinstance(value, str):
        cut = value if len(value) <= _LONGEST_SHOWN else f"{value[:_LONGEST_SHOWN]}…"
        shown = f"the text {cut!r}"
    remedy = ""
    if "str" in kinds and isinstance(value, bool | int | float):
        remedy = "put it in quotes"
    return DescriptionError(where, f"expected {said}, found {shown}", remedy)


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
    shape: object = msgspec.inspect.type_info(Site)
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
        return _ANY
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
    return _ANY
