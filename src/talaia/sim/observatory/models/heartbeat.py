"""A dome controller's own watchdog: without heartbeats it closes by itself. Pure: time is given."""

from __future__ import annotations

from talaia.sim.observatory.models.ticket import Ticket

__all__ = ["ControllerWatchdog"]


class ControllerWatchdog:
    """Off until the first heartbeat; after it has closed once, off until the next one.

    Attributes:
        limit_s: of silence (s, real time, however fast the simulation goes).

    """

    def __init__(self, limit_s: float = 10.0) -> None:
        """Be off."""
        self.limit_s = limit_s
        # Since the last heartbeat (s); none while it is off.
        self._silent_s: float | None = None

    @property
    def armed(self) -> bool:
        """Tell whether silence closes."""
        return self._silent_s is not None

    def hear_heartbeat(self) -> Ticket:
        """Take a heartbeat."""
        self._silent_s = 0.0
        return Ticket.done(f"closes by itself after {self.limit_s:g} s without another heartbeat")

    def step(self, seconds: float) -> bool:
        """Let real time pass; tell whether it is to be closed now."""
        if self._silent_s is None:
            return False
        self._silent_s += seconds
        if self._silent_s < self.limit_s:
            return False
        self._silent_s = None
        return True
