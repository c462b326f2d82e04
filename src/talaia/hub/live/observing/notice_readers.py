"""Who has read a file of the folder of notices, where several hubs read it, each for its sites.

Blocks: called in a thread.
"""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

__all__ = ["NoticeReaders", "name_content"]

# Inside the folder of notices: a folder for each reader, with a mark for each file.
_MARKS = ".read"


class NoticeReaders:
    """Marks what was read, so that a file is moved away once all have read it."""

    def __init__(self, own: str, every: Sequence[str]) -> None:
        """Be the reader ``own`` of ``every``; the first of them moves files."""
        self._own, self._every = own, tuple(every)

    def has_read(self, path: Path) -> bool:
        """Tell whether this reader has read a file."""
        return self._is_marked(path, self._own)

    def mark_read(self, path: Path, content: str) -> None:
        """Write down that this reader has read what a file was before (`name_content`).

        Raises:
            OSError: it cannot be written; the file is read once more.

        """
        mark = self._mark_of(path, self._own)
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.write_text(content, "ascii")

    def may_move(self, path: Path) -> bool:
        """Tell whether all have read a file, and it is this one who moves it."""
        if self._own != self._every[0]:
            return False
        return all(self._is_marked(path, reader) for reader in self._every)

    def forget_file(self, path: Path) -> None:
        """Remove the marks of a file that was moved."""
        for reader in self._every:
            with contextlib.suppress(OSError):
                self._mark_of(path, reader).unlink(missing_ok=True)

    def _is_marked(self, path: Path, reader: str) -> bool:
        try:
            return self._mark_of(path, reader).read_text("ascii") == name_content(path)
        except FileNotFoundError:
            return False

    @staticmethod
    def _mark_of(path: Path, reader: str) -> Path:
        return path.parent / _MARKS / reader / path.name


def name_content(path: Path) -> str:
    """Tell a file from another one of its name.

    Raises:
        OSError: it is gone.

    """
    found = path.stat()
    return f"{found.st_mtime_ns} {found.st_size}"
