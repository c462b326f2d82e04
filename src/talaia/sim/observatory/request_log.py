"""What an observatory was asked and how it ended, one JSON object a line."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["RequestLog"]


class RequestLog:
    """A file that grows, or nothing."""

    def __init__(self, path: Path | None) -> None:
        """Open the file; more follows what it holds."""
        self._file = None if path is None else path.open("a", encoding="utf-8")

    def write_entry(
        self, device: str, asked: str, phase: str, said: str = "", **more: object
    ) -> None:
        """Write one thing down: ``phase`` is asked, done, refused or fault."""
        if self._file is None:
            return
        line = {
            # One clock for all processes of the machine, and none that is ever set.
            "t": time.monotonic_ns(),
            "wall": time.time_ns(),
            "device": device,
            "asked": asked,
            "phase": phase,
            "said": said,
            **more,
        }
        self._file.write(json.dumps(line) + "\n")
        # Others read the file while it grows.
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
