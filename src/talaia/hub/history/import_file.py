"""A file of samples on their way into the history: how `talaia import` hands them to the hub.

One program at a time may write a database's history, and while a hub runs, that is the hub. So an
import writes *parcels* into the hub's data folder, and the hub takes those over that are complete.
A parcel is complete when it has its final name, which it gets only after all of it is on the disk.

A file is a line of magic, then records: length (u32) and CRC-32 (u32) of a body, little-endian,
and the body. The first body is a `Head`; each other one is a `_Row` (both MessagePack).
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import secrets
import struct
from typing import TYPE_CHECKING, NamedTuple, Self
from zlib import crc32

import msgspec

from talaia.hub.history.blocks.journal import read_row, write_row
from talaia.hub.history.errors import HistoryError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from types import TracebackType
    from typing import BinaryIO

    from talaia.wire.columns import Columns

__all__ = [
    "FOLDER",
    "PART",
    "READY",
    "Head",
    "ImportChunk",
    "ParcelDamaged",
    "ParcelWriter",
    "boot_of",
    "read_parcel",
    "remove_abandoned",
]

FOLDER = "import"
PART, READY = ".part", ".ready"
_MAGIC = b"talaia import 1\n"
# Length and CRC-32 of a body.
_FRAME = struct.Struct("<II")
# A greater length is damage: it must not be read into memory.
_LONGEST = 64 * 1024 * 1024


class ParcelDamaged(HistoryError):
    """The file is not a parcel, or not all of it."""


class Head(msgspec.Struct, frozen=True, kw_only=True):
    """What is in a parcel.

    Attributes:
        file: the name of the file it was read from, for people.
        digest: SHA-256 of that file (hexadecimal); it keys the samples.
        description: the site description it was read by (YAML).

    """

    site: str
    file: str
    digest: str
    description: str


class ImportChunk(NamedTuple):
    """Samples of one channel; the first has the number ``first`` among those in the file.

    ``columns.channel`` is zero throughout.
    """

    address: str
    first: int
    columns: Columns


class _Row(msgspec.Struct, array_like=True):
    address: str
    first: int
    body: bytes


def boot_of(digest: str, address: str) -> str:
    """Name what numbers the samples of one channel in one file.

    Each channel counts on its own: when a description has learnt another signal, importing the
    file again adds that one, and nothing twice.
    """
    return f"file {digest[:32]} {address}"[:200].rstrip()


class ParcelWriter:
    """Writes one parcel. Leaving the block without `publish_file` leaves nothing behind."""

    def __init__(self, folder: Path, head: Head) -> None:
        """Begin a file in ``folder``, which is made if need be.

        Raises:
            OSError: it cannot be written.

        """
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        name = f"{head.digest[:16]}-{secrets.token_hex(4)}"
        self._part = folder / (name + PART)
        self._ready = folder / (name + READY)
        number = os.open(self._part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        # Held while it is written, so that `remove_abandoned` knows it from one left behind.
        fcntl.flock(number, fcntl.LOCK_EX)
        self._file: BinaryIO = os.fdopen(number, "wb")
        self._file.write(_MAGIC)
        self._write_body(msgspec.msgpack.encode(head))

    def __enter__(self) -> Self:
        """Give itself."""
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        """Remove what was not published."""
        self._file.close()
        self._part.unlink(missing_ok=True)

    def add_chunk(self, stretch: ImportChunk) -> None:
        """Write samples.

        Raises:
            OSError: the disk is full, or worse.

        """
        body = write_row(stretch.columns)
        self._write_body(msgspec.msgpack.encode(_Row(stretch.address, stretch.first, body)))

    def publish_file(self) -> Path:
        """Force it to the disk, and let the hub see it.

        Raises:
            OSError: the disk is full, or worse.

        """
        self._file.flush()
        os.fsync(self._file.fileno())
        self._part.rename(self._ready)
        # The new name is on the disk only with its folder.
        _sync_folder(self._ready.parent)
        return self._ready

    def _write_body(self, body: bytes) -> None:
        self._file.write(_FRAME.pack(len(body), crc32(body)))
        self._file.write(body)


def read_parcel(path: Path) -> tuple[Head, Iterator[ImportChunk]]:
    """Open a parcel; its samples are read as they are taken.

    Raises:
        ParcelDamaged: it is not a parcel; also raised by the iterator.
        OSError: it cannot be read.

    """
    bodies = _read_bodies(path)
    try:
        head = msgspec.msgpack.decode(next(bodies), type=Head)
    except (StopIteration, msgspec.MsgspecError, UnicodeError) as error:
        raise ParcelDamaged(f"{path} has no head: {error}") from error

    def stretches() -> Iterator[ImportChunk]:
        for body in bodies:
            try:
                row = msgspec.msgpack.decode(body, type=_Row)
            except (msgspec.MsgspecError, UnicodeError) as error:
                raise ParcelDamaged(f"{path} is damaged: {error}") from error
            yield ImportChunk(row.address, row.first, read_row(row.body))

    return head, stretches()


def remove_abandoned(folder: Path) -> None:
    """Remove parcels whose writers were killed."""
    for path in folder.glob(f"*{PART}"):
        # Whoever still writes a file holds its lock, and it stays.
        with contextlib.suppress(OSError), path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink(missing_ok=True)


def _read_bodies(path: Path) -> Iterator[bytes]:
    with path.open("rb") as file:
        if file.read(len(_MAGIC)) != _MAGIC:
            raise ParcelDamaged(f"{path} is not a parcel of this version")
        while frame := file.read(_FRAME.size):
            at = file.tell()
            if len(frame) < _FRAME.size:
                raise ParcelDamaged(f"{path} ends in the middle of a record, at byte {at}")
            length, check = _FRAME.unpack(frame)
            body = file.read(length) if length <= _LONGEST else b""
            if len(body) != length or crc32(body) != check:
                raise ParcelDamaged(f"{path} is damaged at byte {at}")
            yield body


def _sync_folder(folder: Path) -> None:
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
