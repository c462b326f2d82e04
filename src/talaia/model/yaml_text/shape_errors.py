"""What does not have the shape of a description: msgspec's sentences in plain words. Pure.

msgspec stops at the first mistake. `list_shape_errors` takes each one out of a copy, or puts
something of the right shape in its place, and reads on, so that all are found in one run.
"""

from __future__ import annotations

import copy
import re
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import msgspec

from talaia.model.base import FOREIGN_KEYS
from talaia.model.connection import Connection, ConnectionKind
from talaia.model.errors import DescriptionError, UnknownWord
from talaia.model.meant_words import list_words, meant_word
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.site import Site
from talaia.model.yaml_text.source_tags import with_tags
from talaia.model.yaml_text.value_remedies import (
    example_of_key,
    remedy_of_value,
    words_of_item,
    words_of_value,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

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
# Which keys may stand beside these goes by their value.
_DECIDING = ("kind", "type")
# Nearer than this, a key that nobody knows is read as the one that was meant.
_SURELY_MEANT = 0.7


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
        renamed: paths of that, and how they stand in the text, where another key was meant.
        follows: paths of what cannot be judged, for what stands there was put there.

    """

    errors: list[DescriptionError]
    site: Site | None
    renamed: dict[str, str]
    follows: list[str]


def list_shape_errors(document: dict[str, object], most: int = MOST_ERRORS) -> ShapeErrors:
    """Find every mistake of shape in a description's plain values, which are left as they are."""
    document = copy.deepcopy(document)
    errors: list[DescriptionError] = [*_name_keys(document, "$")]
    if "ros2" in document and document["ros2"] is None:
        # Nothing is as good as no key: nobody would be told why there is no connection.
        errors.append(DescriptionError("$.ros2", "nothing stands behind ros2", "write: ros2: {}"))
        document["ros2"] = {}
    renamed: dict[str, str] = {}
    follows: list[str] = []
    while len(errors) < most:
        tagged = with_tags(document)
        try:
            return ShapeErrors(errors, msgspec.convert(tagged, Site), renamed, follows)
        except (msgspec.ValidationError, RecursionError) as error:
            found = shape_error(str(error), tagged)
        errors.append(found.error)
        if not found.steps or _ANY in found.steps:
            break
        if _rename(document, found, renamed):
            continue
        if found.steps[-1] in _DECIDING:
            follows.append(f"{path_of(found.steps[:-1])}.")
        if not _mend(document, found):
            break
    return ShapeErrors(errors, None, renamed, follows)


def _name_keys(value: object, where: str) -> Iterator[DescriptionError]:
    """Make texts of all keys, in place, and tell of those that were none."""
    if isinstance(value, list):
        for index, item in enumerate(value):
            yield from _name_keys(item, f"{where}[{index}]")
        return
    if not isinstance(value, dict):
        return
    for key in [key for key in value if not isinstance(key, str)]:
        written = words_of_item(key)
        said = "true or false" if isinstance(key, bool) else "a number"
        problem = f"the name of this, {written}, is read as {said}"
        yield DescriptionError(
            f"{where}.{written}", problem, "put the name in quotes, or begin it with a letter"
        )
        value[written] = value.pop(key)
    for key, part in value.items():
        yield from _name_keys(part, f"{where}.{key}")


def _rename(document: dict[str, object], found: ShapeError, renamed: dict[str, str]) -> bool:
    """Read a key that nobody knows as the one that was meant, so that what is in it is checked.

    Else all that refers to it would be told as mistakes, too.
    """
    error, (*way, last) = found.error, found.steps
    if not isinstance(error, UnknownWord) or last != error.word:
        return False
    holder = _holder_of(document, way)
    if not isinstance(holder, dict) or last not in holder:
        return False
    meant = error.meant
    if not way and _is_device(holder[last]) and isinstance(holder.get("devices"), dict):
        # At the margin, as if it were a part of the site.
        error.problem = f"the device {last!r} stands beside devices, not in it"
        error.remedy = "put spaces before it and all of its lines, as before the other devices"
        holder["devices"].setdefault(last, holder.pop(last))
        renamed[f"$.devices.{last}"] = error.where
        return True
    if not meant or meant in holder:
        return False
    if not found.is_needed and not meant_word(error.word, [meant], _SURELY_MEANT):
        return False
    holder[meant] = holder.pop(last)
    renamed[path_of((*way, meant))] = error.where
    return True


def _is_device(value: object) -> bool:
    parts = {"signals", "streams", "commands", "drive"}
    return isinstance(value, dict) and "name" in value and not parts.isdisjoint(value)


def _holder_of(document: object, way: Sequence[Step]) -> object:
    """Walk to what a part stands in; None if there is none."""
    holder = document
    for step in way:
        try:
            holder = holder[step]  # type: ignore[index]  # KeyError and the like tell what it is
        except (KeyError, IndexError, TypeError):
            return None
    return holder


def _mend(document: dict[str, object], found: ShapeError) -> bool:
    """Take a wrong value out, or put one of the right shape there; false if neither is possible."""
    # The tree is walked anew each time: what was mended before may have replaced a part of it.
    *way, last = found.steps
    holder = _holder_of(document, way)
    stand_in = _stand_in(found.shape)
    if isinstance(found.error, UnknownWord) and last != found.error.word:
        # A word of a list: what was meant fits best what stands around it.
        stand_in = found.error.meant or stand_in
    if isinstance(holder, dict):
        # Without a needed key the next run would tell of its absence, which is nobody's mistake.
        if found.is_needed and stand_in is not None:
            holder[last] = stand_in
            return True
        if isinstance(found.error, UnknownWord) and last != found.error.word and stand_in:
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
        meant = getattr(error, "meant", "")
        is_needed = _field_type(inner, meant)[1]
        return ShapeError(error, (*steps, key), None, is_needed=is_needed)
    if missing := _MISSING.search(problem):
        key = missing[1]
        shape, is_needed = _field_type(inner, key)
        example = example_of_key(shape)
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
            error.problem = f"{word!r} is a role of a {other}, and this is a {here}"
            error.meant = ""
    beside = [one for one in known if one.partition(".")[0] == word.partition(".")[0]]
    # Of letters alone ``vehicle.height`` is near to ``telescope.right``.
    if beside and not meant_word(word, [error.meant], _SURELY_MEANT + 0.15):
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
    if where == "$.zone":
        return "write the name of its region, as Europe/Madrid"
    return remedy_of_value(_told_kinds(kinds), value, shape, is_needed=is_needed)


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
    if kind is None:
        return next((str(key) for key, part in value.items() if not _fits(part, shape)), _ANY)
    return _ANY


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
