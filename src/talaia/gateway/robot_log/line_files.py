"""Files of the lines of a robot's log that the hub does not have yet. Blocking."""

from __future__ import annotations

import logging
import re
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.persistence import append_lines
from talaia.gateway.robot_log.line_queue import SEGMENT_BYTES, WaitingLine
from talaia.wire.frames import LogLine  # noqa: TC001 - msgspec reads it

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from pathlib import Path

__all__ = ["LineFiles"]

log = logging.getLogger(__name__)
_NAME = re.compile(r"([0-9A-Za-z-]{1,60})-(\d{12})\.lines\Z")
# A file is cut off by its size; beyond this it is none of ours. JSON may write a letter as six.
_LARGEST = 16 * SEGMENT_BYTES


class _Entry(msgspec.Struct, frozen=True):
    """A line in a file."""

    number: int
    size: int
    line: LogLine


_DECODER = msgspec.json.Decoder(_Entry)


class LineFiles:
    """A folder with one file for some hundred lines, each appended to and then removed whole."""

    def __init__(self, folder: Path) -> None:
        """Keep files in ``folder``; it is made when there is something to keep."""
        self._folder = folder

    def read_left(self) -> list[WaitingLine]:
        """Read what former runs left, in order; what cannot be read is logged and left out."""
        found: list[WaitingLine] = []
        # Names of runs sort by time.
        for path in sorted(self._folder.glob("*.lines")):
            name = _NAME.match(path.name)
            try:
                if name is None or path.stat().st_size > _LARGEST:
                    continue
                lines = path.read_bytes().splitlines()
            except OSError as error:
                log.warning("%s cannot be read: %s", path, error)
                continue
            for line in filter(None, lines):
                try:
                    entry = _DECODER.decode(line)
                # A power cut breaks off the last line at the most.
                except (msgspec.MsgspecError, UnicodeError):
                    log.warning("%s: a line of the robot's log is damaged", path)
                    continue
                found.append(
                    WaitingLine(name[1], entry.number, int(name[2]), entry.size, entry.line)
                )
        return found

    def append(self, lines: Sequence[WaitingLine]) -> None:
        """Write lines, forced to disk.

        Raises:
            OSError: the disk does not take them.

        """
        by_file: dict[tuple[str, int], list[bytes]] = {}
        for one in lines:
            entry = msgspec.json.encode(_Entry(one.number, one.size, one.line))
            by_file.setdefault((one.boot, one.segment), []).append(entry)
        if by_file:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        for (boot, segment), entries in by_file.items():
            append_lines(self._path(boot, segment), b"\n".join(entries) + b"\n")

    def remove_others(self, needed: Collection[tuple[str, int]]) -> None:
        """Remove all files but these.

        Raises:
            OSError: the disk does not let them go.

        """
        paths = {self._path(boot, segment) for boot, segment in needed}
        for path in self._folder.glob("*.lines"):
            if path not in paths:
                path.unlink(missing_ok=True)

    def _path(self, boot: str, segment: int) -> Path:
        return self._folder / f"{boot}-{segment:012d}.lines"
