"""Command states on disk, and in memory for as long as the disk takes none."""

from __future__ import annotations

import contextlib
import logging
import os
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.persistence import write_whole
from talaia.wire.frames import CommandState

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["CommandJournal"]

log = logging.getLogger(__name__)
_line = msgspec.json.Decoder(CommandState)
_encode = msgspec.json.Encoder().encode
# Of what waits for a disk that takes nothing, the oldest go.
MOST_WAITING = 10_000


class CommandJournal:
    """Command states on disk, one JSON line each; a line cut short by a crash is ignored.

    All but `behind` block on the disk and come from one thread.

    Attributes:
        remembered: what an earlier run left.
        unread: why that cannot be known, if so; then nothing is written over it either.

    """

    def __init__(self, path: Path) -> None:
        """Read what is there."""
        self._path = path  # JSON lines; appended, and compacted at each start.
        self.remembered: list[CommandState] = []
        self.unread: OSError | None = None
        # By id: what the disk did not take; in the order in which it will be written.
        self._waiting: dict[str, CommandState] = {}
        try:
            lines = path.read_bytes().splitlines()
        except FileNotFoundError:
            # The first start.
            lines = []
        except OSError as error:
            lines, self.unread = [], error
        for line in filter(None, lines):
            try:
                self.remembered.append(_line.decode(line))
            # The power went while the line was written; what it said is told as unknown by the
            # book.
            except (msgspec.DecodeError, UnicodeError):
                log.warning("%s: a line was cut short; ignored", path)

    @property
    def behind(self) -> bool:
        """Whether something waits for the disk. May be asked from any thread."""
        return bool(self._waiting)

    def compact_journal(self, states: list[CommandState]) -> None:
        """Keep the newest state of each id only.

        Raises:
            OSError: not written; the journal is as it was.

        """
        self._check_read()
        try:
            write_whole(self._path, b"".join(_encode(state) + b"\n" for state in states))
        except OSError:
            with contextlib.suppress(OSError):
                # Half a new file takes room on a disk that has none.
                self._path.with_name(self._path.name + ".new").unlink(missing_ok=True)
            raise

    def write_state(self, state: CommandState, *, sure: bool) -> None:
        """Add a state; with ``sure`` it is on disk when this returns.

        Raises:
            OSError: not written; it waits in memory, and goes with the next.

        """
        # Taken out first: of one command the newest state is the last that is written.
        self._waiting.pop(state.id, None)
        # Waits before it is written: whatever fails below, it is not lost.
        self._waiting[state.id] = state
        while len(self._waiting) > MOST_WAITING:
            del self._waiting[next(iter(self._waiting))]
        self.write_waiting(sure=sure)

    def write_waiting(self, *, sure: bool = True) -> None:
        """Write what waits in memory; with nothing waiting, try whether the disk works.

        Raises:
            OSError: not written; it waits on.

        """
        self._check_read()
        lines = b"".join(_encode(state) + b"\n" for state in self._waiting.values())
        with self._path.open("ab") as file:
            # The leading line end closes a line that a failed write may have left open.
            # A blank line is skipped when read.
            file.write(b"\n" + lines if file.tell() else lines)
            file.flush()
            # fsync only where something hangs on it: it takes up to a second on an SD card.
            if sure:
                os.fsync(file.fileno())
        # Only after the write: an exception leaves all of it waiting.
        self._waiting.clear()

    def _check_read(self) -> None:
        if self.unread is not None:
            why = f"{self.unread.strerror}; what was done before cannot be read"
            raise OSError(self.unread.errno, why, str(self._path))
