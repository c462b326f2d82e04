"""Which files the robot's description names, and which belong to those. Pure.

A hub gets no file that the robot itself does not name to whoever may see its description: neither
pages nor a hub in wrong hands can read through the folders of packages.
"""

from __future__ import annotations

import posixpath
import re
from html import unescape
from urllib.parse import unquote

from talaia.wire.asset_uris import AssetUri, parse_asset_uri

__all__ = ["CompanionScanner", "NamedAssets", "find_named", "is_description"]

# What a robot's model is published as.
_TOPIC = "robot_description"
_TYPES = frozenset({"std_msgs/msg/String", "std_msgs/String"})
# Bytes of a description that are read, and names that it may have.
_MOST_TEXT, _MOST_NAMES = 8 * 1024 * 1024, 2_000
_NAMED = re.compile(rb"""\bfilename\s*=\s*(?:"([^"<>]{1,2000})"|'([^'<>]{1,2000})')""")
# Kinds of meshes that name other files, and what these end in.
_NAMING = frozenset({".dae", ".gltf", ".mtl", ".obj"})
_ENDING = re.compile(rb"\.(?:bin|bmp|jpe?g|mtl|png|tga|tiff?|webp)(?![A-Za-z0-9_.])", re.IGNORECASE)
# What stands before a name: of Collada `>`, of glTF `"`, of materials a space.
_BEFORE = re.compile(rb"""[\s"'<>|*?\\]""")
# Bytes of a name, and names of one file.
_LONGEST, _MOST_COMPANIONS = 300, 500


def is_description(topic: str, type_name: str) -> bool:
    """Tell whether a topic has a robot's description."""
    return type_name in _TYPES and topic.rsplit("/", 1)[-1] == _TOPIC


def find_named(message: bytes) -> frozenset[AssetUri]:
    """Give the files that a description names, as a message or as its text alone."""
    found: set[AssetUri] = set()
    for match in _NAMED.finditer(message[:_MOST_TEXT]):
        name = parse_asset_uri(unescape((match[1] or match[2]).decode(errors="replace")).strip())
        if name is not None:
            found.add(name)
        if len(found) >= _MOST_NAMES:
            break
    return frozenset(found)


class CompanionScanner:
    """Finds the names of pictures and materials in a mesh that is read block by block."""

    def __init__(self, mesh: AssetUri) -> None:
        """What ``mesh`` names lies beside it, or in another folder of its package."""
        self._mesh = mesh
        self._reads = posixpath.splitext(mesh.parts[-1])[1].lower() in _NAMING
        self._found: set[AssetUri] = set()
        # The end of the block before: a name may stand across two.
        self._tail = b""

    def scan_block(self, block: bytes) -> None:
        """Look through the next block."""
        if not self._reads:
            return
        text = self._tail + block
        self._find_names(text, len(text) - 1)
        self._tail = text[-_LONGEST:]

    def names(self) -> frozenset[AssetUri]:
        """Give what was found, after the last block."""
        self._find_names(self._tail, len(self._tail))
        return frozenset(self._found)

    def _find_names(self, text: bytes, below: int) -> None:
        """Look for names that end at ``below`` at the latest: what follows says if they do."""
        for match in _ENDING.finditer(text):
            if match.end() > below or len(self._found) >= _MOST_COMPANIONS:
                return
            # By its end: a pattern that began anywhere would go back over long lines again.
            before = text[max(0, match.start() - _LONGEST) : match.end()]
            self._add_name(_BEFORE.split(before)[-1].decode(errors="replace"))

    def _add_name(self, text: str) -> None:
        if "://" in text:
            name = parse_asset_uri(text)
        else:
            folder = posixpath.join("/", *self._mesh.parts[:-1])
            # The package's folder is the root: a way up beyond it leads nowhere.
            path = posixpath.normpath(posixpath.join(folder, unquote(text)))
            name = AssetUri(self._mesh.package, tuple(path.strip("/").split("/")))
        if name is not None and name.package == self._mesh.package and all(name.parts):
            self._found.add(name)


class NamedAssets:
    """What may be handed out now."""

    def __init__(self) -> None:
        """Begin with nothing."""
        # By topic, and by mesh.
        self._named: dict[str, frozenset[AssetUri]] = {}
        self._companions: dict[AssetUri, frozenset[AssetUri]] = {}
        self._allowed: frozenset[AssetUri] = frozenset()

    def replace_named(self, topic: str, names: frozenset[AssetUri]) -> None:
        """Take what a description names, in place of what the one before it did."""
        self._named[topic] = names
        self._reckon()

    def add_companions(self, name: AssetUri, names: frozenset[AssetUri]) -> None:
        """Take what a file names that may be handed out."""
        self._companions[name] = names
        self._reckon()

    def allows(self, name: AssetUri) -> bool:
        """Tell whether a file is named by a description, or by a file that is."""
        return name in self._allowed

    def _reckon(self) -> None:
        allowed: set[AssetUri] = set()
        new = set().union(*self._named.values())
        while new:
            allowed |= new
            new = set().union(*(self._companions.get(name, ()) for name in new)) - allowed
        self._allowed = frozenset(allowed)
        self._companions = {name: own for name, own in self._companions.items() if name in allowed}
