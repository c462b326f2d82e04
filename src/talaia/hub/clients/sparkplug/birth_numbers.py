"""Numbers of connections, over restarts: a death of an earlier one is told from one of this."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["BirthNumbers"]

_LOG = logging.getLogger(__name__)
_NUMBERS = 256


class BirthNumbers:
    """A file with the last number that was given."""

    def __init__(self, path: Path) -> None:
        """Keep it in the file ``path``."""
        self._path = path
        try:
            self._last = int(path.read_text(encoding="ascii")) % _NUMBERS
        except (OSError, ValueError):
            # The first of all is 0.
            self._last = _NUMBERS - 1

    def next_number(self) -> int:
        """Give the number of a connection that begins."""
        self._last = (self._last + 1) % _NUMBERS
        try:
            self._path.write_text(f"{self._last}\n", encoding="ascii")
        except OSError as error:
            _LOG.warning("%s cannot be written: %s", self._path, error)
        return self._last
