"""Copies of a bucket's files on this machine's disk, for programs that read a file by its name.

There is a limit to what they take: the one that was used longest ago goes first, and none goes
while it is used. They are of this run of the hub only.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import shutil
from collections import OrderedDict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable
    from pathlib import Path

    from talaia.hub.files.ports import StoredFile

__all__ = ["LocalCopies"]

_SPARE_BYTES = 256 * 1024 * 1024


class LocalCopies:
    """The folder of copies."""

    def __init__(self, folder: Path, most_bytes: int) -> None:
        """Keep copies in ``folder``; above ``most_bytes`` the oldest go."""
        self._folder = folder
        self._most_bytes = most_bytes
        # Bytes of each, the one that was used longest ago first.
        self._sizes: OrderedDict[str, int] = OrderedDict()
        # How many use each now; those have no turn to go.
        self._uses: dict[str, int] = {}
        # One fetch at a time, which bounds what is on its way.
        self._fetching = asyncio.Lock()

    def clear_folder(self) -> None:
        """Begin with none: what is there is of a run before. Blocks."""
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    @contextlib.asynccontextmanager
    async def hold_copy(
        self, found: StoredFile, fetch: Callable[[Path], Awaitable[None]]
    ) -> AsyncIterator[Path]:
        """Have a copy of a file until the block ends; ``fetch`` writes it where there is none.

        Raises:
            OSError: the disk does not take it.

        """
        name = _copy_name(found)
        path = self._folder / name
        self._uses[name] = self._uses.get(name, 0) + 1
        try:
            async with self._fetching:
                if name not in self._sizes:
                    await asyncio.to_thread(self._check_room, found.size)
                    part = path.with_suffix(".part")
                    await fetch(part)
                    await asyncio.to_thread(part.replace, path)
                    self._sizes[name] = found.size
                self._sizes.move_to_end(name)
                await self._remove_oldest()
            yield path
        finally:
            self._uses[name] -= 1
            if not self._uses[name]:
                del self._uses[name]

    async def adopt_file(self, found: StoredFile, path: Path) -> None:
        """Take a file of this disk as the copy of what is in the bucket; it is moved."""
        name = _copy_name(found)
        async with self._fetching:
            await asyncio.to_thread(path.replace, self._folder / name)
            self._sizes[name] = found.size
            self._sizes.move_to_end(name)
            await self._remove_oldest()

    def _check_room(self, size: int) -> None:
        # The database and the rest of the machine need the last of the disk more.
        if shutil.disk_usage(self._folder).free < size + _SPARE_BYTES:
            raise OSError("the disk is full")

    async def _remove_oldest(self) -> None:
        left = sum(self._sizes.values())
        for name in list(self._sizes):
            if left <= self._most_bytes:
                return
            if name not in self._uses:
                left -= self._sizes.pop(name)
                await asyncio.to_thread((self._folder / name).unlink, missing_ok=True)


def _copy_name(found: StoredFile) -> str:
    # Of another version it is another copy, and no key becomes a path.
    named = hashlib.sha256(f"{found.key}\0{found.version}\0{found.size}".encode()).hexdigest()
    return f"{named}.copy"
