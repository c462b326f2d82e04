"""The rows of a form, made from the model's shapes: label, kind, choices and help of each field.

A row also turns its value to text and what was typed back to a value, so that a form only shows.

Long, because the two directions of each kind of field stand together.
"""

from __future__ import annotations

import inspect
import math
import re
from enum import StrEnum
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import yaml

from talaia.configurator.description_paths import Path, value_at
from talaia.configurator.errors import BadValue
from talaia.model.base import SourceShape
from talaia.model.connection import ROS_KINDS, ConnectionKind, kind_of
from talaia.model.discovery.ros_units import readable_name
from talaia.model.site import Command, CommandKind, Signal, SignalType, Stream
from talaia.model.units.unit import UNITS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.connection import Connection
    from talaia.model.site import Site

__all__ = [
    "Row",
    "RowKind",
    "parse_text",
    "rows_at",
    "rows_of",
    "shown_text",
    "stored_value",
    "value_of",
]


class RowKind(StrEnum):
    """What stands in a field."""

    TEXT = "text"
    NUMBER = "number"
    INTEGER = "integer"
    TRUTH = "truth"
    CHOICE = "choice"
    # One a line.
    LIST = "list"
    # One ``key: value`` a line.
    PAIRS = "pairs"
    # A number, a truth or a text, as YAML reads it.
    ANY = "any"
    # Whether a part is there at all; its own fields follow while it is.
    PART = "part"


class Row(NamedTuple):
    """One field of a form.

    Attributes:
        path: inside the shape: ``("source", "topic")``.
        optional: left empty it is none.
        choices: the closed list of a choice.
        offers: words that are likely, for a text; others may be written.
        default: what stands where the description says nothing.
        shape: of a part.

    """

    path: Path
    label: str
    kind: RowKind
    help: str = ""
    optional: bool = False
    choices: tuple[str, ...] = ()
    offers: tuple[str, ...] = ()
    default: object = None
    shape: type[msgspec.Struct] | None = None

    @property
    def key(self) -> str:
        """The path as findings write it: ``source.topic``."""
        return ".".join(self.path)


_KINDS: dict[type, RowKind] = {
    msgspec.inspect.StrType: RowKind.TEXT,
    msgspec.inspect.FloatType: RowKind.NUMBER,
    msgspec.inspect.IntType: RowKind.INTEGER,
    msgspec.inspect.BoolType: RowKind.TRUTH,
}
# Shapes inside a shape whose fields stand in the same form.
_FLAT = frozenset({"source", "stop"})
# Shapes inside a shape that may be left out: a switch, and their fields in the same form.
_PARTS = frozenset({"detect"})
_LABELS = {
    ("detect",): "Object detection",
    ("detect", "classes"): "Classes, one a line",
    ("detect", "confidence"): "Confidence from (0 to 1)",
    ("detect", "max_rate"): "At most per second",
    ("detect", "at"): "Looked at by",
    ("detect", "model"): "Detector",
    ("name",): "Name",
    ("source", "name"): "Sensor's name",
    ("primary",): "On the first page",
    ("max_rate",): "At most per second",
    ("max_age",): "Stale after (s)",
    ("keep",): "Keep for (days)",
    ("visibility",): "Seen by",
    ("source", "stream"): "Counts on camera",
    ("source", "sees"): "Counts things of class",
    ("source", "device"): "INDI device",
    ("source", "path"): "Field of the JSON",
    ("source", "get"): "Asked for",
    ("source", "expression"): "Worked out as",
    ("indi",): "INDI device",
    ("ttl",): "Refused after (s)",
    ("timeout",): "Unknown after (s)",
}
# By the last key of a path.
_OFFERS: dict[str, tuple[str, ...]] = {"unit": tuple(UNITS)}
# An entry of ``Attributes:`` at four spaces or more; lines that go on are four further in.
_ENTRY = re.compile(r"^ {4,}(?P<name>\w+): (?P<text>.*(?:\n {8,}.*)*)", re.MULTILINE)


