"""Where the files of a ROS package lie on this machine."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

__all__ = ["PackageIndex"]

_MARKS = Path("share", "ament_index", "resource_index", "packages")
# What packages of either ROS are called.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,200}", re.ASCII)
# Of a package.xml, which says its name at the beginning.
_NAMED = re.compile(rb"<name>\s*([A-Za-z0-9_-]+)\s*</name>")
_MOST_XML = 64 * 1024
# Folders that are looked through for a package of ROS 1.
_MOST_FOLDERS = 20_000


class PackageIndex:
    """Packages of ROS 2 by the ament index, and then of ROS 1 by its package path. Blocks."""

    def __init__(self, prefixes: Sequence[Path] = (), roots: Sequence[Path] = ()) -> None:
        """Look in ``prefixes`` (``AMENT_PREFIX_PATH``), and in ``roots`` (``ROS_PACKAGE_PATH``)."""
        self._prefixes = tuple(prefixes)
        self._roots = tuple(roots)

    @classmethod
    def from_environment(cls, environment: Mapping[str, str] = os.environ) -> PackageIndex:
        """Take the folders that are sourced."""
        return cls(
            _folders_of(environment.get("AMENT_PREFIX_PATH", "")),
            _folders_of(environment.get("ROS_PACKAGE_PATH", "")),
        )

    def find_folder(self, package: str) -> Path | None:
        """Give the folder that ``package://NAME/`` stands for, without links in its path."""
        if _NAME.fullmatch(package) is None:
            return None
        for prefix in self._prefixes:
            share = prefix / "share" / package
            if (prefix / _MARKS / package).is_file() and share.is_dir():
                return share.resolve()
        for root in self._roots:
            for folder in _packages_below(root):
                if _package_name(folder) == package:
                    return folder.resolve()
        return None

    def folder_of(self, path: Path) -> Path | None:
        """Give the folder of the package in which a file lies; ``path`` has no links in it."""
        for prefix in self._prefixes:
            share = (prefix / "share").resolve()
            if path.is_relative_to(share) and len(parts := path.relative_to(share).parts) > 1:
                folder = self.find_folder(parts[0])
                if folder is not None and path.is_relative_to(folder):
                    return folder
        for root in self._roots:
            base = root.resolve()
            if not path.is_relative_to(base):
                continue
            for folder in path.parents:
                if (folder / "package.xml").is_file():
                    return folder
                if folder == base:
                    break
        return None


def _folders_of(paths: str) -> list[Path]:
    # A path that is not absolute would mean another folder wherever the gateway is started.
    return [Path(path) for path in paths.split(os.pathsep) if os.path.isabs(path)]


def _packages_below(root: Path) -> Iterator[Path]:
    """Walk as rospack does: not into packages, nor into what is hidden or left out."""
    left = _MOST_FOLDERS
    waiting = [root]
    while waiting and left:
        folder = waiting.pop()
        left -= 1
        if (folder / "package.xml").is_file():
            yield folder
            continue
        if any((folder / mark).exists() for mark in ("CATKIN_IGNORE", "rospack_nosubdirs")):
            continue
        try:
            below = sorted(folder.iterdir(), reverse=True)
        except OSError:
            continue
        # Links are not walked: they may lead in a circle.
        waiting += [
            one for one in below if one.name[:1] != "." and one.is_dir() and not one.is_symlink()
        ]


def _package_name(folder: Path) -> str:
    try:
        with (folder / "package.xml").open("rb") as file:
            found = _NAMED.search(file.read(_MOST_XML))
    except OSError:
        return ""
    return "" if found is None else found[1].decode()
