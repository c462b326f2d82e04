"""Who keeps the time of what must be repeated: driving's ticks, zeros, and the ends of leases."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import asyncio

    from talaia.clock import Clock

__all__ = ["ControlTimer"]


class TimedControl(Protocol):
    """Whoever has something to do at a time: driving, and twins with it."""

    def due_ns(self) -> int | None:
        """Give when `run_due` wants to be called next (monotonic); none while all rests."""
        ...

    def run_due(self) -> None:
        """Do what is due now."""
        ...


class ControlTimer:
    """Calls `TimedControl.run_due` when it is due. One timer; none while all rests."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, clock: Clock, control: TimedControl
    ) -> None:
        """Start at rest; `reset_timer` after anything that may have changed what is due."""
        self._loop = loop
        self._clock = clock
        self._control = control
        # What wakes us next; None while nothing is due.
        self._timer: asyncio.TimerHandle | None = None
        self._due_ns = 0  # When `_timer` rings (monotonic ns); valid only beside a timer.
        # Set once by `close`, so that a late `reset_timer` sets no timer on a loop that ends.
        self._closed = False

    def reset_timer(self) -> None:
        """Set the timer anew if what is due has changed."""
        if self._closed:
            return
        due = self._control.due_ns()
        if self._timer is not None:
            if due == self._due_ns:
                return
            self._timer.cancel()
            self._timer = None
        # A due time in the past rings on the loop's next turn, never inside this call:
        # `reset_timer` is called from within what `run_due` itself does.
        if due is not None:
            self._due_ns = due
            wait_s = max(0.0, (due - self._clock.monotonic_ns()) / 1e9)
            self._timer = self._loop.call_later(wait_s, self._handle_timer)

    def _handle_timer(self) -> None:
        # A rung timer is spent; left here, `reset_timer` would take it for one that still runs.
        self._timer = None
        try:
            self._control.run_due()
        finally:
            # Also after an error: an exception in one step must not end zeros and lease ends for
            # good.
            self.reset_timer()

    def close(self) -> None:
        """Ring no more."""
        self._closed = True
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