@cache
def rows_of(shape: type[msgspec.Struct]) -> tuple[Row, ...]:
    """List the fields of a shape that a form can show, in the order of the model."""
    return tuple(_collect_rows(shape, ()))


def _collect_rows(shape: type[msgspec.Struct], above: Path) -> Iterator[Row]:
    info = msgspec.inspect.type_info(shape)
    assert isinstance(info, msgspec.inspect.StructType)  # noqa: S101 - a shape is a struct
    # The docstrings are the only place where a key is explained: the form shows the same words.
    help_of = _help_texts(shape)
    for field in info.fields:
        path = (*above, field.name)
        if field.name in _FLAT:
            yield from _flat_rows(field.type, path)
            continue
        # Other shapes are things of their own in the tree, or are left to the file.
        if isinstance(field.type, msgspec.inspect.StructType):
            continue
        part = _optional_shape(field.type) if field.name in _PARTS else None
        if part is not None:
            about = help_of.get(field.name, "")
            yield Row(path, _LABELS[path], RowKind.PART, about, default=False, shape=part)
            yield from _collect_rows(part, path)
            continue
        # None for what no single field can hold; it is written in the file.
        row = _row_of(path, field.type)
        if row is not None:
            default = None if field.default is msgspec.NODEFAULT else field.default
            yield row._replace(help=help_of.get(field.name, ""), default=default)


def _flat_rows(kind: msgspec.inspect.Type, path: Path) -> Iterator[Row]:
    """List the fields of a shape inside a shape; of one of several the fields of all, once."""
    members = kind.types if isinstance(kind, msgspec.inspect.UnionType) else (kind,)
    listed: set[Path] = set()
    for member in members:
        if isinstance(member, msgspec.inspect.StructType):
            # `stamp` is a key of two protocols and one row.
            for row in _collect_rows(member.cls, path):
                if row.path not in listed:
                    listed.add(row.path)
                    yield row


def _optional_shape(kind: msgspec.inspect.Type) -> type[msgspec.Struct] | None:
    """Give the shape of what is one or nothing."""
    members = kind.types if isinstance(kind, msgspec.inspect.UnionType) else ()
    shapes = (member.cls for member in members if isinstance(member, msgspec.inspect.StructType))
    return next(shapes, None)


def _row_of(path: Path, kind: msgspec.inspect.Type) -> Row | None:
    label = _LABELS.get(path) or readable_name(path[-1])
    if isinstance(kind, msgspec.inspect.EnumType):
        words = tuple(str(member.value) for member in kind.cls)
        return Row(path, label, RowKind.CHOICE, choices=words)
    if isinstance(kind, msgspec.inspect.VarTupleType):
        plain = isinstance(kind.item_type, msgspec.inspect.StrType)
        return Row(path, label, RowKind.LIST) if plain else None
    if isinstance(kind, msgspec.inspect.DictType):
        inner = kind.value_type
        members = inner.types if isinstance(inner, msgspec.inspect.UnionType) else (inner,)
        plain = all(type(member) in _KINDS for member in members)
        return Row(path, label, RowKind.PAIRS) if plain else None
    if isinstance(kind, msgspec.inspect.UnionType):
        return _of_union(path, label, kind)
    known = _KINDS.get(type(kind))
    return Row(path, label, known, offers=_OFFERS.get(path[-1], ())) if known else None


def _of_union(path: Path, label: str, kind: msgspec.inspect.UnionType) -> Row | None:
    """``X | None`` is a field that may be empty; several plain types are whatever YAML reads."""
    members = [member for member in kind.types if not isinstance(member, msgspec.inspect.NoneType)]
    if len(members) > 1 and all(type(member) in _KINDS for member in members):
        return Row(path, label, RowKind.ANY, optional=True)
    row = _row_of(path, members[0]) if len(members) == 1 else None
    return row._replace(optional=True) if row else None


@cache
def _help_texts(shape: type) -> dict[str, str]:
    """Read the ``Attributes:`` of a shape's docstring."""
    text = inspect.getdoc(shape) or ""
    return {
        match["name"]: " ".join(match["text"].replace("`", "").split())
        for match in _ENTRY.finditer(text.partition("Attributes:")[2])
    }


