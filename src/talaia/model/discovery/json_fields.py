"""What can be read of a message in JSON or plain text: its fields with paths and units. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.discovery.probe_report import FieldFound
from talaia.model.discovery.ros_units import unit_in_name

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["MOST_FIELDS", "fields_of_json", "join_path"]

# Of one message; what has more is a table and no set of sensors.
MOST_FIELDS = 200
_MOST_DEPTH = 12
# Elements of a list: the first ones stand for a spectrum or a track.
_MOST_ELEMENTS = 16
_PLAIN_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_-]{0,199}\Z")
# As it can stand between quotes in a path.
_QUOTED_KEY = re.compile(r"[^'\"\[\]\n]{1,200}\Z")
_NUMBER = re.compile(r"[+-]?\d{1,18}(\.\d{1,18})?([eE][+-]?\d{1,3})?\Z")


def fields_of_json(value: object, key: str = "") -> tuple[FieldFound, ...]:
    """List the numbers, truths and texts in a value, in their order.

    Args:
        value: as JSON was decoded; a plain text is itself.
        key: what the whole is called, for its unit: the last level of a topic.

    """
    found: list[FieldFound] = []
    for field in _walk(value, "", key, 0):
        found.append(field)
        if len(found) == MOST_FIELDS:
            break
    return tuple(found)


def join_path(path: str, key: str | int) -> str:
    """Give the path of a member; empty where no path can name it."""
    if isinstance(key, int):
        return f"{path or '$'}[{key}]"
    if _PLAIN_KEY.match(key):
        return f"{path}.{key}" if path else key
    return f"{path or '$'}['{key}']" if _QUOTED_KEY.match(key) else ""


def _walk(value: object, path: str, key: str, depth: int) -> Iterator[FieldFound]:
    # Deeper than any device writes; what follows would be read again and again.
    if depth > _MOST_DEPTH:
        return
    if isinstance(value, dict):
        for name, member in value.items():
            # A key with quotes in it cannot be written in a path.
            if below := join_path(path, name):
                yield from _walk(member, below, name, depth + 1)
    elif isinstance(value, list):
        for at, member in enumerate(value[:_MOST_ELEMENTS]):
            # What the list is called says what its elements are.
            yield from _walk(member, join_path(path, at), key, depth + 1)
    # Of null nobody knows what it will be.
    elif value is not None:
        yield _field_of(value, path, key)


def _field_of(value: object, path: str, key: str) -> FieldFound:
    if isinstance(value, bool):
        return FieldFound(path, "boolean")
    # A number in quotes is that number, as it is read later.
    if isinstance(value, str) and not _NUMBER.match(value.strip()):
        words = {"on": ("OFF", "ON"), "off": ("OFF", "ON")}.get(value.strip().lower(), ())
        # Letters count where it is read.
        if words and value.strip().islower():
            words = ("off", "on")
        return FieldFound(path, "text", words=words)
    meaning = unit_in_name(key)
    unit, scale = (meaning.unit, meaning.scale) if meaning else ("", 1.0)
    return FieldFound(path, "number", unit=unit, scale=scale)
