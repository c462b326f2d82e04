"""YAML text to plain values, event by event.

PyYAML's own loader makes a node of every word with two marks of its place; for a description of
ten thousand signals the garbage collector then goes through half a million objects again and again
(1.2 s of 1.3 s). Here the parser's events become values at once, by the same tags and rules.

A description needs no more of YAML than values, lists, mappings and aliases: what else there is
(merge keys, tags of its own, keys that are no plain words) is refused.

Long, because reading on after a mistake goes through the same events as reading.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias, TypeVar, cast

import yaml

from talaia.model.errors import NotReadable
from talaia.model.yaml_text.yaml_mistakes import TextMistake, explain_yaml_error

if TYPE_CHECKING:
    from datetime import date

__all__ = [
    "ReadText",
    "document_of",
    "dump_document",
    "quoting_powers_of_ten",
    "read_document",
    "read_on",
    "require_shallow",
]

Value: TypeAlias = "bool | int | float | str | bytes | date | list[Value] | dict[Key, Value] | None"
Key: TypeAlias = "str | int | float | bool"

# Of one text; more than anybody mends before the next run. It is read again for each, up to so many
# characters in all: a long text holds nobody up.
_MOST_MENDED, _MOST_READ = 20, 8 * 1024 * 1024
# Deeper than any description; libyaml itself has no bound.
MAX_DEPTH = 64
# What aliases may grow a text to, in values.
MAX_VALUES = 4_000_000
# Whole numbers have 64 bits, with a sign or without: no signal has larger ones, and Python writes
# none of more than 4 300 digits, also not into a sentence about it.
LEAST_INT, GREATEST_INT = -(2**63), 2**64 - 1
# More than any way to write 64 bits (in twos: 64 digits, underscores between them, and a prefix).
MAX_DIGITS = 200
_JOINED = "two mappings, read as one"
_NOTHING = "nothing stands where a name belongs"
_NO_NAME = "a list or a mapping stands where a name belongs"
_NO_TAG = "leave it out; a text that begins with ! stands in quotes"
_IN_QUOTES = "put it in quotes if it is a text"
_TOO_LARGE = "the whole number is larger than 64 bits hold"
_Loader = yaml.CSafeLoader if hasattr(yaml, "CSafeLoader") else yaml.SafeLoader
_TAG = "tag:yaml.org,2002:"
_STR, _INT, _FLOAT, _DATE = _TAG + "str", _TAG + "int", _TAG + "float", _TAG + "timestamp"
# PyYAML reads YAML 1.1: there ``1:30`` is 90 and ``010`` is 8, and ``1e9`` is no number. Nobody
# means that, least of all in a speed limit. As in YAML 1.2 the last one is a number; the others,
# and ``1_000``, ``0b11`` and dates, are texts here, so that a number's place refuses them and a
# text's place has them as written.
_NO_NUMBER = re.compile(
    r"[-+]?(0[0-9_]+|[0-9][0-9_]*(:[0-9_]+)+(\.[0-9_]*)?|0b.*|.*_.*)\Z", re.IGNORECASE
)
_POWER_OF_TEN = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+\Z")
_PLAIN = {_TAG + tag for tag in ("null", "bool", "int", "float", "str")}
_MAPPING, _SEQUENCE = (None, "!", _TAG + "map"), (None, "!", _TAG + "seq")


class _Parser(Protocol):
    """What is used of PyYAML's loader, whose stubs say `Any`."""

    def get_event(self) -> object: ...

    def resolve(self, kind: type, value: str, implicit: tuple[bool, bool]) -> str: ...

    def construct_object(self, node: yaml.ScalarNode) -> Value: ...

    def dispose(self) -> None: ...


class _Anchored(NamedTuple):
    value: Value
    size: int


class ReadText(NamedTuple):
    """What could be read of a text with mistakes.

    Attributes:
        document: its values, where `is_whole`.
        text: the text as it was most likely meant, with as many lines.
        errors: all that is wrong with it as YAML, in the order in which it was found.
        is_whole: it could be read to its end.
        is_joined: parts that were written twice were read as one, so what refers to them may
            mean either.

    """

    document: object
    text: str
    errors: list[NotReadable]
    is_whole: bool
    is_joined: bool = False


