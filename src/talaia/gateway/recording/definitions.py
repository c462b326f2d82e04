"""The full definition of a ROS 2 type, as an MCAP file carries it (``ros2msg``).

A definition is the type's own text, then each type it is made of, after a line of ``=`` and one of
``MSG: package/Name``: the form that rosbag 2 writes and that Foxglove and Lichtblick read. The
texts come from the packages' ``share`` folders; where a package has none there, the Python class
tells its fields (constants and comments are missing then, and the bytes mean the same).
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.gateway.errors import GatewayError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["NoDefinition", "definition_of"]

_RULE = "=" * 80
_BASIC = frozenset(
    (
        "bool",
        "byte",
        "char",
        "float32",
        "float64",
        "int8",
        "uint8",
        "int16",
        "uint16",
        "int32",
        "uint32",
        "int64",
        "uint64",
        "string",
        "wstring",
    )
)
# A field's type at the beginning of a line: name, bounds of a string, array.
_TYPE = re.compile(r"^\s*([A-Za-z][A-Za-z0-9_/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]")
_SEQUENCE = re.compile(r"sequence<(?P<of>.+?)(?:, (?P<most>\d+))?>\Z")
_ARRAY = re.compile(r"(?P<of>.+)\[(?P<size>\d+)\]\Z")
_STRING = re.compile(r"(?P<of>w?string)<(?P<most>\d+)>\Z")
# rosidl's own words for what ``.msg`` files call otherwise.
_WORDS = {"boolean": "bool", "double": "float64", "float": "float32", "octet": "byte"}
_CHAIN = 1000


class NoDefinition(GatewayError):
    """A type is installed nowhere here."""


def definition_of(type_name: str, fields_of: Callable[[str], Mapping[str, str]]) -> str:
    """Give the full definition of ``package/msg/Name``.

    Args:
        type_name: which.
        fields_of: gives the fields of a type as rosidl's Python classes tell them; asked where
            there is no ``.msg`` file.

    Raises:
        NoDefinition: of a type nothing is known.

    """
    texts: dict[str, str] = {}
    wanted = [type_name]
    while wanted:
        name = wanted.pop(0)
        if name in texts:
            continue
        if len(texts) > _CHAIN:
            raise NoDefinition(f"{type_name} is made of more than {_CHAIN} types")
        text = _definition_file(name)
        if text is None:
            text = _definition_text(fields_of(name))
        texts[name] = text
        wanted += _part_types(text, name.split("/", 1)[0])
    own, *others = texts.items()
    parts = [own[1].rstrip("\n")]
    for name, text in others:
        package, _, short = name.split("/")
        parts += [_RULE, f"MSG: {package}/{short}", text.rstrip("\n")]
    return "\n".join(parts) + "\n"


def _definition_file(name: str) -> str | None:
    package, _, short = name.split("/")
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    for prefix in prefixes:
        path = Path(prefix) / "share" / package / "msg" / f"{short}.msg"
        if prefix and path.is_file():
            return path.read_text(encoding="utf-8", errors="replace")
    return None


def _part_types(text: str, package: str) -> list[str]:
    """Name the types that a text is made of, in its order."""
    found = []
    for line in text.splitlines():
        match = _TYPE.match(line.split("#", 1)[0])
        if match is None or match[1] in _BASIC:
            continue
        steps = match[1].split("/")
        if len(steps) == 1:
            # ROS 1's word for it, which some files still use.
            known = "std_msgs/msg/Header" if steps[0] == "Header" else f"{package}/msg/{steps[0]}"
            found.append(known)
        else:
            found.append(f"{steps[0]}/msg/{steps[-1]}")
    return found


def _definition_text(fields: Mapping[str, str]) -> str:
    lines = [f"{_element_type(kind)} {name}" for name, kind in fields.items()]
    return "\n".join(lines) + "\n"


def _element_type(kind: str) -> str:
    sequence = _SEQUENCE.match(kind)
    if sequence is not None:
        most = f"<={sequence['most']}" if sequence["most"] else ""
        return f"{_element_type(sequence['of'])}[{most}]"
    array = _ARRAY.match(kind)
    if array is not None:
        return f"{_element_type(array['of'])}[{array['size']}]"
    string = _STRING.match(kind)
    if string is not None:
        return f"{string['of']}<={string['most']}"
    return _WORDS.get(kind, kind)
