"""Whole files in a bucket of an object store.

A file is put together on this machine's disk, written to the bucket when it is whole, and read
back: only what is there with the same hash counts as kept. What still lies in the data folder from
before there was a bucket is found there as ever.

Long, because writing, reading back, removing and bringing the list together keep one promise.
"""

from __future__ import annotations

import asyncio
import hashlib
import io
import logging
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Literal

from talaia.hub.errors import FilesDown, StoreDown
from talaia.hub.files.local_folder import LocalFile
from talaia.hub.files.store_health import StoreUse

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
    from pathlib import Path
    from typing import BinaryIO

    from talaia.hub.files.bucket_client import BucketClient
    from talaia.hub.files.local_copies import LocalCopies
    from talaia.hub.files.ports import Openable, OpenFile, StoredFile
    from talaia.hub.store.sites.file_removals import FileRemovals

__all__ = ["Bucket", "digest_of_stored"]

_LOG = logging.getLogger(__name__)
# Read at once, whoever reads: so much of a file is in memory.
_PIECE = 4 * 1024 * 1024
# Of the list of what is to be removed, between two looks whether a file comes again.
_REMOVED_AT_ONCE = 20
# Before the store is asked again after it failed (s), ever longer.
_FIRST_PAUSE_S, _LONGEST_PAUSE_S = 1.0, 60.0
# A folder that holds nothing, and a small file that is written to see whether one can be.
_NOTHING, _PROBE = ".talaia-nothing", ".talaia-probe"


class Bucket:
    """See `FileStore`."""

    remote = True

    def __init__(
        self,
        client: BucketClient,
        *,
        url: str,
        folder: Path,
        copies: LocalCopies,
        removals: FileRemovals,
        removes: Callable[[str], Awaitable[bool]] | None = None,
    ) -> None:
        """Keep files by ``client``.

        Args:
            client: asks the store.
            url: of the bucket, for programs of others.
            folder: where files are that are not in the bucket yet.
            copies: of files that programs of this machine read.
            removals: what is still to be removed.
            removes: tells whether a file is removed here, by its key; none: all are. Whoever may
                keep a file under a key is the one who removes what had it before.

        """
        self._client = client
        self._url = url
        self._folder = folder
        self._copies = copies
        self._removals = removals
        self._removes = removes
        self._removing = asyncio.Lock()
        # Something is to be removed.
        self._due = asyncio.Event()

    @property
    def trouble(self) -> str:
        """See `FileStore`."""
        return self._client.health.trouble

    async def keep_file(self, key: str, path: Path, *, near: bool = False) -> None:
        """See `FileStore.keep_file`."""
        size, digest = await asyncio.to_thread(_measure_file, path)
        async with self._removing:
            # One that was removed under that name must not take this one with it.
            await self._removals.forget_keys([key])
        await self._client.write_file(key, path, size)
        try:
            found = await self._client.find_file(key)
        except FileNotFoundError:
            self._report_lie("has nothing of what it took")
            raise FilesDown("the store of files has nothing of what it took") from None
        if found.size != size or await digest_of_stored(self._client, found) != digest:
            self._report_lie("has other than what was written")
            raise FilesDown("the store of files has other than what was written")
        local = self._folder / key
        # Before this one was in the bucket there may have been another of that name.
        await asyncio.to_thread(local.unlink, missing_ok=True)
        if near:
            await self._copies.adopt_file(found, path)
        else:
            await asyncio.to_thread(path.unlink, missing_ok=True)

    def find_local(self, key: str) -> Path | None:
        """See `FileStore.find_local`: of what is not in the bucket yet."""
        path = self._folder / key
        return path if path.is_file() else None

    async def open_file(self, key: str) -> OpenFile:
        """See `FileStore.open_file`."""
        local = await asyncio.to_thread(self.find_local, key)
        if local is not None:
            return await asyncio.to_thread(LocalFile, local)
        return _BucketFile(self._client, await self._client.find_file(key))

    def name_file(self, key: str) -> Openable:
        """See `FileStore.name_file`."""
        return _NamedFile(self, self._client, key)

    @asynccontextmanager
    async def copy_file(self, key: str) -> AsyncIterator[Path]:
        """See `FileStore.copy_file`."""
        local = await asyncio.to_thread(self.find_local, key)
        if local is not None:
            yield local
            return
        found = await self._client.find_file(key)

        async def fetch_copy(part: Path) -> None:
            await _write_copy(self._client, found, part)

        async with self._copies.hold_copy(found, fetch_copy) as path:
            yield path

    async def remove_files(self, keys: Sequence[str]) -> None:
        """See `FileStore.remove_files`."""
        # Written down first: the store may be away for longer than this hub lives.
        await self._removals.add_keys(keys)
        for key in keys:
            await asyncio.to_thread((self._folder / key).unlink, missing_ok=True)
        self._due.set()

    async def list_files(self, folder: str) -> AsyncIterator[StoredFile]:
        """See `FileStore.list_files`; what is to be removed is not there any more."""
        gone = set(await self._removals.list_keys())
        async for found in self._client.list_files(folder):
            if found.key not in gone:
                yield found

    def address_of(self, key: str) -> str:
        """See `FileStore.address_of`."""
        return f"{self._url}/{key}"

    def prepare_disk(self) -> None:
        """Remove copies of a run before. Blocks."""
        self._copies.clear_folder()

    async def remove_for_ever(self) -> None:
        """Remove what is to be removed, until cancelled; what fails is tried again."""
        pause_s = _FIRST_PAUSE_S
        while True:
            self._due.clear()
            try:
                while await self._remove_some():
                    pause_s = _FIRST_PAUSE_S
            except StoreDown:
                # Logged already, once for each loss.
                await asyncio.sleep(pause_s)
                pause_s = min(2 * pause_s, _LONGEST_PAUSE_S)
            else:
                await self._due.wait()

    async def watch_store(self, every_s: float = 10.0) -> None:
        """Ask the store now and then, until cancelled: so its loss and return are known."""
        while True:
            await self.probe_store()
            await asyncio.sleep(every_s)

    async def probe_store(self) -> None:
        """Ask the store for nothing; where writing failed, whether it goes again."""
        health = self._client.health
        try:
            async for _ in self._client.list_files(_NOTHING):
                break
            # One that is full says so of files, not of a few bytes.
            if health.troubled(StoreUse.WRITE) and not health.full:
                await self._client.write_bytes(_PROBE, b"")
                await self._client.delete_file(_PROBE)
        except (FileNotFoundError, FilesDown):
            # The client has reported it.
            return

    async def _remove_some(self) -> bool:
        async with self._removing:
            keys = await self._due_keys()
            for key in keys:
                await self._client.delete_file(key)
                # Each by itself: what is removed must not be tried again after a restart, when
                # another file may have that name.
                await self._removals.forget_keys([key])
        return bool(keys)

    async def _due_keys(self) -> list[str]:
        if self._removes is None:
            return await self._removals.list_keys(_REMOVED_AT_ONCE)
        keys: list[str] = []
        for key in await self._removals.list_keys():
            if await self._removes(key):
                keys.append(key)
            if len(keys) == _REMOVED_AT_ONCE:
                break
        return keys

    def _report_lie(self, why: str) -> None:
        self._client.health.report_failure(StoreUse.WRITE, why)


