"""Names of a robot's files, such as meshes: ``package://arm/meshes/hand.stl``. Pure."""

from __future__ import annotations

from typing import NamedTuple
from urllib.parse import unquote

__all__ = ["ASSET_SUFFIXES", "AssetUri", "is_asset_name", "parse_asset_uri"]

# Of meshes, what they are painted with, and robot descriptions.
ASSET_SUFFIXES = frozenset(
    {".bin", ".bmp", ".dae", ".glb", ".gltf", ".jpeg", ".jpg", ".mtl", ".obj", ".ply", ".png"}
    | {".sdf", ".srdf", ".stl", ".tga", ".tif", ".tiff", ".urdf", ".webp", ".xacro", ".xml"}
)
# Letters of a name.
_LONGEST = 1000


class AssetUri(NamedTuple):
    """A name, taken apart.

    Attributes:
        package: whose file it is; empty: it is named by where it lies on the robot's disk.
        parts: names of folders, and the file's; of a ``file://`` name from the root on.

    """

    package: str
    parts: tuple[str, ...]


def parse_asset_uri(uri: str) -> AssetUri | None:
    """Take a name apart; None: it names no file of a robot.

    Nothing hidden, no way up, and nothing that another system takes for a way up or a drive comes
    out of it.
    """
    if len(uri) > _LONGEST:
        return None
    scheme, marked, rest = uri.partition("://")
    # A `file://` name has no host: its path begins at once.
    if not marked or scheme not in {"package", "file"} or (scheme == "file") != (rest[:1] == "/"):
        return None
    # Taken apart first: a slash that is written %2F separates nothing.
    parts = tuple(unquote(part) for part in rest.removeprefix("/").split("/"))
    if not all(map(_is_plain_name, parts)):
        return None
    if scheme == "file":
        return AssetUri("", parts)
    return AssetUri(parts[0], parts[1:]) if len(parts) > 1 else None


def is_asset_name(name: str) -> bool:
    """Tell whether a file of this name may be a mesh or something that belongs to one."""
    stem, dot, ending = name.rpartition(".")
    return bool(stem and dot) and f".{ending.lower()}" in ASSET_SUFFIXES


def _is_plain_name(part: str) -> bool:
    return part.isprintable() and part[:1] not in {"", "."} and not set(part) & set("/\\:")
