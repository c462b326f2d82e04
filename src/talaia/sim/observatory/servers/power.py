"""The simulated power distribution unit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.power import OUTLETS
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Ask, Server

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.sim.observatory.models.power import Power
    from talaia.sim.observatory.servers.base import Value

__all__ = ["PowerServer"]


class PowerServer(Server):
    """The outlets."""

    name = "pdu"

    def __init__(self, model: Power) -> None:
        """Offer a switch for each outlet."""
        super().__init__()
        self.model = model
        self.triggers = {"status": lambda: Ticket.done(model.outlet_words())}
        for number in range(1, len(OUTLETS) + 1):
            self.switches[f"outlet{number}"] = self._outlet_switch(number)
        # Requests have numbers as floats; an outlet is a whole one.
        self.asks = {
            "reboot": Ask({"outlet": 1.0}, lambda outlet: model.reboot_outlet(int(outlet)))
        }

    def _outlet_switch(self, number: int) -> Callable[[bool], Ticket]:
        return lambda on: self.model.switch_outlet(number, on=on)

    def topic_values(self) -> Mapping[str, Value]:
        """Give the outlets."""
        outlets: dict[str, Value] = {f"on{n}": on for n, on in enumerate(self.model.on, 1)}
        return {**outlets, "power": self.model.watt}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds)
