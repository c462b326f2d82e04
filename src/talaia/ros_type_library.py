"""What this machine knows of ROS types: of installed packages, of named folders, of distributions.

For checks of a description before a robot runs. Nothing is imported of ROS and nothing of a
definition is run: files are parsed, and `rosbags` brings the definitions of the distributions.
A robot may have another version of a package: what any known version has is taken for right.
"""

from __future__ import annotations

import functools
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

__all__ = ["FieldKind", "RosTypeLibrary", "installed_prefixes"]

# Characters of a file; the longest messages have some 60 000, with their comments.
_MOST_TEXT = 128 * 1024
# Files of a folder that a description names; a workspace has some thousands.
_MOST_FILES = 20_000
# What the parts of a service and an action are called, in the order of their file.
_PARTS = {
    "msg": ("",),
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}
# Between the parts of a service or an action.
_DASHES = re.compile(r"(?m)^---.*$")
_FILLER = "structure_needs_at_least_one_member"


class FieldKind(NamedTuple):
    """The type of a field.

    Attributes:
        base: ``float64``, ``string``, or ``package/msg/Name``.
        many: it is a list; with ``length`` of that fixed length, 0 where that is open.

    """

    base: str
    many: bool = False
    length: int = 0


def installed_prefixes() -> list[Path]:
    """List where ROS packages are installed: as sourced, by this Python, and below ``/opt/ros``."""
    named = [
        Path(prefix)
        for variable in ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "ROS_PACKAGE_PATH")
        for prefix in os.environ.get(variable, "").split(os.pathsep)
        if prefix
    ]
    return list(dict.fromkeys([*named, Path(sys.prefix), *sorted(Path("/opt/ros").glob("*"))]))


class RosTypeLibrary:
    """Types by name, with their fields. Reads files: not for a thread that must not wait."""

    def __init__(self, folders: Iterable[Path] = ()) -> None:
        """Know what is installed, and what lies in ``folders`` (``package/msg/Name.msg``)."""
        self._prefixes = installed_prefixes()
        self._named = _files_below(folders)

    def versions_of(self, type_name: str, part: str = "") -> Iterator[Mapping[str, FieldKind]]:
        """Give the fields of each known version of a type; none where nothing knows it.

        Those of files come first; a distribution's definitions are read when they are asked for.

        Args:
            type_name: ``package/msg/Name``, or with ``srv`` or ``action``.
            part: of a service or an action: ``_Request``, ``_Goal``, ``_Feedback``.

        """
        yield from self._read_files(type_name, part)
        for store in _stores():
            if type_name + part in store:
                yield _fields_of(store[type_name + part])

    def names_in(self, package: str, middle: str) -> list[str]:
        """List the types of a package, ``Twist``; empty where nothing knows the package."""
        named = (file for of, kind, file in self._named if (of, kind) == (package, middle))
        names = {Path(file).stem for file in named}
        for folder in self._package_folders(package):
            names |= {path.stem for path in (folder / middle).glob(f"*.{middle}")}
        start = f"{package}/{middle}/"
        names |= {name.removeprefix(start) for name in _stored_names() if name.startswith(start)}
        return sorted(names)

    def packages(self) -> list[str]:
        """List the packages that have types of messages, services or actions here."""
        found = {package for package, _, _ in self._named}
        found |= {name.partition("/")[0] for name in _stored_names()}
        for prefix in self._prefixes:
            for middle in _PARTS:
                found |= {path.parent.name for path in prefix.glob(f"share/*/{middle}")}
        return sorted(found)

    def _package_folders(self, package: str) -> Iterator[Path]:
        for prefix in self._prefixes:
            # Merged, or each package in a folder of its own.
            yield prefix / "share" / package
            yield prefix / package / "share" / package

    def _read_files(self, type_name: str, part: str) -> Iterator[Mapping[str, FieldKind]]:
        package, middle, name = type_name.split("/")
        file = f"{name}.{middle}"
        paths = [folder / middle / file for folder in self._package_folders(package)]
        if (named := self._named.get((package, middle, file))) is not None:
            paths.insert(0, named)
        for path in paths:
            fields = _fields_in_file(path, package, middle, part)
            if fields is not None:
                yield fields


def _files_below(folders: Iterable[Path]) -> dict[tuple[str, str, str], Path]:
    found: dict[tuple[str, str, str], Path] = {}
    seen = 0
    for folder in folders:
        for where, below, names in os.walk(folder):
            # What is hidden is another program's.
            below[:] = sorted(name for name in below if not name.startswith("."))
            path, seen = Path(where), seen + len(names)
            if seen > _MOST_FILES:
                return found
            if path.name in _PARTS:
                found |= {(path.parent.name, path.name, name): path / name for name in names}
    return found


@functools.lru_cache(maxsize=1000)
def _fields_in_file(
    path: Path, package: str, middle: str, part: str
) -> Mapping[str, FieldKind] | None:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            text = file.read(_MOST_TEXT)
    except OSError:
        return None
    texts = dict(zip(_PARTS[middle], _DASHES.split(text), strict=False))
    if part not in texts:
        return None
    # A request that asks for nothing has no line at all, or only comments.
    if not any(line.partition("#")[0].strip() for line in texts[part].splitlines()):
        return {}
    try:
        from rosbags.typesys import get_types_from_msg

        types: Any = get_types_from_msg(texts[part], f"{package}/msg/Part")
    # A file that cannot be parsed tells nothing; its robot may well be fine.
    except Exception:  # noqa: BLE001
        return None
    return _fields_of(types[f"{package}/msg/Part"])


def _stores() -> Iterator[Mapping[str, Any]]:
    """Give the definitions of each distribution, by type; none where rosbags is not installed."""
    try:
        from rosbags.typesys import Stores
    except ModuleNotFoundError:
        return
    # The newest first: their messages have the most fields.
    yield from (_store(name) for name in sorted(Stores.__members__, reverse=True))


@functools.cache
def _store(name: str) -> Mapping[str, Any]:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores[name]).fielddefs


@functools.cache
def _stored_names() -> frozenset[str]:
    return frozenset(name for store in _stores() for name in store)


def _fields_of(definition: Any) -> Mapping[str, FieldKind]:  # noqa: ANN401 - rosbags' tuples
    _, fields = definition
    return {name: _kind_of(described) for name, described in fields if name != _FILLER}


def _kind_of(described: Any) -> FieldKind:  # noqa: ANN401 - rosbags' tuples
    # rosbags: a kind of node, and what it is made of.
    node, of = described
    if node.name == "NAME":
        return FieldKind(str(of))
    if node.name == "BASE":
        return FieldKind(str(of[0]))
    inner, length = of
    fixed = int(length) if node.name == "ARRAY" else 0
    return FieldKind(_kind_of(inner).base, many=True, length=fixed)