# ── which rows fit ──

# By `Row.key`: the connections at which a key says something; a key that is missing fits all.
_BY_LINK: dict[str, frozenset[ConnectionKind]] = {
    "source.topic": ROS_KINDS | {ConnectionKind.MQTT},
    "source.type": ROS_KINDS,
    "source.field": ROS_KINDS,
    "source.name": ROS_KINDS,
    "source.parameter": ROS_KINDS,
    "source.lifecycle": frozenset({ConnectionKind.ROS2}),
    "source.stamp": ROS_KINDS | {ConnectionKind.INDI},
    "source.synchronized": ROS_KINDS | {ConnectionKind.INDI},
    "source.property": frozenset({ConnectionKind.INDI, ConnectionKind.ALPACA}),
    "source.age": frozenset({ConnectionKind.ALPACA}),
    "source.ptz": frozenset({ConnectionKind.ONVIF}),
    "source.element": frozenset({ConnectionKind.INDI}),
    "source.device": frozenset({ConnectionKind.INDI}),
    "indi": frozenset({ConnectionKind.INDI}),
    "source.run": frozenset({ConnectionKind.PROCESS}),
    "source.pattern": frozenset({ConnectionKind.PROCESS}),
    "source.messages": frozenset({ConnectionKind.PROCESS}),
    "source.path": frozenset({ConnectionKind.MQTT, ConnectionKind.HTTP}),
    "source.get": frozenset({ConnectionKind.HTTP}),
    "source.keys": frozenset({ConnectionKind.EXTENSION}),
}
# By `Row.key`: the types of signals that use it.
_BY_TYPE: dict[str, frozenset[SignalType]] = {
    **dict.fromkeys(
        ("unit", "minimum", "maximum", "decimals", "scale", "deadband", "frozen_after"),
        frozenset({SignalType.NUMBER}),
    ),
    "states": frozenset({SignalType.STATE}),
    "frame": frozenset({SignalType.POSITION}),
    "yaw_from": frozenset({SignalType.POSITION}),
}


def rows_at(site: Site, path: Path) -> tuple[Row, ...]:
    """List the rows for the thing at a path: those that its kind uses, and all that are set."""
    thing = value_at(site, path)
    if not isinstance(thing, msgspec.Struct):
        return ()
    link = None
    if len(path) > 1 and path[0] == "devices" and path[1] in site.devices:
        link = site.links().get(site.connection_of(path[1]))
    rows = [row for row in rows_of(type(thing)) if _is_there(thing, row)]
    return tuple(
        row
        for row in rows
        # The format's version is written by `talaia upgrade`, by no person.
        if (path or row.path != ("talaia",))
        and (_is_set(thing, row) or (_by_link(row, link) and _by_kind(row, thing)))
    )


def _is_there(thing: object, row: Row) -> bool:
    """A part that is left out has no fields."""
    return (
        row.path[0] not in _PARTS or len(row.path) == 1 or getattr(thing, row.path[0]) is not None
    )


def _is_set(thing: object, row: Row) -> bool:
    # A key that is set is always shown, even where it does not fit: else it could not be cleared.
    return value_of(thing, row) not in (row.default, None, "", (), {})


def _by_link(row: Row, link: Connection | None) -> bool:
    kinds = _BY_LINK.get(row.key)
    # Without a known connection nothing is hidden.
    return kinds is None or link is None or kind_of(link) in kinds


def _by_kind(row: Row, thing: object) -> bool:
    if isinstance(thing, Signal):
        types = _BY_TYPE.get(row.key)
        return types is None or thing.type in types
    if isinstance(thing, Stream):
        # What is seen on a camera's pictures is a signal's source.
        return row.key not in ("source.stream", "source.sees")
    if isinstance(thing, Command):
        return thing.kind is CommandKind.ACTION or row.key not in ("progress", "progress_end")
    return True


