"""Find and remove what a test run leaves on the machine: shared memory and processes.

    python tests/leftovers.py

removes the shared memory of Fast DDS whose processes are all dead. A process that ends in peace
removes its own; one that is killed, as many tests do, leaves some megabytes in /dev/shm.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import signal
import sys
import time
from pathlib import Path
from typing import NamedTuple

SHARED_MEMORY = Path("/dev/shm")  # noqa: S108 - where Linux keeps it
PROCESSES = Path("/proc")
# A segment, a port, or the lock file of either; a port's mutex is a named semaphore.
SEGMENT = re.compile(r"(fast(?:dds|rtps)_(?:port\d+|[0-9a-f]{8,}))(?:_[es]l)?")
MUTEX = re.compile(r"sem\.(fast(?:dds|rtps)_port\d+)_mutex")
MARK = "TALAIA_TEST_RUN"
"""Names the run in the environment of all its processes."""


class Removed(NamedTuple):
    """What was removed from shared memory: number of files and their size (bytes)."""

    files: int
    size: int


def remove_dead_shared_memory(since: float = 0.0, folder: Path = SHARED_MEMORY) -> Removed:
    """Remove the Fast DDS files that appeared after ``since`` (epoch, s) and have no process.

    Fast DDS holds a lock on a lock file beside each segment and port for as long as its process
    lives; who cannot be locked is alive. What no lock speaks for must also be mapped by nobody.
    """
    # To look at all processes takes seconds on a busy machine: what is new is so from here on.
    began = time.time()
    files: dict[str, list[Path]] = {}
    for path in folder.iterdir() if folder.is_dir() else ():
        if match := SEGMENT.fullmatch(path.name) or MUTEX.fullmatch(path.name):
            files.setdefault(match[1], []).append(path)
    mapped = _mapped_names(folder) if files else set()
    count = size = 0
    for name, paths in files.items():
        found = [(path, status) for path in paths if (status := _own_status(path))]
        if not found or min(_changed(status) for _, status in found) < since:
            continue
        # A file that was just made may not be locked or mapped yet.
        if max(_changed(status) for _, status in found) > began - 1.0:
            continue
        if name in mapped or any(_is_locked(path) for path in paths):
            continue
        for path, status in found:
            with contextlib.suppress(FileNotFoundError):
                path.unlink()
                count, size = count + 1, size + status.st_size
    return Removed(count, size)


def find_processes(mark: str) -> list[tuple[int, str]]:
    """Find the living processes of a run: pid and command line. Linux only, else none."""
    wanted = f"{MARK}={mark}".encode()
    found = []
    for folder in PROCESSES.glob("[0-9]*"):
        # It may end meanwhile, or be another user's.
        with contextlib.suppress(OSError):
            state = (folder / "stat").read_text().rpartition(")")[2].split()[0]
            if state == "Z" or wanted not in (folder / "environ").read_bytes().split(b"\0"):
                continue
            words = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            found.append((int(folder.name), words.strip()))
    return found


def end_processes(mark: str, within: float = 3.0) -> list[str]:
    """Wait for the processes of a run to end, then kill the others; give their command lines."""
    deadline = time.monotonic() + within
    while (left := find_processes(mark)) and time.monotonic() < deadline:
        time.sleep(0.05)
    for pid, _ in left:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return [words for _, words in left]


def _own_status(path: Path) -> os.stat_result | None:
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    return status if status.st_uid == os.getuid() else None


def _changed(status: os.stat_result) -> float:
    return max(status.st_mtime, status.st_ctime)


def _is_locked(path: Path) -> bool:
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except FileNotFoundError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(file)
    return False


def _mapped_names(folder: Path) -> set[str]:
    """Names of the segments and ports that some process has mapped."""
    names = set()
    for maps in PROCESSES.glob("[0-9]*/maps"):
        with contextlib.suppress(OSError):
            for line in maps.read_text(errors="replace").splitlines():
                _, _, name = line.partition(f" {folder}/")
                if match := SEGMENT.fullmatch(name.removesuffix(" (deleted)")):
                    names.add(match[1])
    return names


if __name__ == "__main__":
    removed = remove_dead_shared_memory()
    sys.stdout.write(f"{removed.files} files, {removed.size / 1e6:.1f} MB removed\n")
