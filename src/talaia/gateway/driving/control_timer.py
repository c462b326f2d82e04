"""Who keeps the time of what must be repeated: driving's ticks, zeros, and the ends of leases."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import asyncio

    from talaia.clock import Clock
    from talaia.gateway.driving.drive_service import DriveService

__all__ = ["ControlTimer"]


class ControlTimer:
    """Calls `DriveService.step` when it is due. One timer; none while all rests."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, clock: Clock, control: DriveService
    ) -> None:
        """Start at rest; `touch` after anything that may have changed what is due."""
        self._loop = loop
        self._clock = clock
        self._control = control
        # What wakes us next; None while nothing is due.
        self._timer: asyncio.TimerHandle | None = None
        self._due_ns = 0  # When `_timer` rings (monotonic ns); valid only beside a timer.
        # Set once by `close`, so that a late `touch` sets no timer on a loop that ends.
        self._closed = False

    def touch(self) -> None:
        """Set the timer anew if what is due has changed."""
        if self._closed:
            return
        due = self._control.due_ns()
        if self._timer is not None:
            if due == self._due_ns:
                return
            self._timer.cancel()
            self._timer = None
        # A due time in the past rings on the loop's next turn, never inside this call: `touch` is
        # called from within what `step` itself does.
        if due is not None:
            self._due_ns = due
            wait_s = max(0.0, (due - self._clock.monotonic_ns()) / 1e9)
            self._timer = self._loop.call_later(wait_s, self._ring)

    def _ring(self) -> None:
        # A rung timer is spent; left here, `touch` would take it for one that still runs.
        self._timer = None
        try:
            self._control.step()
        finally:
            # Also after an error: an exception in one step must not end zeros and lease ends for
            # good.
            self.touch()

    def close(self) -> None:
        """Ring no more."""
        self._closed = True
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
