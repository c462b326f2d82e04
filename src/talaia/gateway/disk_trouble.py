"""Says once that a file cannot be written, and once that it can be again."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.gateway.ports import ControlOutput

__all__ = ["DiskTrouble"]

log = logging.getLogger(__name__)


class DiskTrouble:
    """What the gateway's disk does not take now, by what is written. Event loop only."""

    def __init__(self, output: ControlOutput | None = None) -> None:
        """Start with a disk that works; without a ``output`` only the log hears of trouble."""
        self._output = output
        self._failing: set[str] = set()  # Names of what failed at its last write.

    def is_failing(self, what: str) -> bool:
        """Tell whether the last write of it failed."""
        return what in self._failing

    def record_failure(self, what: str, error: OSError) -> None:
        """Tell of a write that failed; ``what`` names what was written, as *journal*."""
        # Told once: a full disk fails with every write.
        if what in self._failing:
            return
        self._failing.add(what)
        message = f"the gateway's {what} cannot be written: {error}"
        log.warning("%s", message)
        if self._output is not None:
            self._output.record_event("disk_failed", "", message, "", good=False)

    def record_success(self, what: str) -> None:
        """Tell of a write that came through."""
        # Most writes: nothing was wrong, so there is nothing to say.
        if what not in self._failing:
            return
        self._failing.discard(what)
        message = f"the gateway's {what} is written again"
        log.warning("%s", message)
        if self._output is not None:
            self._output.record_event("disk_recovered", "", message, "", good=True)
