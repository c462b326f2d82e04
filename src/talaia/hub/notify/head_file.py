"""The file of signed heads, read piece by piece, and notes of how far it was sent."""

from __future__ import annotations

import contextlib
import os
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["HeadPiece", "read_head_piece", "write_note"]


class HeadPiece(NamedTuple):
    """Whole lines of the file, from byte ``start`` to byte ``end``."""

    start: int
    end: int
    text: str


def read_head_piece(path: Path, start: int, most: int) -> HeadPiece | None:
    """Read whole lines from a byte on, of at most so many bytes; None where there is none."""
    with contextlib.suppress(FileNotFoundError), path.open("rb") as file:
        # Shorter than it was: of a restored backup, so all of it is new.
        if file.seek(0, os.SEEK_END) < start:
            start = 0
        file.seek(start)
        said = file.read(most)
        # The last line may be just being written.
        whole = said[: said.rfind(b"\n") + 1]
        if whole:
            return HeadPiece(start, start + len(whole), whole.decode("utf-8", "replace"))
    return None


def write_note(path: Path, note: bytes) -> None:
    """Write a small file whole: after a power cut there is the old one or the new one."""
    fresh = path.with_name(f"{path.name}.new")
    with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
        file.write(note)
        file.flush()
        os.fsync(file.fileno())
    fresh.replace(path)
