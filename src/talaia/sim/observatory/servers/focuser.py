"""The simulated focuser as a server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.power import OUTLETS
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Ask, Server

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.sim.observatory.models.focuser import Focuser
    from talaia.sim.observatory.servers.base import Value

__all__ = ["FocuserServer"]


class FocuserServer(Server):
    """The motor at the mirror. It hangs on the telescope's outlet."""

    name = "focuser"
    outlet = OUTLETS.index("Telescope") + 1

    def __init__(self, model: Focuser) -> None:
        """Offer what a focuser does."""
        super().__init__()
        self.model = model
        self.triggers = {
            "status": lambda: Ticket.done(f"{model.position:.0f} {model.celsius:.1f}"),
            "stop": model.stop,
        }
        self.asks = {
            "goto": Ask({"position": 0.0}, model.goto),
            "move": Ask({"steps": 0.0}, model.move_by),
        }
        self.hears["/weather/temperature"] = (float, model.feel_air)

    def lose_power(self) -> None:
        """Stand wherever it is."""
        self.model.stop()

    def topic_values(self) -> Mapping[str, Value]:
        """Give its encoder and its thermometer."""
        model = self.model
        return {
            "position": model.position,
            "moving": model.moving,
            "temperature": model.celsius,
            # What no focuser knows: for the light that falls into the camera.
            "mirror": model.mirror,
        }

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds)

    def inject_fault(self, word: str) -> str:
        """See `Server.inject_fault`: stuck."""
        if word in ("stuck", "ok"):
            self.model.stuck = word == "stuck"
        return "" if word == "stuck" else super().inject_fault(word)
