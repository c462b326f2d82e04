"""Shared memory that killed ROS 2 processes left behind, removed.

Fast DDS keeps the messages of each process in segments under /dev/shm (0.5 to 70 MB). Who is killed
cannot remove his own, and nobody else does, so that a crash loop fills the memory of the machine.
Beside each segment lies a file ``…_el`` that its owner locks (flock) for as long as he lives, in
whatever container and also while he is frozen. A lock that can be had is that of a dead owner;
``fastdds shm clean`` goes by the same.

Left alone are: files of other users; files of the last seconds, whose owner may be about to lock
them; and ports (63 kB each), which the next process of that domain uses again. Others that still
read a dead process's segment go on, for they have it mapped.
"""

from __future__ import annotations

import contextlib
import fcntl
import logging
import os
import re
import stat
import threading
import time
from pathlib import Path
from typing import NamedTuple

__all__ = ["Removed", "remove_dead_segments", "remove_dead_segments_at_start"]

_LOG = logging.getLogger(__name__)
_FOLDER = Path("/dev/shm")  # noqa: S108 - where Fast DDS has its segments
# Fast DDS 2 calls them fastrtps.
_LOCK = re.compile(r"fast(?:dds|rtps)_[0-9a-f]{16}_el")
# Fast DDS makes a lock file and locks it at once; so much later it is locked or its owner is dead.
_SETTLED_S = 2.0


class Removed(NamedTuple):
    """What was removed: segments, and the room they took (bytes).

    ``young``: so many are without a living owner, it seems, and too young to tell.
    """

    segments: int = 0
    size: int = 0
    young: int = 0


def remove_dead_segments(folder: Path = _FOLDER) -> Removed:
    """Remove this user's segments whose owners are dead; what cannot be removed stays."""
    removed = Removed()
    try:
        # Ports have other names, and so they stay.
        locks = [name for name in os.listdir(folder) if _LOCK.fullmatch(name)]
    # Another system, or a container without it: there is nothing to remove.
    except OSError:
        return removed
    for name in locks:
        # Gone meanwhile, another user's, or a link: one that resists must not keep the others.
        with contextlib.suppress(OSError):
            found = _remove_if_dead(folder / name)
            removed = Removed(*map(sum, zip(removed, found, strict=True)))
    return removed


def remove_dead_segments_at_start() -> threading.Thread:
    """Remove them beside the start of a process, and once more what is too young just now.

    Gives the thread that does it; it keeps no process from ending.
    """
    thread = threading.Thread(target=_remove_twice, name="shared memory", daemon=True)
    thread.start()
    return thread


def _remove_twice() -> None:
    first = remove_dead_segments()
    second = Removed()
    if first.young:
        # Then those of a crash just before this start are old enough to be judged.
        time.sleep(_SETTLED_S)
        second = remove_dead_segments()
    segments, size = first.segments + second.segments, first.size + second.size
    if segments:
        _LOG.info(
            "removed %d shared memory segments of killed ROS 2 processes (%.1f MB)",
            segments,
            size / 1e6,
        )


def _remove_if_dead(lock: Path) -> Removed:
    """Remove a lock file and its segment unless the owner lives, may be young, or is a stranger."""
    # /dev/shm is everybody's: no link is followed to another's file, and a FIFO does not hold us
    # up.
    file = os.open(lock, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK)
    try:
        found = os.fstat(file)
        if not _is_ours(found):
            return Removed()
        # The wall clock, for a file's time is of it; one from the future counts as young.
        if time.time() - found.st_mtime < _SETTLED_S:
            # Not even tried: its owner, about to lock it, must not find it locked by us.
            return Removed(young=1)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # Its owner lives.
        except BlockingIOError:
            return Removed()
        # Between open and lock it was removed and made anew: that lock is another process's.
        if not os.path.samestat(found, os.lstat(lock)):
            return Removed()
        # The segment first: were the lock gone before it, nobody would find the segment again.
        size = _unlink_segment(lock.with_name(lock.name.removesuffix("_el")))
        lock.unlink()
        return Removed(1, size)
    finally:
        os.close(file)


def _unlink_segment(path: Path) -> int:
    """Remove a segment of ours; gives the room that it took (bytes)."""
    try:
        found = path.lstat()
    # Removed already, or its owner was killed before it was made.
    except FileNotFoundError:
        return 0
    if not _is_ours(found):
        raise PermissionError(f"{path} belongs to another user")
    path.unlink()
    # Blocks are of 512 bytes (stat(2)); a segment may be sparse, so its length says too much.
    return found.st_blocks * 512


def _is_ours(found: os.stat_result) -> bool:
    # Root could remove others' files as well: they are left to their owners.
    return stat.S_ISREG(found.st_mode) and found.st_uid == os.geteuid()
