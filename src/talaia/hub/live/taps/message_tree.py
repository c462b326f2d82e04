"""A serialized message as a small tree of plain values, whatever its size. Pure.

Only what is shown is read: long arrays are stepped over without making anything of them. So a
cloud of 30 MB costs as little as a scan, and no definition and no bytes can make it take much
memory or time; a gateway is not trusted with either.

Long, because reading, stepping over and the bounds of both are about the same bytes.
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.live.taps.type_texts import MessageUnreadable, TypeText, read_definitions

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosbags.interfaces.typing import FieldDesc, Typesdict

    from talaia.wire.frames import TapSchema

__all__ = ["tree_reader"]

# What a tree holds at the most: values (fields and entries); characters of texts, together and
# each; entries of an array of numbers that is shown whole, and of a longer one; entries of an array
# of what holds texts or arrays itself.
_MOST_VALUES = 8000
_MOST_TEXT, _MOST_EACH, _LEAST_EACH = 256 * 1024, 2000, 20
_WHOLE, _FIRST = 64, 16
_MOST_RECORDS = 1000
# What is read and stepped over in one message; more takes too long.
_MOST_STEPS = 300_000
# JSON's readers know whole numbers exactly up to here.
_MOST_EXACT = 2**53
# Types within types.
_MOST_DEPTH = 60

# By the names that `rosbags` gives: struct's letter; what ROS means by it, not Python.
_NUMBERS = {
    "bool": "?",
    "byte": "B",
    "char": "B",
    "octet": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
_WIDE_TEXT = "/wstring"


class _Form(NamedTuple):
    """A type, worked out once.

    Attributes:
        letter: of a number: struct's; else empty.
        size: of a number: its bytes.
        text: it is one, of characters of so many bytes each; else 0.
        fields: of a message: its fields; else None.
        of: of an array: what is in it; else None.
        length: of an array of fixed length: how many; -1: the bytes say.
        steps: of what has always the same size: how many bytes it takes by where it begins
            (modulo 8); else None.
        values: of what has always the same size: how many values are in it.

    """

    letter: str = ""
    size: int = 0
    text: int = 0
    fields: tuple[tuple[str, _Form], ...] | None = None
    of: _Form | None = None
    length: int = -1
    steps: tuple[int, ...] | None = None
    values: int = 1


def tree_reader(schema: TapSchema) -> Callable[[bytes], dict[str, object]]:
    """Work out what reads the messages of a schema as trees; see `wire.browser.TopicMessage`.

    What it gives raises `MessageUnreadable` for bytes that are no such message.

    Raises:
        MessageUnreadable: there is no definition, or none that can be read.

    """
    types = read_definitions(TypeText(schema.type, schema.encoding, schema.definition))
    ros1 = schema.message_encoding == "ros1"
    fields = _FormMaker(types, aligned=not ros1).message(schema.type, 0).fields or ()

    def read(data: bytes) -> dict[str, object]:
        if ros1:
            body, order = memoryview(data), "<"
        elif len(data) >= 4 and data[0] == 0 and data[1] in (0, 1):
            # The encapsulation's header: plain CDR, of either order of bytes.
            body, order = memoryview(data)[4:], "<" if data[1] else ">"
        else:
            raise MessageUnreadable(f"not a {schema.type}: not in plain CDR")
        reading = _Reading(body, order, ros1=ros1)
        try:
            return reading.fields(fields)
        except struct.error as error:
            raise MessageUnreadable(f"not a {schema.type}: it ends too early") from error
        except _TooMuch as error:
            raise MessageUnreadable(f"a {schema.type} with too many parts to be shown") from error

    return read


class _TooMuch(Exception):
    pass


class _FormMaker:
    """Works out the types of one definition."""

    def __init__(self, types: Typesdict, *, aligned: bool) -> None:
        self._types = types
        self._aligned = aligned
        # Each once, so that types in types do not multiply.
        self._made: dict[str, _Form] = {}
        self._open: set[str] = set()

    def message(self, name: str, depth: int) -> _Form:
        # A type that stands in many places is worked out once.
        if name in self._made:
            return self._made[name]
        # `rosbags` takes it for a message of the package.
        if name.endswith(_WIDE_TEXT) and name not in self._types:
            return _Form(text=4)
        # A type that holds itself would never end; ROS has none.
        if name not in self._types or name in self._open or depth > _MOST_DEPTH:
            raise MessageUnreadable(f"the type {name[:200]!r} is not known")
        self._open.add(name)
        fields = tuple((field, self._form(kind, depth + 1)) for field, kind in self._types[name][1])
        self._open.discard(name)
        made = _Form(fields=fields, values=sum(form.values for _, form in fields))
        forms = [form for _, form in fields]
        made = self._made[name] = made._replace(steps=_steps_of(forms))
        return made

    def _form(self, kind: FieldDesc, depth: int) -> _Form:
        from rosbags.interfaces import Nodetype

        match kind:
            case (Nodetype.BASE, (str(word), _)):
                return self._plain(word)
            case (Nodetype.NAME, str(name)):
                return self.message(name, depth)
            case (Nodetype.ARRAY, (inner, int(length))):
                of = self._form(inner, depth)
                made = _Form(of=of, length=length, values=1 + length * of.values)
                return made._replace(steps=_steps_of_many(of, length))
            case (_, (inner, _)):
                return _Form(of=self._form(inner, depth))
        raise MessageUnreadable(f"the form {kind!r} is not known")

    def _plain(self, word: str) -> _Form:
        if word == "string":
            return _Form(text=1)
        if word == "wstring":
            return _Form(text=4)
        if word not in _NUMBERS:
            raise MessageUnreadable(f"the type {word[:200]!r} is not known")
        # In CDR a number begins at a multiple of its size, counted from the header on.
        letter = _NUMBERS[word]
        size = struct.calcsize(f"<{letter}")
        steps = tuple(size + (-at % size if self._aligned else 0) for at in range(8))
        return _Form(letter=letter, size=size, steps=steps)


def _steps_of(forms: list[_Form]) -> tuple[int, ...] | None:
    """Give `_Form.steps` of forms that follow one another."""
    found = []
    for begin in range(8):
        at = begin
        for form in forms:
            # One that varies makes the whole vary.
            if form.steps is None:
                return None
            at += form.steps[at & 7]
        found.append(at - begin)
    return tuple(found)


def _steps_of_many(of: _Form, count: int) -> tuple[int, ...] | None:
    """Give `_Form.steps` of the same form, one behind the other."""
    if of.steps is None:
        return None
    return tuple(_end_of_many(of.steps, count, begin) - begin for begin in range(8))


def _end_of_many(steps: tuple[int, ...], count: int, at: int) -> int:
    """Give where ``count`` of what always has the same size end, without going through them."""
    # Where one begins (modulo 8) says where the next does, so they go round in circles soon.
    seen: dict[int, tuple[int, int]] = {}
    while count:
        before = seen.get(at & 7)
        if before is not None:
            left, begun = before
            rounds = count // (left - count)
            moved = at - begun
            at += rounds * moved
            count -= rounds * (left - count)
            seen.clear()
            continue
        seen[at & 7] = count, at
        at += steps[at & 7]
        count -= 1
    return at


class _Reading:
    """One message on its way to a tree."""

    def __init__(self, data: memoryview, order: str, *, ros1: bool) -> None:
        self._data = data
        self._order = order
        self._ros1 = ros1
        self._at = 0
        # What is left of the bounds.
        self._values = _MOST_VALUES
        self._text = _MOST_TEXT
        self._steps = _MOST_STEPS

    def fields(self, fields: tuple[tuple[str, _Form], ...]) -> dict[str, object]:
        return {name: self._value(form) for name, form in fields}

    def _value(self, form: _Form) -> object:
        # Also of what takes no bytes: only steps bound it.
        self._count_step()
        if form.fields is not None:
            return self.fields(form.fields)
        self._values -= 1
        if form.of is not None:
            return self._array(form.of, form.length)
        if form.text:
            return self._read_text(form.text)
        return _plain_number(self._number(form))

    def _array(self, of: _Form, length: int) -> object:
        count = self._length() if length < 0 else length
        if of.steps is None:
            return self._records(of, count)
        # What is in it has always the same size: how much of it is shown is known at once.
        values = max(1, of.values)
        whole = count * values <= min(_WHOLE, self._values)
        shown = count if whole else max(0, min(count, _FIRST // values or 1, self._values))
        end = _end_of_many(of.steps, count, self._at)
        if end > len(self._data):
            raise struct.error
        first = [self._value(of) for _ in range(shown)]
        self._at = end
        return first if shown == count else {"$first": first, "$of": count}

    def _records(self, of: _Form, count: int) -> object:
        first: list[object] = []
        # What follows an array is shown, too, so that the rest of it is stepped over and not left.
        while len(first) < min(count, _MOST_RECORDS) and self._values > 0:
            first.append(self._value(of))
        for _ in range(count - len(first)):
            self._skip(of)
        return first if len(first) == count else {"$first": first, "$of": count}

    def _skip(self, form: _Form) -> None:
        self._count_step()
        if form.steps is not None:
            self._at += form.steps[self._at & 7]
        elif form.fields is not None:
            for _, inner in form.fields:
                self._skip(inner)
        elif form.of is None:
            size = self._length() * form.text
            self._at += size
        else:
            count = self._length() if form.length < 0 else form.length
            if form.of.steps is not None:
                self._at = _end_of_many(form.of.steps, count, self._at)
            else:
                for _ in range(count):
                    self._skip(form.of)
        if self._at > len(self._data):
            raise struct.error

    def _number(self, form: _Form) -> float | bool:
        # ROS 1 packs without gaps.
        if not self._ros1:
            self._at += -self._at % form.size
        (value,) = struct.unpack_from(f"{self._order}{form.letter}", self._data, self._at)
        self._at += form.size
        found: float | bool = value
        return found

    def _length(self) -> int:
        return int(self._number(_LENGTH))

    def _read_text(self, width: int) -> object:
        size = self._length() * width
        end = self._at + size
        if end > len(self._data):
            raise struct.error
        most = max(_LEAST_EACH, min(_MOST_EACH, self._text))
        # A character takes four bytes at the most.
        raw = bytes(self._data[self._at : min(end, self._at + 4 * most)])
        if width == 4:
            # Units of UTF-16, of four bytes each; two of them may be one character.
            low = 0 if self._order == "<" else 2
            units = b"".join(raw[at + low : at + low + 2] for at in range(0, len(raw) & ~3, 4))
            text = units.decode("utf-16-le" if low == 0 else "utf-16-be", "replace")
        else:
            # In CDR a zero closes it.
            text = raw.decode("utf-8", "replace").removesuffix("\0")
        self._at = end
        whole = len(text) <= most and len(raw) == size
        self._text -= min(len(text), most)
        return text if whole else {"$text": text[:most], "$of": size}

    def _count_step(self) -> None:
        self._steps -= 1
        if self._steps < 0:
            raise _TooMuch


_LENGTH = _Form(letter="I", size=4)


def _plain_number(value: float | bool) -> object:  # noqa: FBT001 - what is read
    if isinstance(value, float):
        if math.isfinite(value):
            return value
        return {"$number": "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"}
    return value if -_MOST_EXACT <= value <= _MOST_EXACT else {"$number": str(value)}
