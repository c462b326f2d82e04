"""A motor that moves the mirror, with a thermometer at the tube. Pure: time is given.

Its screw has play: after a turn of direction the mirror stands still for some steps, as it does in
every such telescope. Who approaches a position always from the same side never sees it.
"""

from __future__ import annotations

import math

from talaia.sim.observatory.models.ticket import Ticket

__all__ = ["Focuser"]

# Steps of the whole way, steps a second, and steps of play.
MOST, RATE, PLAY = 50_000, 400.0, 40.0
# The tube follows the air with this time constant (s).
TUBE_S = 900.0


class Focuser:
    """The focuser's controller.

    Attributes:
        position: of the motor (steps).
        mirror: where the mirror really stands (steps of the motor).
        moving: it moves.
        celsius: of the tube.
        stuck: a fault: the motor does not turn.

    """

    def __init__(self, celsius: float = 12.0) -> None:
        """Start where the last night ended."""
        self.position = self.mirror = 25000.0
        self.celsius = self._air = celsius
        self.stuck = False
        self._goal = self.position
        self._ticket = Ticket.done("")
        self._known_air = False

    @property
    def moving(self) -> bool:
        """Tell whether it moves."""
        return not self._ticket.ended

    def goto(self, position: float) -> Ticket:
        """Move to a position (steps)."""
        if not 0 <= position <= MOST:
            return Ticket.refused(f"position {position:g}: expected 0 to {MOST}")
        self._ticket.end_with("another command came", good=False)
        self._goal, self._ticket = float(round(position)), Ticket()
        return self._ticket

    def move_by(self, steps: float) -> Ticket:
        """Move by so many steps, to the outside when positive."""
        return self.goto(self.position + steps)

    def stop(self) -> Ticket:
        """Stand."""
        self._goal = self.position
        self._ticket.end_with("the focuser was stopped", good=False)
        return Ticket.done("the focuser is stopped")

    def feel_air(self, celsius: float) -> None:
        """Hear how warm the air is; the tube begins as warm as the first that is heard."""
        if not self._known_air and math.isfinite(celsius):
            self._known_air, self.celsius = True, celsius
        self._air = celsius

    def step(self, seconds: float) -> None:
        """Let time pass."""
        if math.isfinite(self._air):
            self.celsius += (self._air - self.celsius) * (1.0 - math.exp(-seconds / TUBE_S))
        if self._ticket.ended or self.stuck:
            return
        way = self._goal - self.position
        self.position += math.copysign(min(abs(way), RATE * seconds), way)
        # The mirror is dragged along once the play is used up.
        self.mirror = min(max(self.mirror, self.position - PLAY), self.position)
        if self.position == self._goal:
            self._ticket.end_with(f"the focuser is at {self.position:.0f}", good=True)
