"""Files that are old or new after a crash, never half; and the data folder's lock.

A file is written beside, forced to disk and moved into place, so it is old or new, never half.
It is as large as it will ever be: where the disk is full it is written in its own place instead,
for STOP and driving must not wait for room.
"""

from __future__ import annotations

import errno
import fcntl
import logging
import os
from typing import TYPE_CHECKING, TypeVar

import msgspec

from talaia.gateway.errors import SpoolError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["NO_ROOM", "append_lines", "lock_folder", "read_whole", "write_in_place", "write_whole"]

log = logging.getLogger(__name__)
T = TypeVar("T")
# A file system's block: what lies in one is written by one blow when this process dies.
_ROOM = 4096
NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT})


def write_whole(path: Path, data: bytes) -> None:
    """Replace a file's content so that a crash at any point leaves the old or the new.

    Raises:
        OSError: it could not be written; the old content stands.

    """
    beside = path.with_name(path.name + ".new")
    with beside.open("wb") as file:
        file.write(data)
        file.flush()
        # Forced before the move: else a power cut could leave the new name with nothing in it.
        os.fsync(file.fileno())
    # Atomic within one folder (POSIX `rename`).
    beside.replace(path)
    # The move itself is an entry of the folder, and is lost in a power cut without this.
    _force_folder(path.parent)


def _force_folder(path: Path) -> None:
    folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def append_lines(path: Path, data: bytes) -> None:
    """Write behind what a file has; a crash leaves a part of it at the most.

    Raises:
        OSError: it could not be written; a part of it may stand there.

    """
    is_new = not path.exists()
    file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        # Behind a line that a power cut broke off it begins one of its own.
        left = b"\n" + data
        while left:
            left = left[os.write(file, left) :]
        os.fsync(file)
    finally:
        os.close(file)
    if is_new:
        _force_folder(path.parent)


def write_in_place(path: Path, data: bytes) -> None:
    """Do as `write_whole`; while the disk is full, in the file's own place.

    Raises:
        OSError: it could not be written; the old content stands.

    """
    # To whole blocks: the file has room for what it may hold later, also on a full disk.
    padded = data + b" " * (-len(data) % _ROOM)
    try:
        write_whole(path, padded)
    except OSError as error:
        # Half of it may be there, and takes room that is needed.
        path.with_name(path.name + ".new").unlink(missing_ok=True)
        # In place only if it fits where the file lies: writing beyond would need room again.
        if error.errno not in NO_ROOM or not path.exists() or path.stat().st_size < len(padded):
            raise
        file = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
        try:
            # Filled up to the old length: what stood behind must not follow the new content.
            os.pwrite(file, padded + b" " * (path.stat().st_size - len(padded)), 0)
            os.fsync(file)
        finally:
            os.close(file)


def read_whole(path: Path, kind: type[T], otherwise: Callable[[], T]) -> T:
    """Read a file that was written whole.

    Raises:
        SpoolError: it is damaged.
        OSError: the disk does not give it back.

    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    # The first start.
    except FileNotFoundError:
        return otherwise()
    # Bytes that a bad block has changed need not even be text.
    except (msgspec.DecodeError, UnicodeError) as error:
        # Not taken for empty: whoever held a lease or pressed STOP must not be forgotten by a bad
        # block.
        raise SpoolError(
            f"{path} cannot be read: {error}; it guards who may drive, so it is not guessed: "
            "restore it, or remove it when no page of this robot is open"
        ) from error


def lock_folder(data: Path) -> int:
    """Make the data folder this process's own, also on a disk that takes nothing now.

    Raises:
        SpoolError: another gateway uses it, or it cannot be made.

    """
    try:
        # Its owner's only: keys, and what a robot said, lie in it.
        data.mkdir(parents=True, exist_ok=True, mode=0o700)
        lock = _open_lock(data)
    except OSError as error:
        raise SpoolError(f"the data folder {data} cannot be used: {error}") from error
    try:
        # `flock`: the kernel lets go of it when the process ends, however it ends.
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(lock)
        raise SpoolError(
            f"the data folder {data} is used by another gateway; give another --data"
        ) from error
    return lock


def _open_lock(data: Path) -> int:
    """Open the lock file; on a disk that makes none, the folder itself."""
    try:
        return os.open(data / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        log.warning("%s: the lock is not written: %s", data, error)
    # A disk that is full or mounted read-only: an existing file can be locked all the same.
    try:
        return os.open(data / "lock", os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        # A folder can be locked like a file.
        return os.open(data, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
