"""Reads the folder of web components that a hub's administrator fills: one folder for each tile.

Everything is read once, at the start, and served from memory: a request can name only what was
found then, so no path leads out of the folder, and a file that changes later changes nothing. A
tile that cannot be used is named with the reason; it takes no other with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import msgspec

from talaia.model.checks.identifiers import id_fits
from talaia.model.roles import SignalRole  # noqa: TC001 - msgspec reads it
from talaia.model.site import DeviceKind, SignalType  # noqa: TC001 - msgspec reads them

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

__all__ = [
    "TILE_API_VERSION",
    "TILE_GROUP",
    "BrokenTile",
    "SignalSelector",
    "Tile",
    "TileFile",
    "TileFolder",
    "TileManifest",
    "read_tiles",
]

TILE_API_VERSION: Final = 1
"""Of the keys in ``tile.json`` and of what a component is given; the pages know the same."""

TILE_GROUP: Final = "talaia.tiles"
"""How tiles are named beside the other kinds of extensions, which are entry points."""

MANIFEST: Final = "tile.json"
MOST_TILES: Final = 64
MOST_FILES: Final = 64
MOST_BYTES: Final = 2 * 1024 * 1024
"""Of all files of one tile together; all of them stay in memory."""

# What is not in it is not served. No HTML: a page of the hub's own origin could act as its user.
_MEDIA_TYPES: Final[Mapping[str, str]] = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".mjs": "text/javascript; charset=utf-8",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".webp": "image/webp",
    ".woff2": "font/woff2",
}
_SCRIPTS = (".js", ".mjs")


class SignalSelector(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Which signal of a device a tile reads; it must fit in everything that is given.

    Attributes:
        type: what kind of value it is.
        unit: as in the site description: ``m/s``.
        id: of the signal.
        role: what it is, as described or proposed: ``weather.wind``.

    """

    type: SignalType | None = None
    unit: str | None = None
    id: str | None = None
    role: SignalRole | None = None


class TileManifest(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What ``tile.json`` says.

    Attributes:
        api: the version of Talaia's interface for tiles that it is written for.
        title: above the tile.
        signals: what it reads of a device, by the tile's own names. Shown where all are there.
        module: the JavaScript module whose default export is the custom element.
        device: the kind of device that it is for; none: every kind.

    """

    api: int
    title: str
    signals: dict[str, SignalSelector]
    module: str = "tile.js"
    device: DeviceKind | None = None


@dataclass(frozen=True, slots=True)
class TileFile:
    """One file as it is served."""

    content: bytes
    media_type: str


@dataclass(frozen=True, slots=True)
class Tile:
    """A tile that can be used; ``files`` by their path inside the tile's folder."""

    name: str
    manifest: TileManifest
    files: Mapping[str, TileFile]


@dataclass(frozen=True, slots=True)
class BrokenTile:
    """One that cannot be used, and why."""

    name: str
    problem: str


@dataclass(frozen=True, slots=True)
class TileFolder:
    """What was found; both in the order of their names."""

    tiles: tuple[Tile, ...] = ()
    broken: tuple[BrokenTile, ...] = ()

    def find_file(self, tile: str, path: str) -> TileFile | None:
        """Look one file up, by the very words of its path."""
        found = next((one for one in self.tiles if one.name == tile), None)
        return found.files.get(path) if found is not None else None


class _TileProblem(Exception):
    """Why a tile cannot be used; the text is for the administrator."""


def read_tiles(folder: Path) -> TileFolder:
    """Read every tile of a folder into memory; those that cannot be used are given with the reason.

    Raises:
        OSError: the folder cannot be listed.

    """
    # Links are followed once, here; below, nothing may lead out of this folder.
    root = folder.resolve(strict=True)
    tiles: list[Tile] = []
    broken: list[BrokenTile] = []
    for entry in sorted(root.iterdir()):
        # Also what version control and editors keep there.
        if entry.name.startswith(".") or not entry.is_dir():
            continue
        try:
            if len(tiles) >= MOST_TILES:
                raise _TileProblem(f"a hub has at most {MOST_TILES} tiles")  # noqa: TRY301
            tiles.append(_read_tile(entry))
        # `OSError`: it went away meanwhile or cannot be read; the other tiles are not touched.
        except (_TileProblem, OSError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            broken.append(BrokenTile(entry.name, reason))
    return TileFolder(tuple(tiles), tuple(broken))


def _read_tile(folder: Path) -> Tile:
    # It becomes part of an address.
    for finding in id_fits("its folder's name", folder.name):
        raise _TileProblem(f"{finding.problem}; {finding.remedy}")
    if folder.is_symlink():
        raise _TileProblem("it is a symbolic link; copy the folder itself")
    files = dict(_files_of(folder))
    manifest = _manifest_of(files)
    _check_module(manifest, files)
    return Tile(folder.name, manifest, files)


def _files_of(folder: Path) -> Iterator[tuple[str, TileFile]]:
    total = count = 0
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder).as_posix()
        # A link could name any file that the hub can read.
        if path.is_symlink() or not path.resolve().is_relative_to(folder):
            raise _TileProblem(f"{inside} is a symbolic link; copy the file itself")
        if path.is_dir() or any(part.startswith(".") for part in path.relative_to(folder).parts):
            continue
        media_type = _MEDIA_TYPES.get(path.suffix)
        if media_type is None or not path.is_file():
            continue
        # By its size on disk, before it is read: a huge file never gets into memory.
        count, total = count + 1, total + path.stat().st_size
        if count > MOST_FILES or total > MOST_BYTES:
            raise _TileProblem(
                f"it has more than {MOST_FILES} files or {MOST_BYTES // 1024**2} MiB"
            )
        yield inside, TileFile(path.read_bytes(), media_type)


def _manifest_of(files: Mapping[str, TileFile]) -> TileManifest:
    found = files.get(MANIFEST)
    if found is None:
        raise _TileProblem(f"it has no {MANIFEST}")
    try:
        # The version first: a key of a newer one would only be called unknown.
        version = msgspec.json.decode(found.content, type=dict[str, object]).get("api")
        if version != TILE_API_VERSION:
            raise _TileProblem(
                f"it is written for version {version!r} of the tiles' interface, "
                f"and this Talaia has version {TILE_API_VERSION}"
            )
        manifest = msgspec.json.decode(found.content, type=TileManifest)
    except msgspec.MsgspecError as error:
        raise _TileProblem(f"{MANIFEST}: {error}") from error
    if not manifest.title.strip() or not manifest.signals:
        raise _TileProblem(f"{MANIFEST}: it needs a title and at least one signal")
    return manifest


def _check_module(manifest: TileManifest, files: Mapping[str, TileFile]) -> None:
    """Find what is plainly no module; whether it runs is known to browsers only."""
    module = files.get(manifest.module)
    if module is None or not manifest.module.endswith(_SCRIPTS):
        raise _TileProblem(f"its module {manifest.module} is not there, or is no .js file")
    try:
        text = module.content.decode()
    except UnicodeDecodeError as error:
        raise _TileProblem(f"{manifest.module} is not JavaScript: it is no UTF-8 text") from error
    # Saved as the page that shows it, for example: it begins with a mark of HTML.
    if "\0" in text or text.lstrip("\ufeff \t\r\n").startswith("<"):
        raise _TileProblem(f"{manifest.module} is not JavaScript")
    # No parser: without this word in it there is certainly no export.
    if "export" not in text:
        raise _TileProblem(f"{manifest.module} is no module: it exports no custom element")
