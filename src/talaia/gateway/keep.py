"""The little that must survive a restart, on disk: epochs and STOP latches.

A file is written beside, forced to disk and moved into place, so it is old or new, never half.
It is as large as it will ever be: where the disk is full it is written in its own place instead,
for STOP and driving must not wait for room.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
from typing import TYPE_CHECKING, TypeVar

import msgspec

from talaia.gateway.errors import SpoolError
from talaia.gateway.stop import Latched

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["Epochs", "KeptStops", "locked", "write_whole"]

T = TypeVar("T")
_BLOCK = 1000
# A file system's block: what lies in one is written by one blow when this process dies.
_ROOM = 4096
_NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT})


def write_whole(path: Path, data: bytes) -> None:
    """Replace a file's content so that a crash at any point leaves the old or the new.

    Raises:
        OSError: it could not be written; the old content stands.

    """
    beside = path.with_name(path.name + ".new")
    with beside.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    beside.replace(path)
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _write_roomy(path: Path, data: bytes) -> None:
    """Do as `write_whole`; while the disk is full, in the file's own place.

    Raises:
        OSError: it could not be written; the old content stands.

    """
    padded = data + b" " * (-len(data) % _ROOM)
    try:
        write_whole(path, padded)
    except OSError as error:
        path.with_name(path.name + ".new").unlink(missing_ok=True)
        if error.errno not in _NO_ROOM or not path.exists() or path.stat().st_size < len(padded):
            raise
        file = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
        try:
            os.pwrite(file, padded + b" " * (path.stat().st_size - len(padded)), 0)
            os.fsync(file)
        finally:
            os.close(file)


def _read(path: Path, kind: type[T], otherwise: Callable[[], T]) -> T:
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except FileNotFoundError:
        return otherwise()
    except (OSError, msgspec.DecodeError) as error:
        raise SpoolError(
            f"{path} cannot be read: {error}; it guards who may drive, so it is not guessed: "
            "restore it, or remove it when no page of this robot is open"
        ) from error


class Epochs:
    """Numbers for leases that rise for ever.

    They are reserved on disk in blocks, so that a grant does not wait for the disk: a restart
    skips what was left of a block.
    """

    def __init__(self, path: Path) -> None:
        """Read what was reserved and reserve the next block.

        Raises:
            SpoolError: the file is damaged or cannot be written.

        """
        self._path = path
        self._last = _read(path, int, lambda: 0)
        self._reserved = self._last
        try:
            self._reserve()
        except OSError as error:
            raise SpoolError(f"{path} cannot be written: {error}") from error

    def _reserve(self) -> None:
        _write_roomy(self._path, msgspec.json.encode(self._reserved + _BLOCK))
        self._reserved += _BLOCK

    def next(self) -> int:
        """Give a number higher than every one before.

        Raises:
            OSError: a new block could not be reserved; no number is given out.

        """
        if self._last >= self._reserved:
            self._reserve()
        self._last += 1
        return self._last


class KeptStops:
    """The devices that are stopped, by name."""

    def __init__(self, path: Path) -> None:
        """Read them.

        Raises:
            SpoolError: the file is damaged.

        """
        self._path = path
        self._stops: dict[str, Latched] = _read(path, dict[str, Latched], dict)
        if not path.exists():
            # So that there is room for the first STOP even when the disk is full by then.
            with contextlib.suppress(OSError):
                _write_roomy(path, msgspec.json.encode(self._stops))

    def get(self, device: str) -> Latched | None:
        """Give who stopped a device, or none."""
        return self._stops.get(device)

    def write(self, device: str, latched: Latched | None) -> None:
        """Remember or forget one; may block on the disk.

        Raises:
            OSError: not written; what was remembered before stands.

        """
        stops = dict(self._stops)
        if latched is None:
            stops.pop(device, None)
        else:
            stops[device] = latched
        _write_roomy(self._path, msgspec.json.encode(stops))
        self._stops = stops


def locked(data: Path) -> int:
    """Make the data folder this process's own.

    Raises:
        SpoolError: another gateway uses it, or it cannot be made.

    """
    try:
        data.mkdir(parents=True, exist_ok=True, mode=0o700)
        lock = os.open(data / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise SpoolError(f"the data folder {data} cannot be used: {error}") from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(lock)
        raise SpoolError(
            f"the data folder {data} is used by another gateway; give another --data"
        ) from error
    return lock
