"""The little that must survive a restart, on disk: epochs and STOP latches.

A file is written beside, forced to disk and moved into place, so it is old or new, never half.
It is as large as it will ever be: where the disk is full it is written in its own place instead,
for STOP and driving must not wait for room.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import logging
import os
from typing import TYPE_CHECKING, TypeVar

import msgspec

from talaia.gateway.errors import SpoolError
from talaia.gateway.stop import Latched

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["NO_ROOM", "Epochs", "KeptStops", "locked", "write_whole"]

log = logging.getLogger(__name__)
T = TypeVar("T")
_BLOCK = 1000
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
        if error.errno not in NO_ROOM or not path.exists() or path.stat().st_size < len(padded):
            raise
        file = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
        try:
            os.pwrite(file, padded + b" " * (path.stat().st_size - len(padded)), 0)
            os.fsync(file)
        finally:
            os.close(file)


def _read(path: Path, kind: type[T], otherwise: Callable[[], T]) -> T:
    """Read a file that was written whole.

    Raises:
        SpoolError: it is damaged.
        OSError: the disk does not give it back.

    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except FileNotFoundError:
        return otherwise()
    except msgspec.DecodeError as error:
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

        Where the disk does not take it nobody gets a lease until it does: a gateway that cannot
        let anybody drive still guards.

        Raises:
            SpoolError: the file is damaged.

        """
        self._path = path
        self._read = False
        self._last = self._reserved = 0
        try:
            self._reserve()
        except OSError as error:
            log.warning("nobody can take a lease: %s: %s", path, error)

    def _reserve(self) -> None:
        if not self._read:
            self._last = self._reserved = _read(self._path, int, lambda: 0)
            self._read = True
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
        self._stops: dict[str, Latched] = {}
        # What the disk did not take; it is tried again.
        self._waiting: dict[str, Latched] = {}
        self._unread = ""
        try:
            self._stops = _read(path, dict[str, Latched], dict)
        except OSError as error:
            log.warning("all that is driven begins with STOP: %s cannot be read: %s", path, error)
            self._unread = f"the gateway, which cannot read its disk ({error.strerror})"
        with contextlib.suppress(OSError):
            if not path.exists():
                # So that there is room for the first STOP even when the disk is full by then.
                _write_roomy(path, msgspec.json.encode(self._stops))

    def get(self, device: str) -> Latched | None:
        """Give who stopped a device, or none. Where that cannot be read, the gateway has."""
        kept = self._waiting.get(device) or self._stops.get(device)
        return Latched("", self._unread, 0) if kept is None and self._unread else kept

    @property
    def behind(self) -> bool:
        """Whether a STOP waits for the disk. May be asked from any thread."""
        return bool(self._waiting)

    def write_waiting(self) -> None:
        """Write what the disk did not take before; may block on it.

        Raises:
            OSError: it still does not.

        """
        for device, latched in list(self._waiting.items()):
            self.write(device, latched)

    def write(self, device: str, latched: Latched | None) -> None:
        """Remember or forget one; may block on the disk.

        Raises:
            OSError: not written; what was remembered before stands on disk. A STOP waits in
                memory.

        """
        stops = dict(self._stops)
        if latched is None:
            stops.pop(device, None)
        else:
            stops[device] = self._waiting[device] = latched
        if self._unread:
            # Nothing is written over what may be there yet.
            raise OSError(errno.EIO, f"{self._path} cannot be read; mend the disk, then restart")
        _write_roomy(self._path, msgspec.json.encode(stops))
        self._stops = stops
        self._waiting.pop(device, None)


def locked(data: Path) -> int:
    """Make the data folder this process's own, also on a disk that takes nothing now.

    Raises:
        SpoolError: another gateway uses it, or it cannot be made.

    """
    try:
        data.mkdir(parents=True, exist_ok=True, mode=0o700)
        lock = _open_lock(data)
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


def _open_lock(data: Path) -> int:
    """Open the lock file; on a disk that makes none, the folder itself."""
    try:
        return os.open(data / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        log.warning("%s: the lock is not written: %s", data, error)
    try:
        return os.open(data / "lock", os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return os.open(data, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
