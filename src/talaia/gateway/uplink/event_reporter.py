"""Tells the hub what is worth writing down, from any thread."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire.frames import Event

if TYPE_CHECKING:
    import asyncio

    from talaia.clock import Clock
    from talaia.gateway.uplink.send_lanes import SendLanes

__all__ = ["EventReporter"]


class EventReporter:
    """An `EventSink`."""

    def __init__(self, *, loop: asyncio.AbstractEventLoop, clock: Clock, lanes: SendLanes) -> None:
        """Queue events in the lanes, on their event loop."""
        self._loop = loop  # Where the lanes live.
        self._clock = clock  # UTC for the record.
        self._lanes = lanes  # Results and events stay in them over a lost link.

    def report_event(
        self, kind: str, message: str, *, device: str = "", who: str = "", good: bool = False
    ) -> None:
        """See `EventSink`."""
        event = Event(
            kind=kind,
            device=device,
            # The wire's limit for this text.
            message=message[:2000],
            who=who,
            time_us=self._clock.wall_ns() // 1000,
            good=good,
        )
        # From any thread: the lanes belong to the event loop alone.
        self._loop.call_soon_threadsafe(self._lanes.send, event)
