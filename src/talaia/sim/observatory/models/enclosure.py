"""A dome that turns, with a shutter and perhaps a flap. Pure: time is given.

What it does and what its sensors say are kept apart, so that a sensor can fail or lie.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from talaia.sim.observatory.models.ticket import Ticket

__all__ = ["STATES", "EnclosureMechanics", "SimulatedEnclosure"]

# The order is that of the number which is published beside the word.
STATES = ("closed", "opened", "opening", "closing", "stopped", "error")


class EnclosureMechanics(NamedTuple):
    """What an enclosure can do: a slit dome turns, a clamshell does not.

    Attributes:
        shutter_s: from closed to open (s).
        flap_s: the same for the flap (s).
        rate: of turning (°/s).
        segments: names of the parts it opens in, where each has an end switch of its own.

    """

    can_rotate: bool = True
    has_flap: bool = False
    shutter_s: float = 12.0
    flap_s: float = 5.0
    rate: float = 6.0
    segments: tuple[str, ...] = ()


class SimulatedEnclosure:
    """The hardware and its controller.

    Attributes:
        position: of the shutter, 0 closed to 1 open.
        flap: the same.
        azimuth: of the slit (°).
        local: somebody on site has taken the switch; nothing moves from afar.
        stuck: the shutter does not move whatever is asked.
        lost: the encoder is lost; the azimuth is unknown and turning never ends well.
        lying: what the limit switches say in place of the truth, if anything.
        wanted: where the shutter goes, if it moves.

    """

    PARK_AZIMUTH = 0.0

    def __init__(self, capabilities: EnclosureMechanics | None = None) -> None:
        """Start closed and at its park position."""
        self.can = capabilities or EnclosureMechanics()
        self.position = 0.0
        self.flap = 0.0
        self.azimuth = self.PARK_AZIMUTH
        self.local = False
        self.stuck = False
        self.lost = False
        self.lying = ""
        self.wanted: float | None = None
        # Azimuth that it turns to (°); none while it does not turn.
        self._to: float | None = None
        # The requests under way, of the shutter and of the rotation.
        self._shutter = Ticket.done("")
        self._turn = Ticket.done("")
        # For how long the shutter did not move although it should (s).
        self._stalled = 0.0
        self._stopped = False
        # The shutter was blocked; the next command clears it.
        self._error = False

    # ── what its sensors say ──

    @property
    def closed(self) -> bool:
        """Tell what the closed switch says, the flap's included."""
        if self.lying:
            return self.lying == "closed"
        return self.position <= 0.0 and self.flap <= 0.0

    @property
    def opened(self) -> bool:
        """Tell what the open switch says."""
        if self.lying:
            return self.lying == "opened"
        return self.position >= 1.0

    @property
    def state(self) -> str:
        """Give one of `STATES`."""
        if self._error:
            return "error"
        if self.wanted is not None:
            # 1 opens, 0 closes.
            return "opening" if self.wanted else "closing"
        if self.closed:
            return "closed"
        return "opened" if self.opened else "stopped"

    @property
    def truth(self) -> str:
        """Give what is so, whatever its sensors say: closed, opening, open, closing or partly."""
        if self.wanted is not None and not self.stuck:
            if self.wanted and self.position < 1.0:
                return "opening"
            if not self.wanted and (self.position > 0.0 or self.flap > 0.0):
                return "closing"
        if self.position <= 0.0 and self.flap <= 0.0:
            return "closed"
        return "open" if self.position >= 1.0 else "partly"

    @property
    def word(self) -> str:
        """Give the state in the founding design's words: opened, closed, moving, or what it is."""
        return "moving" if self.wanted is not None or self.turning else self.state

    @property
    def turning(self) -> bool:
        """Tell whether it turns."""
        return self._to is not None

    @property
    def shown_azimuth(self) -> float:
        """Give what the encoder says; not a number when it is lost."""
        return math.nan if self.lost else self.azimuth

    # ── what may be asked ──

    def open(self) -> Ticket:
        """Open shutter (and flap)."""
        return self._begin_move(1.0, "the dome is opened")

    def close(self) -> Ticket:
        """Close shutter and flap."""
        return self._begin_move(0.0, "the dome is closed")

    def _begin_move(self, wanted: float, already: str) -> Ticket:
        if self.local:
            return Ticket.refused("the dome is under local control; nothing moves from afar")
        self._shutter.end_with("another command came", good=False)
        self._error = self._stopped = False
        self._stalled = 0.0
        # Asked of the sensor, as a real controller does: one that lies makes this wrong.
        if self.closed if wanted == 0.0 else self.opened:
            self.wanted = None
            return Ticket.done(already)
        self.wanted = wanted
        self._shutter = Ticket()
        return self._shutter

    def turn_to(self, azimuth: float) -> Ticket:
        """Turn the slit to an azimuth (°, 0 to 360)."""
        if not self.can.can_rotate:
            return Ticket.refused("this enclosure does not turn")
        if not 0.0 <= azimuth <= 360.0:
            return Ticket.refused(f"azimuth {azimuth:g}: expected 0 to 360 °")
        if self.local:
            return Ticket.refused("the dome is under local control; nothing moves from afar")
        if self.lost:
            return Ticket.refused("the encoder is lost; the dome does not know where it is")
        self._turn.end_with("another command came", good=False)
        self._to = azimuth % 360.0
        self._turn = Ticket()
        return self._turn

    def park(self) -> Ticket:
        """Turn to the park position. The shutter stays as it is: parked is not closed."""
        return self.turn_to(self.PARK_AZIMUTH)

    def stop(self) -> Ticket:
        """Stop all motion."""
        moving = self.wanted is not None or self._to is not None
        self.wanted = self._to = None
        for ticket in (self._shutter, self._turn):
            ticket.end_with("the dome was stopped", good=False)
        return Ticket.done("the dome is stopped" if moving else "the dome was not moving")

    # ── time ──

    def step(self, seconds: float) -> None:
        """Let time pass."""
        # Somebody has turned the switch on site while it moved.
        if self.local and (self.wanted is not None or self._to is not None):
            self.stop()
        if self.wanted is not None:
            self._step_shutter(self.wanted, seconds)
        if self._to is not None:
            self._step_turn(self._to, seconds)

    def _step_shutter(self, wanted: float, seconds: float) -> None:
        if self.stuck:
            # A motor that draws current and does not turn is switched off by its controller.
            self._stalled += seconds
            if self._stalled >= 2.0:
                self.wanted, self._error = None, True
                self._shutter.end_with("the shutter is stuck", good=False)
            return
        shutter, flap = seconds / self.can.shutter_s, seconds / self.can.flap_s
        # The flap opens last and closes first.
        if not self.can.has_flap or (wanted and self.position < 1.0):
            self.position = _step_toward(self.position, wanted, shutter)
        elif wanted or self.flap > 0.0:
            self.flap = _step_toward(self.flap, wanted, flap)
        else:
            self.position = _step_toward(self.position, wanted, shutter)
        if self.position == wanted and (not self.can.has_flap or self.flap == wanted):
            self.wanted = None
            self._shutter.end_with(
                "the dome is opened" if wanted else "the dome is closed", good=True
            )

    def _step_turn(self, to: float, seconds: float) -> None:
        if self.lost:
            self._to = None
            self._turn.end_with("the encoder was lost; the dome has stopped", good=False)
            return
        # The shorter way round, -180 to 180°.
        way = (to - self.azimuth + 180.0) % 360.0 - 180.0
        reach = self.can.rate * seconds
        if abs(way) <= reach:
            self.azimuth, self._to = to, None
            self._turn.end_with(f"the dome is at {to:.1f} °", good=True)
        else:
            self.azimuth = (self.azimuth + math.copysign(reach, way)) % 360.0


def _step_toward(now: float, wanted: float, reach: float) -> float:
    return min(wanted, now + reach) if wanted > now else max(wanted, now - reach)
