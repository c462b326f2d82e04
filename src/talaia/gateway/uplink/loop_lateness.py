"""By how much the event loop is late while pictures are made. On the loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from talaia.clock import Clock

__all__ = ["LoopLateness"]

# So long after a picture it is looked at (s): not in step with pictures.
_AFTER_S = 0.02


class LoopLateness:
    """Looks once between two pictures, and not at all while there are none."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        clock: Clock,
        tell: Callable[[int, int], None],
    ) -> None:
        """Tell ``tell`` each time by how much it was late, and when that was (monotonic; µs)."""
        self._loop, self._clock, self._tell = loop, clock, tell
        self._is_due = False  # Something is due, by which it is found.

    def note_picture(self) -> None:
        """Look soon: a picture was made."""
        if not self._is_due:
            self._is_due = True
            due_s = self._loop.time() + _AFTER_S
            self._loop.call_at(due_s, self._measure_lateness, due_s)

    def _measure_lateness(self, due_s: float) -> None:
        self._is_due = False
        late_us = round((self._loop.time() - due_s) * 1e6)
        self._tell(late_us, self._clock.monotonic_ns() // 1000)
