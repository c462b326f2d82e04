"""Simulated controllers of the roof: a dome with a slit, and a clamshell."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models import enclosure
from talaia.sim.observatory.models.heartbeat import ControllerWatchdog
from talaia.sim.observatory.models.power import OUTLETS
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Ask, Server

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.sim.observatory.models.clamshell import Clamshell
    from talaia.sim.observatory.models.enclosure import SimulatedEnclosure
    from talaia.sim.observatory.servers.base import Value

__all__ = ["ClamshellServer", "DomeServer"]


class DomeServer(Server):
    """The roof's controller: its shutter, and rotation where it turns."""

    name = "dome"
    outlet = OUTLETS.index("Dome") + 1

    def __init__(self, model: SimulatedEnclosure) -> None:
        """Offer what a dome does."""
        super().__init__()
        self.model = model
        self.watchdog = ControllerWatchdog()
        # Wall time of the last step (s); none before the first.
        self._stepped_s: float | None = None
        self.triggers = {
            "status": lambda: Ticket.done(model.word),
            "open": model.open,
            "close": model.close,
            "stop": model.stop,
            # The first one arms it: without a gateway that beats it never closes by itself.
            "heartbeat": self.watchdog.hear_heartbeat,
        }
        if model.can.can_rotate:
            self.triggers["park"] = model.park
            self.asks = {"goto": Ask({"azimuth": 0.0}, model.turn_to)}

    def lose_power(self) -> None:
        """Stand wherever it is."""
        self.model.stop()

    @property
    def truth(self) -> str:
        """Give where shutter and flap are."""
        return self.model.truth

    def topic_values(self) -> Mapping[str, Value]:
        """Give its sensors."""
        dome = self.model
        values: dict[str, Value] = {
            "status": dome.word,
            "state": enclosure.STATES.index(dome.state),
            "closed": dome.closed,
            "opened": dome.opened,
            "position": round(dome.position * 100.0, 1),
            "local": dome.local,
        }
        if dome.can.can_rotate:
            values |= {"azimuth": dome.shown_azimuth, "turning": dome.turning}
        return values

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass. Heartbeats come in real time, whatever the simulation's speed."""
        before, self._stepped_s = self._stepped_s, unix_s
        # A clock that was set, or a machine that slept, is no silence.
        real_s = 0.0 if before is None else min(1.0, max(0.0, unix_s - before))
        if self.watchdog.step(real_s):
            self.own_acts.append(("close", self.model.close()))
        self.model.step(seconds)

    def inject_fault(self, word: str) -> str:
        """See `Server.inject_fault`: stuck, encoder, lying closed, lying opened, local."""
        dome = self.model
        if word == "stuck":
            dome.stuck = True
        elif word == "encoder" and dome.can.can_rotate:
            dome.lost = True
        elif word in ("lying closed", "lying opened"):
            dome.lying = word.split()[1]
        elif word == "local":
            dome.local = True
        else:
            if word == "ok":
                dome.stuck = dome.lost = dome.local = False
                dome.lying = ""
            return super().inject_fault(word)
        return ""


class ClamshellServer(DomeServer):
    """The controller of a clamshell: an end switch and an encoder for each shell, no azimuth."""

    model: Clamshell

    def __init__(self, model: Clamshell) -> None:
        """Offer what a clamshell does."""
        super().__init__(model)

    def topic_values(self) -> Mapping[str, Value]:
        """Give its sensors, then those of each shell."""
        values = dict(super().topic_values())
        for name, shell in self.model.shells.items():
            values[f"{name}_closed"] = shell.closed
            values[f"{name}_position"] = round(shell.position * 100.0, 1)
        return values

    def inject_fault(self, word: str) -> str:
        """See `Server.inject_fault`: what a dome may suffer, and ``west stuck`` of one shell."""
        name, _, what = word.partition(" ")
        shell = self.model.shells.get(name)
        if shell is None:
            if word == "ok":
                for other in self.model.shells.values():
                    other.stuck, other.lying = False, ""
            return super().inject_fault(word)
        if what == "stuck":
            shell.stuck = True
        elif what in ("lying closed", "lying opened"):
            shell.lying = what.split()[1]
        else:
            return f"{self.name}: a shell has no fault {what!r}"
        return ""
