"""A clamshell: two shells that fold down to either side, and no azimuth. Pure: time is given.

Each shell has a motor, an encoder and an end switch of its own, so one can be stuck, or its switch
can lie, while the other goes on. The controller drives a shell until its own end switch says
*closed*, as a real one does: a switch that lies leaves its shell wherever it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.enclosure import EnclosureMechanics, SimulatedEnclosure

if TYPE_CHECKING:
    from talaia.sim.observatory.models.ticket import Ticket

__all__ = ["SHELLS", "Clamshell", "Shell"]

SHELLS = ("west", "east")
# A motor that is blocked for so long is switched off (s).
STALL_S = 2.0


class Shell:
    """One half of the roof.

    Attributes:
        name: the side it folds down to.
        position: 0 closed to 1 open; what its encoder says, too.
        stuck: it does not move whatever is asked.
        lying: what its end switch says in place of the truth (*closed*, *opened*), if anything.

    """

    def __init__(self, name: str) -> None:
        """Start closed."""
        self.name = name
        self.position = 0.0
        self.stuck = False
        self.lying = ""
        # For how long its motor has been on without moving it (s).
        self._stalled_s = 0.0

    @property
    def closed(self) -> bool:
        """Tell what its end switch says."""
        return self.lying == "closed" if self.lying else self.position <= 0.0

    def start_motor(self) -> None:
        """Switch its motor on."""
        self._stalled_s = 0.0

    def has_arrived(self, wanted: float) -> bool:
        """Tell whether it is where it is wanted; closed is what its end switch says."""
        return self.closed if wanted == 0.0 else self.position >= 1.0

    def move_step(self, wanted: float, *, reach: float, seconds: float) -> bool:
        """Drive it for a step, ``reach`` at most; tell whether its motor is switched off."""
        if self.has_arrived(wanted):
            return True
        before = self.position
        self.position = min(1.0, max(0.0, before + max(-reach, min(reach, wanted - before))))
        # A motor that draws current and does not turn is switched off by its controller.
        self._stalled_s = 0.0 if self.position != before else self._stalled_s + seconds
        return self._stalled_s >= STALL_S or self.has_arrived(wanted)


class Clamshell(SimulatedEnclosure):
    """The hardware and its controller; see `SimulatedEnclosure`.

    ``position`` is that of the shell that is open furthest, so that it is 0 only when all are
    closed.

    Attributes:
        shells: by name, west first.

    """

    def __init__(self) -> None:
        """Start closed."""
        self.shells = {name: Shell(name) for name in SHELLS}
        super().__init__(EnclosureMechanics(can_rotate=False, segments=SHELLS))

    @property
    def closed(self) -> bool:
        """Tell what the controller makes of both end switches."""
        if self.lying:
            return self.lying == "closed"
        return all(shell.closed for shell in self.shells.values())

    @property
    def opened(self) -> bool:
        """Tell whether both shells are down."""
        if self.lying:
            return self.lying == "opened"
        return all(shell.position >= 1.0 for shell in self.shells.values())

    def _begin_move(self, wanted: float, already: str) -> Ticket:
        for shell in self.shells.values():
            shell.start_motor()
        return super()._begin_move(wanted, already)

    def _step_shutter(self, wanted: float, seconds: float) -> None:
        done = []
        for shell in self.shells.values():
            # All of it is stuck, or this shell alone.
            reach = 0.0 if self.stuck or shell.stuck else seconds / self.can.shutter_s
            done.append(shell.move_step(wanted, reach=reach, seconds=seconds))
        self.position = max(shell.position for shell in self.shells.values())
        if not all(done):
            return
        self.wanted = None
        # A shell that has stalled has also ended; whether it arrived is asked now.
        failed = [shell.name for shell in self.shells.values() if not shell.has_arrived(wanted)]
        if failed:
            self._error = True
            shells = " and ".join(failed)
            self._shutter.end_with(f"stuck: {shells}; no end switch was reached", good=False)
            return
        self._shutter.end_with("the dome is opened" if wanted else "the dome is closed", good=True)
