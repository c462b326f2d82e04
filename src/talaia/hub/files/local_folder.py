"""Whole files in the hub's own data folder."""

from __future__ import annotations

import asyncio
import os
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence
    from pathlib import Path
    from typing import BinaryIO

    from talaia.hub.files.ports import OpenFile, StoredFile

__all__ = ["LocalFile", "LocalFolder", "rename_durably"]


class LocalFolder:
    """See `FileStore`."""

    remote = False
    trouble = ""

    def __init__(self, folder: Path) -> None:
        """Keep files below ``folder``."""
        self._folder = folder

    async def keep_file(self, key: str, path: Path, *, near: bool = False) -> None:
        """See `FileStore.keep_file`; whatever is kept is near."""
        del near
        await asyncio.to_thread(rename_durably, path, self._folder / key)

    def find_local(self, key: str) -> Path | None:
        """See `FileStore.find_local`."""
        path = self._folder / key
        return path if path.is_file() else None

    async def open_file(self, key: str) -> OpenFile:
        """See `FileStore.open_file`."""
        return await asyncio.to_thread(LocalFile, self._folder / key)

    def name_file(self, key: str) -> Path:
        """See `FileStore.name_file`."""
        return self._folder / key

    @asynccontextmanager
    async def copy_file(self, key: str) -> AsyncIterator[Path]:
        """See `FileStore.copy_file`; whoever opens it sees whether it is there."""
        yield self._folder / key

    async def remove_files(self, keys: Sequence[str]) -> None:
        """See `FileStore.remove_files`."""
        for key in keys:
            await asyncio.to_thread((self._folder / key).unlink, missing_ok=True)

    async def list_files(self, folder: str) -> AsyncIterator[StoredFile]:
        """See `FileStore.list_files`: there are none elsewhere."""
        del folder
        nothing: tuple[StoredFile, ...] = ()
        for found in nothing:
            yield found

    def address_of(self, key: str) -> str:
        """See `FileStore.address_of`."""
        del key
        return ""


class LocalFile:
    """See `OpenFile`."""

    def __init__(self, path: Path) -> None:
        """Open it; blocks.

        Raises:
            OSError: it cannot be opened.

        """
        self._file: BinaryIO = path.open("rb")
        # Of the open file: another one may take its place meanwhile.
        found = os.fstat(self._file.fileno())
        self.size = found.st_size
        self.version = f"{found.st_mtime_ns:x}-{found.st_size:x}"

    async def read_part(self, at: int, count: int) -> bytes:
        """See `OpenFile.read_part`."""
        return await asyncio.to_thread(os.pread, self._file.fileno(), count, at)

    async def close(self) -> None:
        """See `OpenFile.close`."""
        await asyncio.to_thread(self._file.close)


def rename_durably(path: Path, place: Path) -> None:
    """Move a file on one disk; what it holds is safe before it has its new name.

    Raises:
        OSError: the disk does not take it.

    """
    place.parent.mkdir(parents=True, exist_ok=True)
    with path.open("rb") as file:
        os.fsync(file.fileno())
    path.replace(place)