def value_of(thing: object, row: Row) -> object:
    """Give what stands in the row's field."""
    for step in row.path:
        foreign = thing.foreign if isinstance(thing, SourceShape) else {}
        # A key of another protocol's source is as empty as one that is not set.
        thing = foreign[step] if step in foreign else getattr(thing, step, row.default)
    return thing is not None if row.kind is RowKind.PART else thing


def stored_value(row: Row, value: object) -> object:
    """Give what the description gets for what a form gives: for a part, one as it begins."""
    if row.kind is not RowKind.PART or row.shape is None:
        return value
    return row.shape() if value is True else None


# ── value to text and back ──


def shown_text(row: Row, value: object) -> str:
    """Write a value as a form shows it."""
    if value is None:
        return ""
    if isinstance(value, dict):
        return "\n".join(f"{key}: {_scalar_text(item)}" for key, item in value.items())
    if isinstance(value, tuple | list):
        return "\n".join(str(item) for item in value)
    if row.kind in (RowKind.ANY, RowKind.TRUTH, RowKind.PART):
        return _scalar_text(value)
    if isinstance(value, float):
        # 15 digits are what a decimal keeps through a float: 0.1 stays 0.1.
        return f"{value:.15g}"
    return str(value)


def _scalar_text(value: object) -> str:
    """Write a scalar so that `_parse_any` reads the same again."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        written = repr(value)
        # YAML 1.1 takes 1e-07 for a text; with a point it is a number.
        return written if "." in written else written.replace("e", ".0e", 1)
    text = str(value)
    # A text that YAML would read as a number or a truth is put in quotation marks.
    return text if not isinstance(value, str) or _parse_any(text) == value else f'"{text}"'


def parse_text(row: Row, text: str) -> object:
    """Make a value of what was typed.

    Raises:
        BadValue: it is none, with what was expected.

    """
    said = text.strip()
    # Before the kinds: an empty field is none, whatever would be expected in it.
    if row.optional and not said:
        return None
    match row.kind:
        case RowKind.TEXT | RowKind.CHOICE:
            return said
        case RowKind.NUMBER:
            return _parse_number(said)
        case RowKind.INTEGER:
            return _parse_integer(said)
        case RowKind.TRUTH | RowKind.PART:
            return said == "true"
        case RowKind.LIST:
            return tuple(line.strip() for line in text.splitlines() if line.strip())
        case RowKind.PAIRS:
            return _parse_pairs(row, text)
        case RowKind.ANY:
            return _parse_any(said)


def _parse_number(said: str) -> float:
    try:
        # A decimal comma counts as a point; two of them are no number.
        value = float(said.replace(",", ".") if said.count(",") == 1 else said)
    except ValueError:
        raise BadValue(
            f"expected a number, found {said!r}" if said else "expected a number"
        ) from None
    # Python reads "inf" and "nan" as numbers; no limit of a robot is one.
    if not math.isfinite(value):
        raise BadValue(f"expected a finite number, found {said!r}")
    return value


def _parse_integer(said: str) -> int:
    try:
        return int(said)
    except ValueError:
        raise BadValue(
            f"expected a whole number, found {said!r}" if said else "expected a whole number"
        ) from None


def _parse_pairs(row: Row, text: str) -> dict[str, object]:
    made: dict[str, object] = {}
    for line in filter(str.strip, text.splitlines()):
        key, colon, value = line.partition(":")
        if not colon or not key.strip():
            raise BadValue(f"expected a line like this: word: value, found {line.strip()!r}")
        # The second would silently win, as in YAML.
        if key.strip() in made:
            raise BadValue(f"{key.strip()!r} is written twice")
        # Sentences are texts, whatever they look like; fixed fields are what YAML says.
        made[key.strip()] = (
            value.strip() if row.path[-1] == "messages" else _parse_any(value.strip())
        )
    return made


def _parse_any(said: str) -> float | int | bool | str:
    """Read a scalar as YAML does; what is none is a text."""
    try:
        value = yaml.safe_load(said)
    # ValueError: a date that there is not, such as 2024-02-30.
    except (yaml.YAMLError, ValueError):
        return said
    return value if isinstance(value, float | int | bool | str) else said
