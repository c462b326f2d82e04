"""The simulated controller of the mount."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models import telescope
from talaia.sim.observatory.models.power import OUTLETS
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Ask, Server

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.sim.observatory.models.telescope import Telescope
    from talaia.sim.observatory.servers.base import Value

__all__ = ["TelescopeServer"]

# A German mount tracks so far past the meridian (h).
PAST_MERIDIAN_H = 0.1


class TelescopeServer(Server):
    """The mount."""

    name = "telescope"
    outlet = OUTLETS.index("Telescope") + 1

    def __init__(self, model: Telescope) -> None:
        """Offer what a mount does."""
        super().__init__()
        self.model = model
        self.triggers = {
            "status": lambda: Ticket.done(model.state),
            "getcoord": lambda: Ticket.done(f"Alt:{model.at.alt:f} Az:{model.at.az:f}"),
            "park": model.park,
            "unpark": model.unpark,
            "stop": model.stop,
        }
        self.switches = {"track": model.set_tracking}
        self.asks = {
            "goto": Ask({"ra": 0.0, "dec": 0.0}, model.goto),
            "goto_altaz": Ask({"alt": 0.0, "az": 0.0}, model.goto_altaz),
            "sync": Ask({"ra": 0.0, "dec": 0.0}, model.sync),
            "guide": Ask({"east": 0.0, "north": 0.0}, model.guide),
        }

    def lose_power(self) -> None:
        """Stand wherever it is."""
        self.model.stop()

    def topic_values(self) -> Mapping[str, Value]:
        """Give its encoders."""
        ra, dec = self.model.radec
        axis_ra, axis_dec = self.model.axis
        away = self.model.sun
        return {
            "status": self.model.state,
            "state": telescope.STATES.index(self.model.state),
            "parked": self.model.state == "parked",
            "altitude": self.model.at.alt,
            "azimuth": self.model.at.az,
            "ra": ra,
            "dec": dec,
            # What no mount knows: for the light that falls into the camera.
            "axis_ra": axis_ra,
            "axis_dec": axis_dec,
            "sun_altitude": away.alt,
        }

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds, unix_s)

    def inject_fault(self, word: str) -> str:
        """See `Server.inject_fault`: stuck; and german, a mount that turns over at the meridian."""
        if word in ("stuck", "ok"):
            self.model.stuck = word == "stuck"
        if word in ("german", "ok"):
            past = PAST_MERIDIAN_H if word == "german" else None
            self.model.limits = self.model.limits._replace(past_meridian=past)
        return "" if word in ("stuck", "german") else super().inject_fault(word)
