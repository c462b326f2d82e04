"""A file of a robot's package: found, held against what may be handed out, and read. Blocks."""

from __future__ import annotations

import hashlib
import os
import stat
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

from talaia.gateway.assets.named_assets import CompanionScanner
from talaia.gateway.errors import AssetUnavailable
from talaia.wire.asset_uris import is_asset_name
from talaia.wire.frames import MAX_ASSET

if TYPE_CHECKING:
    from talaia.gateway.assets.package_index import PackageIndex
    from talaia.wire.asset_uris import AssetUri

__all__ = ["AssetReader", "ReadAsset"]

_BLOCK = 64 * 1024
# Files whose digests are remembered.
_MOST_KNOWN = 5_000


class ReadAsset(NamedTuple):
    """What is known of a file.

    Attributes:
        size: bytes.
        digest: SHA-256 of all of it.
        companions: names of files that belong to it, as `CompanionScanner` has them.

    """

    size: int
    digest: str
    companions: frozenset[AssetUri]


class AssetReader:
    """Reads files of packages, and nothing else. For one thread at a time."""

    def __init__(self, index: PackageIndex, beside: Path | None = None) -> None:
        """Find packages by ``index``; what is named may also lie below the folder ``beside``."""
        self._index = index
        self._beside = beside
        # By path: what tells that the file is another now, and what was known of it.
        self._known: dict[Path, tuple[tuple[int, ...], ReadAsset]] = {}

    def examine(self, name: AssetUri) -> ReadAsset:
        """Give a file's size and digest; it is read only if it is another than before.

        Raises:
            AssetUnavailable: it is not handed out.

        """
        path = self._find_path(name)
        with _open_file(path) as file:
            about = os.fstat(file.fileno())
            mark = (about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns, about.st_ctime_ns)
            known = self._known.get(path)
            if known is not None and known[0] == mark:
                return known[1]
            size, digest, scanner = 0, hashlib.sha256(), CompanionScanner(name)
            # Block by block: other threads, which drive, have their turn between two.
            while block := file.read(_BLOCK):
                size += len(block)
                if size > MAX_ASSET:
                    raise _too_large(size)
                digest.update(block)
                scanner.scan_block(block)
        found = ReadAsset(size, digest.hexdigest(), scanner.names())
        if len(self._known) >= _MOST_KNOWN:
            self._known.clear()
        self._known[path] = mark, found
        return found

    def read_whole(self, name: AssetUri) -> bytes:
        """Read all of a file.

        Raises:
            AssetUnavailable: it is not handed out.

        """
        with _open_file(self._find_path(name)) as file:
            data = file.read(MAX_ASSET + 1)
        if len(data) > MAX_ASSET:
            raise _too_large(len(data))
        return data

    def _find_path(self, name: AssetUri) -> Path:
        """Give where a file lies, without links in its path: where they lead counts."""
        if not is_asset_name(name.parts[-1]):
            raise AssetUnavailable(
                "only meshes, and pictures and materials of meshes, are handed out"
            )
        folder = None
        if name.package:
            folder = self._index.find_folder(name.package)
            if folder is None:
                raise AssetUnavailable(
                    f"there is no package {name.package!r} where the gateway runs (source its"
                    " workspace before the gateway starts)"
                )
        try:
            path = (folder or Path("/")).joinpath(*name.parts).resolve(strict=True)
        except (OSError, RuntimeError) as error:
            raise AssetUnavailable("there is no such file where the gateway runs") from error
        if folder is None:
            folder = self._index.folder_of(path)
        if not self._is_allowed(path, folder):
            raise AssetUnavailable(
                "it lies outside of its package's folder, perhaps by a link of the workspace (see"
                " talaia gateway --meshes-from)"
            )
        # By a link, another kind of file may stand behind a mesh's name.
        if not is_asset_name(path.name):
            raise AssetUnavailable(
                "only meshes, and pictures and materials of meshes, are handed out"
            )
        return path

    def _is_allowed(self, path: Path, folder: Path | None) -> bool:
        if folder is not None and path.is_relative_to(folder):
            return True
        return self._beside is not None and path.is_relative_to(self._beside.resolve())


def _open_file(path: Path) -> BinaryIO:
    # Not to wait for a pipe, and not by a link that took the file's place meanwhile.
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOFOLLOW
    try:
        file = os.fdopen(os.open(path, flags), "rb")
    except OSError as error:
        raise AssetUnavailable(f"the file cannot be read: {error.strerror}") from error
    about = os.fstat(file.fileno())
    if not stat.S_ISREG(about.st_mode) or about.st_size > MAX_ASSET:
        file.close()
        if stat.S_ISREG(about.st_mode):
            raise _too_large(about.st_size)
        raise AssetUnavailable("it is no regular file")
    return file


def _too_large(size: int) -> AssetUnavailable:
    return AssetUnavailable(f"it has {size} bytes, and files over {MAX_ASSET} are not handed out")
