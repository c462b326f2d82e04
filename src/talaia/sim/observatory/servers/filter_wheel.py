"""The simulated filter wheel as a server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.power import OUTLETS
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Ask, Server

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.sim.observatory.models.filter_wheel import FilterWheel
    from talaia.sim.observatory.servers.base import Value

__all__ = ["FilterWheelServer"]


class FilterWheelServer(Server):
    """The wheel before the chip. It hangs on the camera's outlet."""

    name = "wheel"
    outlet = OUTLETS.index("Camera") + 1

    def __init__(self, model: FilterWheel) -> None:
        """Offer what a wheel does."""
        super().__init__()
        self.model = model
        self.triggers = {
            "status": lambda: Ticket.done(model.name or "turning"),
            "stop": model.stop,
        }
        self.asks = {
            "goto": Ask({"position": 1.0}, model.goto),
            "select": Ask({"filter": ""}, model.select),
        }

    def lose_power(self) -> None:
        """Stand wherever it is."""
        self.model.stop()

    def topic_values(self) -> Mapping[str, Value]:
        """Give which filter stands in the light."""
        model = self.model
        return {"position": model.position, "filter": model.name, "moving": model.position == 0}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds)

    def inject_fault(self, word: str) -> str:
        """See `Server.inject_fault`: stuck."""
        if word in ("stuck", "ok"):
            self.model.stuck = word == "stuck"
        return "" if word == "stuck" else super().inject_fault(word)
