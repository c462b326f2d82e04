"""Moves what lies in a data folder into a bucket; broken off, it goes on where it was.

Each file is written, read back and compared. While a hub runs on the folder it is only copied;
what that hub deletes afterwards is deleted in the bucket by the next run.
"""

from __future__ import annotations

import asyncio
import hashlib
import os
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.errors import FilesDown
from talaia.hub.files.bucket import digest_of_stored

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from talaia.hub.files.bucket_client import BucketClient

__all__ = ["LEDGER", "FileMover", "MoveResult", "list_movable"]

# Beside the files: which were copied, so that none comes back that was deleted meanwhile.
LEDGER = "move-files.log"
_COPIED, _MOVED = "copied", "moved"
# Of recordings, and of the archive; what is on its way has other endings.
_WHOLE = (".mcap", ".mp4")


class MoveResult(NamedTuple):
    """What was done.

    Attributes:
        copied: files that were written to the bucket.
        there: files that were there already.
        deleted: files of a run before that are not in the folder any more.
        total_bytes: of all files of the folder.

    """

    copied: int
    there: int
    deleted: int
    total_bytes: int


class FileMover:
    """One run."""

    def __init__(
        self, client: BucketClient, data: Path, *, remove: bool, tell: Callable[[str], None]
    ) -> None:
        """Move files of ``data``; ``remove``: no hub uses them, so they need not stay.

        ``tell`` is told how far it is.
        """
        self._client = client
        self._data = data
        self._remove = remove
        self._tell = tell

    async def move_all(self) -> MoveResult:
        """Move all that is there.

        Raises:
            FilesDown: the store does not answer; what was moved stays moved.
            OSError: a file cannot be read.

        """
        keys = await asyncio.to_thread(lambda: list(list_movable(self._data)))
        deleted = await self._delete_gone(set(keys))
        sizes = {key: (self._data / key).stat().st_size for key in keys}
        copied = there = done = 0
        for number, key in enumerate(keys, start=1):
            new = await self._move_file(key)
            copied, there = copied + (new is True), there + (new is False)
            done += sizes[key]
            words = f"{done / 1e9:.2f} of {sum(sizes.values()) / 1e9:.2f} GB"
            self._tell(f"{number} of {len(keys)}, {words}: {key}")
        return MoveResult(copied, there, deleted, sum(sizes.values()))

    async def _move_file(self, key: str) -> bool | None:
        """Move a file; tell whether it was written, or None: it went away meanwhile."""
        path = self._data / key
        try:
            size, digest = await asyncio.to_thread(_measure_file, path)
            new = not await self._is_stored(key, size, digest)
            if new:
                # Before it is written: it may be deleted here before this is run again.
                await asyncio.to_thread(self._append_line, _COPIED, key)
                await self._client.write_file(key, path, size)
                if not await self._is_stored(key, size, digest):
                    raise FilesDown(
                        f"the store of files has other than what was written of {key}",
                        "look at its log, and run this again",
                    )
        except FileNotFoundError:
            return None
        if self._remove:
            await asyncio.to_thread(self._append_line, _MOVED, key)
            await asyncio.to_thread(path.unlink, missing_ok=True)
        return new

    async def _is_stored(self, key: str, size: int, digest: str) -> bool:
        try:
            found = await self._client.find_file(key)
        except FileNotFoundError:
            return False
        return found.size == size and await digest_of_stored(self._client, found) == digest

    async def _delete_gone(self, there: set[str]) -> int:
        """Delete what was only copied, and has been deleted here since."""
        states = await asyncio.to_thread(self._read_ledger)
        gone = [key for key, state in states.items() if state == _COPIED and key not in there]
        for key in gone:
            await self._client.delete_file(key)
            await asyncio.to_thread(self._append_line, _MOVED, key)
            self._tell(f"deleted here, so there as well: {key}")
        return len(gone)

    def _read_ledger(self) -> dict[str, str]:
        try:
            lines = (self._data / LEDGER).read_text().splitlines()
        except FileNotFoundError:
            return {}
        # The last word on each; one that was cut off says nothing.
        found = (line.partition(" ") for line in lines)
        return {key: state for state, _, key in found if state in {_COPIED, _MOVED} and key}

    def _append_line(self, state: str, key: str) -> None:
        with (self._data / LEDGER).open("a") as ledger:
            ledger.write(f"{state} {key}\n")
            ledger.flush()
            os.fsync(ledger.fileno())


def list_movable(data: Path) -> Iterator[str]:
    """List whole files of a data folder that belong into a bucket, by their keys."""
    for path in sorted(data.glob("recordings/*/*")):
        if path.suffix in _WHOLE:
            about = path.with_suffix(".json")
            # Before the file itself, of which alone no row could be made.
            if about.is_file():
                yield about.relative_to(data).as_posix()
            yield path.relative_to(data).as_posix()
    for path in sorted(data.glob("archive/*/*/*.fits")):
        yield path.relative_to(data).as_posix()


def _measure_file(path: Path) -> tuple[int, str]:
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        return file.tell(), digest
