"""What differs between two descriptions, part by part and line by line. Pure."""

from __future__ import annotations

import difflib
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple, cast

import msgspec

from talaia.model.renames import list_renames
from talaia.model.yaml_text.source_tags import plain_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Site

__all__ = ["ChangeKind", "Difference", "list_differences", "unified_diff"]

_LONGEST = 200
# As far down as signals are looked up: key, device, group, name.
_Plain = dict[str, dict[str, dict[str, dict[str, object]]]]


class ChangeKind(StrEnum):
    """What became of a part."""

    ADDED = "added"
    REMOVED = "removed"
    CHANGED = "changed"
    RENAMED = "renamed"


class Difference(NamedTuple):
    """One part that is not the same, by its path, as it was and as it is."""

    kind: ChangeKind
    path: str
    before: str = ""
    after: str = ""


def list_differences(before: Site, after: Site) -> list[Difference]:
    """List what differs, in the order of the descriptions; a whole part that came counts once."""
    # The channels of one signal are one rename.
    moved = {
        old.partition(".")[0]: new.partition(".")[0]
        for old, new in list_renames(before, after).items()
    }
    found = [
        Difference(ChangeKind.RENAMED, _path_text(new), old, new) for old, new in moved.items()
    ]
    was, now = cast("_Plain", plain_of(before)), cast("_Plain", plain_of(after))
    # What was renamed is held against what it has become.
    for old, new in moved.items():
        (of, name), (to, other) = old.split("/"), new.split("/")
        signal = was["devices"][of]["signals"].pop(name)
        # To a device that is new itself: then the whole device counts as added.
        if to in was["devices"]:
            was["devices"][to].setdefault("signals", {})[other] = signal
    return [*found, *_part_differences("$", was, now)]


def unified_diff(before: str, after: str, context: int = 3) -> list[str]:
    """Give the lines of a unified difference of two texts, without the names of files."""
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), n=context, lineterm="")
    return list(lines)[2:]


def _path_text(address: str) -> str:
    device, _, signal = address.partition("/")
    return f"$.devices.{device}.signals.{signal}"


def _part_differences(path: str, was: object, now: object) -> Iterator[Difference]:
    if was == now:
        return
    if not isinstance(was, dict) or not isinstance(now, dict):
        yield Difference(ChangeKind.CHANGED, path, _short_text(was), _short_text(now))
        return
    # What was there first, in its order, then what came.
    for key in [*was, *(key for key in now if key not in was)]:
        at = f"{path}.{key}"
        if key not in now:
            yield Difference(ChangeKind.REMOVED, at, _short_text(was[key]))
        elif key not in was:
            yield Difference(ChangeKind.ADDED, at, "", _short_text(now[key]))
        else:
            yield from _part_differences(at, was[key], now[key])


def _short_text(value: object) -> str:
    """Say a value in a line: a named part by its name."""
    if isinstance(value, dict):
        named = value.get("name") or value.get("target")
        if isinstance(named, str) and named:
            return named[:_LONGEST]
    said = value if isinstance(value, str) else msgspec.json.encode(value).decode()
    return said if len(said) <= _LONGEST else said[: _LONGEST - 1] + "…"