class _BucketFile:
    """See `OpenFile`."""

    def __init__(self, client: BucketClient, found: StoredFile) -> None:
        self._client, self._found = client, found
        self.size, self.version = found.size, found.version

    async def read_part(self, at: int, count: int) -> bytes:
        if at >= self.size or not count:
            return b""
        return await self._client.read_range(self._found, at, min(count, _PIECE))

    async def close(self) -> None:
        """Do nothing: each part is asked for by itself."""


class _NamedFile:
    """See `Openable`."""

    def __init__(self, bucket: Bucket, client: BucketClient, key: str) -> None:
        self._bucket, self._client, self._key = bucket, client, key

    def open(self, mode: Literal["rb"], /) -> BinaryIO:
        """See `Openable.open`."""
        local = self._bucket.find_local(self._key)
        if local is not None:
            return local.open(mode)
        return io.BufferedReader(
            _BucketStream(self._client, self._client.find_file_here(self._key)),
            # Small reads follow one another at an index; large ones pass by it.
            buffer_size=256 * 1024,
        )


class _BucketStream(io.RawIOBase):
    """A file of a bucket as blocking code reads one."""

    def __init__(self, client: BucketClient, found: StoredFile) -> None:
        super().__init__()
        self._client, self._found, self._at = client, found, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        begin = {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._found.size}[whence]
        self._at = max(0, begin + offset)
        return self._at

    def readinto(self, buffer: bytearray | memoryview, /) -> int:  # type: ignore[override]
        room = memoryview(buffer)
        if not len(room) or self._at >= self._found.size:
            return 0
        data = self._client.read_range_here(self._found, self._at, min(len(room), _PIECE))
        room[: len(data)] = data
        self._at += len(data)
        return len(data)


async def digest_of_stored(client: BucketClient, found: StoredFile) -> str:
    """Read a file of a bucket and give its SHA-256.

    Raises:
        FilesDown: the store does not answer, or with something else.

    """
    digest, at = hashlib.sha256(), 0
    while at < found.size:
        piece = await client.read_range(found, at, _PIECE)
        # Beside the event loop: a piece takes milliseconds.
        await asyncio.to_thread(digest.update, piece)
        at += len(piece)
    return digest.hexdigest()


async def _write_copy(client: BucketClient, found: StoredFile, part: Path) -> None:
    at = 0
    file = await asyncio.to_thread(part.open, "wb")
    try:
        while at < found.size:
            piece = await client.read_range(found, at, _PIECE)
            await asyncio.to_thread(file.write, piece)
            at += len(piece)
    finally:
        await asyncio.to_thread(file.close)


def _measure_file(path: Path) -> tuple[int, str]:
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        return file.tell(), digest