def document_of(text: str, twice: list[yaml.MarkedYAMLError] | None = None) -> object:
    """Read the one document of a text.

    Args:
        text: of it.
        twice: takes the errors of keys that are written twice, and they are read on as one; None
            raises the first.

    Raises:
        yaml.YAMLError: it is no YAML, or holds what no description does; a `MarkedYAMLError`
            where the place is known.

    """
    parser = cast("_Parser", _Loader(text))
    try:
        return _Document(parser, twice).read_document()
    finally:
        parser.dispose()


def require_shallow(text: str) -> None:
    """Refuse what is nested deeper than any description, before a reader that calls itself.

    libyaml's own composer does, in C: a hundred thousand brackets end the process.

    Raises:
        NotReadable: it is nested deeper than `MAX_DEPTH`.

    """
    depth = 0
    try:
        for event in yaml.parse(text, Loader=_Loader):
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > MAX_DEPTH + 1:
                raise NotReadable("$", f"nested deeper than {MAX_DEPTH}", "look for brackets")
    # What is no YAML ends whoever reads it at the same place.
    except (yaml.YAMLError, ValueError):
        return


def read_document(text: str) -> object:
    """Read the one document of a text that a person wrote.

    Raises:
        NotReadable: it is no YAML, or holds what no description does; with the line where that is
            known.

    """
    try:
        return document_of(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        told = _mistake_of(error, text)
        raise _not_readable(told) from error


def read_on(text: str) -> ReadText:
    """Read a text that a person wrote, and go on after mistakes that can be mended by themselves.

    What is told beyond the first of them is there for certain: where a mended line, or the one
    below it, is told as wrong again, nothing more is said.
    """
    lines = text.split("\n")
    errors: list[NotReadable] = []
    last = -1
    while True:
        twice: list[yaml.MarkedYAMLError] = []
        read, document = "\n".join(lines), None
        told: TextMistake | None = None
        try:
            document = document_of(read, twice)
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            told = _mistake_of(error, read)
        if told is None:
            errors += [_not_readable(_mistake_of(one, read)) for one in twice]
            return ReadText(
                document, read, errors, is_whole=True, is_joined=any(map(_is_joined, twice))
            )
        if last < 0 or told.line > last + 1:
            errors.append(_not_readable(told))
            most = min(_MOST_MENDED, _MOST_READ // len(text))
            if told.instead is not None and 0 < told.line <= len(lines) and len(errors) < most:
                lines[told.line - 1], last = told.instead, told.line
                continue
        errors += [_not_readable(_mistake_of(one, read)) for one in twice]
        return ReadText(None, read, errors, is_whole=False)


def _is_joined(error: yaml.MarkedYAMLError) -> bool:
    return error.context == _JOINED


def _not_readable(told: TextMistake) -> NotReadable:
    where = f"line {told.line}, column {told.column}" if told.line else "$"
    return NotReadable(where, told.problem, told.remedy)


def _mistake_of(error: Exception, text: str) -> TextMistake:
    """Say what keeps a text from being read; line 0 where its place is not known."""
    if isinstance(error, _Refused):
        # Marks count from 0.
        mark = error.problem_mark
        problem = error.problem or ""
        if "written twice" in problem:
            problem += _first_of(text, mark)
        return TextMistake(mark.line + 1, mark.column + 1, problem, error.note or "")
    if isinstance(error, yaml.MarkedYAMLError):
        return explain_yaml_error(error, text)
    if isinstance(error, yaml.reader.ReaderError):
        # libyaml counts bytes.
        before = text.encode(errors="replace")[: error.position].decode(errors="ignore")
        problem = f"a character that no text has (U+{_code_of(error.character):04X})"
        line, column = before.count(chr(10)) + 1, len(before) - before.rfind(chr(10))
        return TextMistake(line, column, problem, "delete it; it may not be seen")
    return TextMistake(0, 0, f"is not YAML: {error}", "")


def dump_document(plain: object) -> str:
    """Write plain values as a text that `document_of` reads back to equal ones."""
    # Escaped throughout: of what is written as it is, a line end of Unicode's would not come back.
    text: str = yaml.dump(plain, Dumper=_Dumper, sort_keys=False, width=1_000_000)
    return text


def _code_of(letter: str | bytes | int) -> int:
    # libyaml gives a number, PyYAML in Python a letter.
    return letter if isinstance(letter, int) else ord(letter)


def _first_of(text: str, mark: yaml.Mark) -> str:
    """Say in which line a key that is written twice stands first; nothing if it cannot be told."""
    # By the same column, which a key of the same mapping in lines of its own has.
    lines = text.split("\n")
    said = lines[mark.line][mark.column :].partition(":")[0]
    for at in range(mark.line - 1, -1, -1):
        line = lines[at]
        if line[mark.column :].partition(":")[0] == said and not line[: mark.column].strip("- "):
            return f", first in line {at + 1}"
    return ""


class _Document:
    """One reading of one document."""

    def __init__(self, parser: _Parser, twice: list[yaml.MarkedYAMLError] | None) -> None:
        self._parser = parser
        self._twice = twice
        # Called for every event of the text.
        self._next = parser.get_event
        # What ``&name`` stands for, and how many values that is.
        self._anchors: dict[str, _Anchored] = {}
        # What is being read of those.
        self._open: list[object] = []
        # Most words come often: tags are resolved once for each.
        self._known: dict[str, Value] = {}
        # Values so far; what an alias repeats counts each time.
        self._size = 0

    def read_document(self) -> object:
        self._next()  # the stream's start
        if isinstance(event := self._next(), yaml.StreamEndEvent):
            return None
        value = self._read_value(self._next(), 0)
        self._next()  # the document's end
        event = self._next()
        if not isinstance(event, yaml.StreamEndEvent):
            raise _yaml_error(
                "a second description begins here, after ---",
                event,
                "give each description a file of its own",
            )
        return value

    def _read_value(self, event: object, depth: int) -> Value:
        self._size += 1
        if isinstance(event, yaml.ScalarEvent):
            return self._remember_anchor(event.anchor, self._read_scalar(event), 1)
        if depth > MAX_DEPTH:
            raise _yaml_error(
                f"nested deeper than {MAX_DEPTH}", event, "look for brackets that are too many"
            )
        before = self._size
        anchor = getattr(event, "anchor", None)
        is_part = not isinstance(event, yaml.AliasEvent) and anchor is not None
        if is_part:
            self._open.append(anchor)
        value: Value
        if isinstance(event, yaml.MappingStartEvent):
            value = self._read_mapping(event, depth)
        elif isinstance(event, yaml.SequenceStartEvent):
            value = self._read_sequence(event, depth)
        else:
            return self._read_alias(event)
        if is_part:
            self._open.pop()
        return self._remember_anchor(event.anchor, value, self._size - before + 1)

    def _remember_anchor(self, anchor: str | None, value: Value, size: int) -> Value:
        if anchor is not None:
            # Only once it is read: within itself an anchor is unknown, so nothing holds itself.
            self._anchors[anchor] = _Anchored(value, size)
        return value

    def _read_alias(self, event: object) -> Value:
        assert isinstance(event, yaml.AliasEvent)  # noqa: S101 - no other event begins a value
        known = self._anchors.get(event.anchor or "")
        if event.anchor in self._open:
            raise _yaml_error(
                f"this stands within what &{event.anchor} means, which would have no end",
                event,
                "write out what is meant",
            )
        if known is None:
            raise _yaml_error(
                f"there is no &{event.anchor} before this",
                event,
                f"write &{event.anchor} before what is meant, above; a text that begins with * "
                "stands in quotes",
            )
        self._size += known.size
        # A few lines of aliases to aliases can mean more values than any memory holds.
        if self._size > MAX_VALUES:
            raise _yaml_error("the aliases make it too large", event, "write out what is meant")
        return known.value

    def _read_mapping(self, event: yaml.MappingStartEvent, depth: int) -> Value:
        if event.tag not in _MAPPING:
            raise _yaml_error(_no_meaning(event.tag), event, _NO_TAG)
        made: dict[Key, Value] = {}
        while not isinstance(at := self._next(), yaml.MappingEndEvent):
            # In quotes it is a key as any other.
            if isinstance(at, yaml.ScalarEvent) and at.value == "<<" and at.implicit[0]:
                raise _yaml_error("merge keys (<<) are not read", at, "write out what is merged")
            key = self._read_value(at, depth + 1)
            if key is None:
                raise _yaml_error(_NOTHING, at, "write a word before the colon, or put ~ in quotes")
            if not isinstance(key, str | int | float | bool):
                raise _yaml_error(_NO_NAME, at, "write a word, then :; a text with { in quotes")
            if key not in made:
                made[key] = self._read_value(self._next(), depth + 1)
                continue
            twice = _yaml_error(
                f"the key {key!r} is written twice",
                at,
                "leave one of them out, or give it another name",
            )
            if self._twice is None:
                raise twice
            self._twice.append(twice)
            first, second = made[key], self._read_value(self._next(), depth + 1)
            if isinstance(first, dict) and isinstance(second, dict):
                # Whoever began a list of devices anew meant both halves of it.
                made[key] = {**second, **first}
                twice.context = _JOINED
        return made

    def _read_sequence(self, event: yaml.SequenceStartEvent, depth: int) -> Value:
        if event.tag not in _SEQUENCE:
            raise _yaml_error(_no_meaning(event.tag), event, _NO_TAG)
        made: list[Value] = []
        while not isinstance(at := self._next(), yaml.SequenceEndEvent):
            made.append(self._read_value(at, depth + 1))
        return made

    def _read_scalar(self, event: yaml.ScalarEvent) -> Value:
        tag, text = event.tag, event.value
        if tag is None or tag == "!":
            if not event.implicit[0]:
                return text  # in quotes
            if text in self._known:
                return self._known[text]
            tag = self._parser.resolve(yaml.ScalarNode, text, event.implicit)
            if tag == _STR and _POWER_OF_TEN.match(text):
                number = float(text)
                # Beyond what floats hold: as written, so that it is told so.
                value: Value = number if math.isfinite(number) else text
            elif tag in (_STR, _DATE) or (tag in (_INT, _FLOAT) and _NO_NUMBER.match(text)):
                value = text
            else:
                value = self._value_of_tag(tag, event)
            self._known[text] = value
            return value
        return self._value_of_tag(tag, event)

    def _value_of_tag(self, tag: str, event: yaml.ScalarEvent) -> Value:
        if tag not in _PLAIN:
            raise _yaml_error(_no_meaning(tag), event, _NO_TAG)
        if tag == _INT and len(event.value) > MAX_DIGITS:
            # Before it is worked out: PyYAML reads numbers to the base of 60, each digit slower.
            raise _yaml_error(_TOO_LARGE, event, _IN_QUOTES)
        node = yaml.ScalarNode(tag, event.value)
        try:
            value = self._parser.construct_object(node)
        except (ValueError, LookupError, AttributeError, OverflowError) as error:
            # PyYAML trusts that whoever writes a tag also writes what it means.
            raise _yaml_error(f"{event.value[:80]!r} is not of {tag}", event, _IN_QUOTES) from error
        if isinstance(value, int) and not LEAST_INT <= value <= GREATEST_INT:
            raise _yaml_error(_TOO_LARGE, event, _IN_QUOTES)
        return value


def _no_meaning(tag: str) -> str:
    written = f"!!{tag.removeprefix(_TAG)}" if tag.startswith(_TAG) else tag
    return f"the tag {written!r} has no meaning here"


_Words = TypeVar("_Words", bound=type[yaml.resolver.Resolver])


def quoting_powers_of_ten(words: _Words) -> _Words:
    """Let a class that writes YAML know that a bare ``1e9`` is read as a number, see above."""
    words.add_implicit_resolver(_FLOAT, _POWER_OF_TEN, list("-+.0123456789"))
    return words


# Each start of a gateway writes its description for the hub: libyaml takes a quarter of the time.
@quoting_powers_of_ten
class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """With the words of our own reader."""


class _Refused(yaml.constructor.ConstructorError):
    """YAML that no description holds; ``note`` says what to do."""

    problem_mark: yaml.Mark


def _yaml_error(problem: str, event: object, remedy: str = "") -> yaml.MarkedYAMLError:
    mark = cast("yaml.Mark", getattr(event, "start_mark", None))
    return _Refused(None, None, problem, mark, remedy)
