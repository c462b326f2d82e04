"""The simulated weather station, with the faults that a station may have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.models.weather import FORCES
from talaia.sim.observatory.servers.base import Server, Stamped

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.sim.observatory.models.weather import Weather
    from talaia.sim.observatory.servers.base import Value

__all__ = ["WeatherServer"]


class WeatherServer(Server):
    """The weather station."""

    name = "weather"
    VALUES = (
        "clouds",
        "rain",
        "wind",
        "gust",
        "humidity",
        "dew_point",
        "temperature",
        "pressure",
    )

    def __init__(self, model: Weather) -> None:
        """Offer what a station does."""
        super().__init__()
        self.model = model
        # Numbers that a fault puts in the place of what is measured.
        self._said_instead: dict[str, Value] = {}
        # A fault: stamps go on saying the same time.
        self._stamps_stand = False
        # When it measured last (s, UTC).
        self._stamp_s = 0.0
        self.triggers = {"info": lambda: Ticket.done(model.weather_info())}

    def topic_values(self) -> Mapping[str, Value]:
        """Give its sensors."""
        values: dict[str, Value] = {
            quantity: float(getattr(self.model, quantity)) for quantity in self.VALUES
        }
        return {
            **values,
            "stamped": Stamped(self.model.temperature, self._stamp_s),
            "raining": self.model.rain > 0.0,
            "description": self.model.weather_words()[1],
            # Last, so that they win.
            **self._said_instead,
        }

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds, unix_s)
        if not self._stamps_stand:
            self._stamp_s = unix_s

    def _say_instead(self, name: str, number: str) -> str:
        if name not in self.VALUES:
            return f"{name!r}: expected one of {', '.join(self.VALUES)}"
        try:
            self._said_instead[name] = float(number)
        except ValueError:
            return f"{number!r} is not a number"
        return ""

    def inject_fault(self, word: str) -> str:
        """See `Server.inject_fault`: lying, and the weathers that can be forced.

        ``set wind -999`` says that number instead of what is measured, ``freeze`` goes on with
        the same numbers bit for bit, ``old stamps`` with the same time of measuring.
        """
        if word.startswith("set ") and word.count(" ") == 2:
            return self._say_instead(*word.split()[1:])
        if word == "freeze":
            self._said_instead = {
                quantity: float(getattr(self.model, quantity)) for quantity in self.VALUES
            }
            return ""
        if word == "old stamps":
            self._stamps_stand = True
            return ""
        if word == "lying":
            self.model.lying = True
            return ""
        if word in FORCES:
            return self.model.force_weather(word)
        if word == "ok":
            self.model.lying = self._stamps_stand = False
            self._said_instead.clear()
            self.model.force_weather("")
        return super().inject_fault(word)
