"""A signal that any thread may emit and that is received on the event loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

__all__ = ["ThreadSafeSignal"]


class ThreadSafeSignal:
    """Made before those who receive it, so that nobody refers to a part that comes later."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        """Deliver on this event loop."""
        self._loop = loop
        self._receivers: list[Callable[[], None]] = []  # Called in the order they came.

    def connect(self, receiver: Callable[[], None]) -> None:
        """Call this on the event loop after each `emit` from here on."""
        self._receivers.append(receiver)

    def emit(self) -> None:
        """Tell all receivers, soon; from any thread."""
        # Later and on the loop, never within the caller, who may hold a lock.
        self._loop.call_soon_threadsafe(self._deliver_signal)

    def _deliver_signal(self) -> None:
        for receiver in self._receivers:
            receiver()
