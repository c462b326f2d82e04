"""What does not have the shape of a description: all of it in one run. Pure.

msgspec stops at the first mistake. `list_shape_errors` takes each one out of a copy, or puts
something of the right shape in its place, and reads on, so that all are found in one run.
"""

from __future__ import annotations

import copy
import re
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.errors import DescriptionError, UnknownWord
from talaia.model.site import Site
from talaia.model.yaml_text.meant_words import meant_word
from talaia.model.yaml_text.shape_sentences import ANY_KEY, SURELY_MEANT, path_of, shape_error
from talaia.model.yaml_text.source_tags import with_tags
from talaia.model.yaml_text.value_remedies import words_of_item

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.model.yaml_text.shape_sentences import ShapeError, Step

__all__ = ["ShapeErrors", "list_shape_errors"]

# More than anybody mends before the next run.
MOST_ERRORS = 100
# What people write at a signal instead of in its source.
_OF_SOURCES = {"topic", "field", "parameter", "expression", "property", "run", "pattern", "url"}
_GLUED = re.compile(r"(?P<key>[A-Za-z_]\w*):(?P<value>\S+)\Z")
# Only what stands among the words that people bring along.
_NO_LIKENESS = 1.0
# Which keys may stand beside these goes by their value.
_DECIDING = ("kind", "type")


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
        if isinstance(found.error, UnknownWord) and _is_of_source(found.steps):
            found.error.remedy = f"it belongs into source: {{{found.steps[-1]}: …}}"
        if found.steps[-2:-1] == ("source",) and isinstance(found.error, UnknownWord):
            _offer_expression(found.error)
        if not found.steps or ANY_KEY in found.steps:
            break
        # Nothing is lost of what stands in it, and the next run tells what is wrong there.
        if _rename(document, found, renamed):
            continue
        # Beside a kind that nobody knows, any key may be right.
        # A device's kind decides its roles alone, and one that was meant is read in its place.
        meant = isinstance(found.error, UnknownWord) and found.error.meant
        of_device = len(found.steps) == 3 and found.steps[0] == "devices"
        if found.steps[-1] in _DECIDING and not (meant and of_device):
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
    yield from _split_keys(value, where)
    yield from _split_numbers(value, where)
    for key in [key for key in value if not isinstance(key, str)]:
        written = words_of_item(key)
        said = "true or false" if isinstance(key, bool) else "a number"
        problem = f"the name of this, {written}, is read as {said}"
        yield DescriptionError(
            f"{where}.{written}", problem, "put the name in quotes, or begin it with a letter"
        )
        # As a text, so that what stands below it is looked at as well.
        value[written] = value.pop(key)
    for key, part in value.items():
        yield from _name_keys(part, f"{where}.{key}")


def _split_keys(value: dict[object, object], where: str) -> Iterator[DescriptionError]:
    """Part what a missing space has made one key of: ``{topic:/mode, …}``."""
    for key in [key for key, part in value.items() if part is None and isinstance(key, str)]:
        glued = _GLUED.match(key)
        if glued is None or glued["key"] in value:
            continue
        del value[key]
        value[glued["key"]] = glued["value"]
        yield DescriptionError(
            f"{where}.{key}",
            f"there is no space behind the colon of {glued['key']!r}",
            f"write: {glued['key']}: {glued['value']}",
        )


def _split_numbers(value: dict[object, object], where: str) -> Iterator[DescriptionError]:
    """Put numbers together that a comma for a point has made two of: ``{latitude: 41,5}``."""
    for before, key in pairwise(list(value)):
        # It may have been taken out as the other half of the number before.
        whole = value.get(before)
        digits = str(key)
        if value[key] is not None or type(whole) is not int or not digits.isdecimal():
            continue
        del value[key]
        value[before] = float(f"{whole}.{digits}")
        yield DescriptionError(
            f"{where}.{before}",
            f"a comma ends the number here: {whole} is read, and {digits} as another key",
            f"write a point: {before}: {whole}.{digits}",
        )


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
    # Empty where no word is near enough.
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
    # Where a needed key is missing a weaker likeness is enough: that one was meant.
    if not found.is_needed and not meant_word(error.word, [meant], SURELY_MEANT):
        return False
    holder[meant] = holder.pop(last)
    renamed[path_of((*way, meant))] = error.where
    return True


def _offer_expression(error: UnknownWord) -> None:
    """Mean the key of another source than the connection's, so not among those that are offered."""
    if meant_word(error.word, ["expression"], _NO_LIKENESS):
        error.meant = "expression"
        error.remedy = "did you mean 'expression'?"


def _is_of_source(steps: Sequence[Step]) -> bool:
    """Tell whether a key that a signal does not have is one of its source."""
    return len(steps) == 5 and steps[2] == "signals" and steps[-1] in _OF_SOURCES


def _is_device(value: object) -> bool:
    # Any of these makes a device of what has a name.
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
        return holder.pop(last, ANY_KEY) is not ANY_KEY
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
