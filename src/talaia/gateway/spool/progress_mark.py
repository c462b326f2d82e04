"""How far a run of the gateway came, so that the next one can tell what is missing.

A few bytes in one place, written over again with each batch. They are not forced to disk: they
survive this process, which is what they are for; after a power cut they may be some seconds old,
and what is told as missing then begins so much earlier.
"""

from __future__ import annotations

import logging
import os
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["MarkFile", "ProgressMark", "machine_run"]

log = logging.getLogger(__name__)
# One block of any file system: it is taken once, and never needs room again.
_SIZE = 512


class ProgressMark(msgspec.Struct, frozen=True):
    """How far a run came.

    Attributes:
        boot: its name.
        end: one past the last sample that was given to the spool.
        acked: all below this are stored at the hub.
        began_us: when it began (µs, UTC).
        heard_us: up to when all that was heard was given to the spool (µs, UTC).
        mono_s: the same moment on the machine's monotonic clock.
        deaf_us: since when not all channels may have been heard yet; 0: they have.
        machine: names the run of the machine to which that clock belongs; empty: not known.

    """

    boot: str = ""
    end: int = 0
    acked: int = 0
    began_us: int = 0
    heard_us: int = 0
    mono_s: float = 0.0
    deaf_us: int = 0
    machine: str = ""


class MarkFile:
    """Where it is kept."""

    def __init__(self, path: Path) -> None:
        """Read what the run before left; `former` is none where there was none."""
        self._path = path
        self._file = -1  # Negative until the first mark; then open for the whole run.
        self.former: ProgressMark | None = None  # Read once, before this run writes over it.
        try:
            self.former = msgspec.json.decode(path.read_bytes(), type=ProgressMark)
        # No run before this one, or one whose data folder was removed.
        except FileNotFoundError:
            pass
        # Not fatal: without a mark it is only not known what is missing.
        except (OSError, msgspec.DecodeError) as error:
            log.warning("%s cannot be read: %s", path, error)

    def write_mark(self, mark: ProgressMark) -> None:
        """Write it in its place; where the disk takes nothing, the old one stays."""
        try:
            if self._file < 0:
                self._file = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600)
            # Filled up with spaces, which JSON permits: a shorter mark leaves no rest of a longer
            # one.
            os.pwrite(self._file, msgspec.json.encode(mark).ljust(_SIZE), 0)
        # Comes with each batch while the disk is full; the next one is tried anyway.
        except OSError as error:
            log.debug("%s: %s", self._path, error)

    def close(self) -> None:
        """Let go of the file."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def machine_run() -> str:
    """Name the run of this machine, whose monotonic clock all its processes share."""
    # Made anew by the kernel at each start of the machine.
    try:
        with open("/proc/sys/kernel/random/boot_id", encoding="ascii") as file:
            return file.read().strip()
    except OSError:
        # Not Linux, or hidden by a container: then the clocks of two runs are not compared.
        return ""
