"""A wheel with five filters. Pure: time is given."""

from __future__ import annotations

from talaia.sim.observatory.models.optics import FILTERS
from talaia.sim.observatory.models.ticket import Ticket

__all__ = ["FilterWheel"]

# From a place to the next one (s).
TURN_S = 1.5


class FilterWheel:
    """The wheel's controller.

    Attributes:
        position: of the filter in the light, counted from 1; 0 while the wheel turns.
        stuck: a fault: it never arrives.

    """

    def __init__(self) -> None:
        """Start at the first filter."""
        self.position = 1
        self.stuck = False
        self._goal, self._left = 1, 0.0
        self._ticket = Ticket.done("")

    @property
    def name(self) -> str:
        """Give the filter's name; empty while the wheel turns."""
        return FILTERS[self.position - 1].name if self.position else ""

    def goto(self, position: float) -> Ticket:
        """Turn to a filter, counted from 1."""
        if position not in range(1, len(FILTERS) + 1):
            return Ticket.refused(f"filter {position:g}: expected 1 to {len(FILTERS)}")
        self._ticket.end_with("another command came", good=False)
        if position == self.position:
            return Ticket.done(f"the filter is {self.name}")
        # The shorter way round.
        apart = abs(int(position) - (self.position or self._goal))
        self._left = TURN_S * max(1, min(apart, len(FILTERS) - apart))
        self.position, self._goal, self._ticket = 0, int(position), Ticket()
        return self._ticket

    def select(self, filter: str) -> Ticket:  # noqa: A002 - the name of the service's argument
        """Turn to a filter by its name."""
        names = [glass.name for glass in FILTERS]
        if filter not in names:
            return Ticket.refused(f"filter {filter!r}: expected one of {', '.join(names)}")
        return self.goto(names.index(filter) + 1)

    def stop(self) -> Ticket:
        """Give up turning; it stays between two filters."""
        self._ticket.end_with("the wheel was stopped", good=False)
        return Ticket.done("the wheel is stopped")

    def step(self, seconds: float) -> None:
        """Let time pass."""
        if self._ticket.ended or self.stuck:
            return
        self._left -= seconds
        if self._left <= 0.0:
            self.position = self._goal
            self._ticket.end_with(f"the filter is {self.name}", good=True)
