"""Definitions in files: of an installed distribution, a workspace, a folder or a recording."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from rosbags.interfaces import MessageDefinitionFormat

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    PartDefinition,
    TypeDefinition,
    collect_parts,
)
from talaia.gateway.adapters.ros2.type_definitions.message_text import messages_in_bundle, parts_in
from talaia.gateway.adapters.ros2.type_definitions.robot_description import definition_in_json

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

__all__ = ["DefinitionSource", "FolderDefinitions", "RecordedDefinitions", "ros_prefixes"]

# What a folder may hold before it is taken for the wrong one.
_MAX_FILES = 50_000
_MAX_BYTES = 1024 * 1024
# Of the parts of a service or an action, whose text is the whole one's.
_ENDINGS = {
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}


class _NotInText(Exception):
    """A part has no ``.msg``, ``.srv`` or ``.action`` file."""


class DefinitionSource(Protocol):
    """Knows definitions of types."""

    def find(self, type_name: str) -> Iterable[TypeDefinition]:
        """Give what is known of a type, checked; nothing for one that is not known.

        Raises:
            BadDefinition: what is known defines no type.

        """
        ...


def ros_prefixes() -> list[Path]:
    """List where ROS packages are installed: of the environment, then of this Python."""
    named = [
        Path(prefix)
        for variable in ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH")
        for prefix in os.environ.get(variable, "").split(os.pathsep)
        if prefix
    ]
    return list(dict.fromkeys([*named, Path(sys.prefix)]))


class FolderDefinitions:
    """``.msg``, ``.srv`` and ``.action`` files below folders."""

    def __init__(self, files: Callable[[str, str, str], Iterator[Path]], source: str) -> None:
        """Take what finds the file of a package, its kind (``msg``) and its name with ending."""
        self._files = files
        self._source = source
        # Where parts are looked for that are not here.
        self._beside: FolderDefinitions | None = None

    @classmethod
    def of_prefixes(cls, prefixes: Iterable[Path]) -> FolderDefinitions:
        """Look where ROS installs: ``share/package/msg``, merged or each package apart."""
        known = list(prefixes)

        def files(package: str, middle: str, file: str) -> Iterator[Path]:
            for prefix in known:
                for base in (prefix, prefix / package):
                    yield base / "share" / package / middle / file

        return cls(files, "an installed file")

    @classmethod
    def of_folder(cls, folder: Path) -> FolderDefinitions:
        """Look for ``package/msg/Name.msg`` anywhere below a folder.

        Raises:
            BadDefinition: it cannot be read, or holds far too many files.

        """
        found: dict[tuple[str, str, str], Path] = {}
        seen = 0
        for where, folders, names in os.walk(folder):
            seen += len(names)
            if seen > _MAX_FILES:
                raise BadDefinition(f"{folder} holds more than {_MAX_FILES} files; name its part")
            # What is hidden is another program's.
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            path = Path(where)
            if path.name in ("msg", "srv", "action"):
                for name in names:
                    found.setdefault((path.parent.name, path.name, name), path / name)
        if not seen:
            raise BadDefinition(f"{folder} cannot be read, or is empty")

        def files(package: str, middle: str, file: str) -> Iterator[Path]:
            path = found.get((package, middle, file))
            if path is not None:
                yield path

        return cls(files, f"the folder {folder}")

    def with_parts_of(self, beside: FolderDefinitions) -> FolderDefinitions:
        """Take what a type holds and is not here (``std_msgs/Header``) from there."""
        self._beside = beside
        return self

    def find(self, type_name: str) -> Iterable[TypeDefinition]:
        """See `DefinitionSource.find`."""
        try:
            parts = collect_parts(type_name, lambda name: self._read_needed(name, of=type_name))
        except _NotInText:
            # One part without a text: the whole is described beside it, if it is installed.
            described = self._read_json(type_name)
            return [] if described is None else [described]
        return [TypeDefinition(type_name, parts, self._source).checked()]

    def _read_needed(self, name: str, *, of: str) -> Mapping[str, PartDefinition]:
        """Read what a type is made of.

        Raises:
            _NotInText: there is no text of it.

        """
        read = self._read_parts(name)
        # A workspace has its own packages alone, and theirs hold ROS's common ones.
        if read is None and name != of and self._beside is not None:
            read = self._beside._read_parts(name)  # noqa: SLF001 - of this class
        if read is None:
            raise _NotInText
        return read

    def _read_parts(self, name: str) -> Mapping[str, PartDefinition] | None:
        package, middle, short = name.split("/")
        # A request stands in its service's file.
        whole = next(
            (short.removesuffix(end) for end in _ENDINGS.get(middle, ()) if short.endswith(end)),
            short,
        )
        text = self._text(package, middle, f"{whole}.{middle}")
        return None if text is None else parts_in(text, f"{package}/{middle}/{whole}")

    def _read_json(self, name: str) -> TypeDefinition | None:
        """Read the description that is installed beside types whose text is IDL."""
        package, middle, short = name.split("/")
        text = self._text(package, middle, f"{short}.json")
        return None if text is None else definition_in_json(text.encode(), name, self._source)

    def _text(self, package: str, middle: str, file: str) -> str | None:
        for path in self._files(package, middle, file):
            try:
                if path.stat().st_size <= _MAX_BYTES:
                    return path.read_text(encoding="utf-8", errors="replace")
            except OSError:
                continue
        return None


class RecordedDefinitions:
    """The types of a recording: a rosbag 2 folder, or one MCAP or SQLite file of one."""

    def __init__(self, path: Path) -> None:
        """Read which types it has; its messages are not looked at.

        Raises:
            BadDefinition: it is no recording.

        """
        self._source = f"the recording {path}"
        self._texts: dict[str, str] = {}
        try:
            # Only where a description names a recording: it takes 3 MiB of memory.
            from rosbags.rosbag2 import Reader

            with Reader(path) as reader:
                for connection in reader.connections:
                    if connection.msgdef.format is MessageDefinitionFormat.MSG:
                        self._texts.setdefault(connection.msgtype, connection.msgdef.data)
        except Exception as error:
            # rosbags, SQLite and its codecs raise kinds of their own.
            raise BadDefinition(f"{path} is no recording of ROS 2: {error}") from error

    def find(self, type_name: str) -> Iterable[TypeDefinition]:
        """See `DefinitionSource.find`."""
        text = self._texts.get(type_name)
        if text is not None:
            parts = messages_in_bundle(text, type_name)
            return [TypeDefinition(type_name, parts, self._source).checked()]
        # A type that another one is made of.
        for owner, bundle in self._texts.items():
            parts = messages_in_bundle(bundle, owner)
            if type_name in parts:
                return [TypeDefinition(type_name, parts, self._source).checked()]
        return []
