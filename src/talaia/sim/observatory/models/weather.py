"""Seeded weather that drifts, and can be made bad on demand. Pure: time is given.

Temperature follows the hour; the rest are slow random walks that are drawn back to their means
(Ornstein-Uhlenbeck), so that a day is a plausible day and a seed gives the same one again.
"""

from __future__ import annotations

import math
import random

__all__ = ["FORCES", "Weather", "dew_point"]

# What may be asked for, with what it sets.
FORCES: dict[str, dict[str, float]] = {
    "rain": {"clouds": 100.0, "rain": 4.0, "humidity": 96.0},
    "wind": {"wind": 75.0},
    "clouds": {"clouds": 100.0},
    "humid": {"humidity": 97.0},
    "clear": {"clouds": 5.0, "rain": 0.0, "humidity": 45.0, "wind": 8.0},
}
# In %, %, km/h and hPa, as the spread below.
_MEAN = {"clouds": 20.0, "humidity": 55.0, "wind": 10.0, "pressure": 1016.0}
_SPREAD = {"clouds": 18.0, "humidity": 8.0, "wind": 4.0, "pressure": 4.0}
# In this time a deviation falls to about a third (s).
_RELAX_S = 3600.0


def dew_point(celsius: float, humidity: float) -> float:
    """Give the dew point (°C); Magnus' formula with Sonntag's constants (1990)."""
    gamma = math.log(max(humidity, 1.0) / 100.0) + 17.62 * celsius / (243.12 + celsius)
    return 243.12 * gamma / (17.62 - gamma)


class Weather:
    """What a weather station measures.

    Attributes:
        clouds: cover (%).
        rain: rate (mm/h).
        wind: speed (km/h).
        gust: fastest of the last minutes (km/h).
        humidity: relative (%).
        temperature: (°C).
        pressure: (hPa).
        lying: the station says that all is well whatever the weather.

    """

    def __init__(self, seed: int, unix_s: float) -> None:
        """Start a day of fair weather."""
        self._random = random.Random(seed)  # noqa: S311 - weather, not a secret
        # Deviation of each quantity from its mean, in units of its spread.
        self._walk = {name: self._random.gauss(0.0, 0.3) for name in _MEAN}
        # What a test forces; empty for the weather as it comes.
        self._forced: dict[str, float] = {}
        self.lying = False
        self.gust = 0.0
        self._unix = unix_s
        self.step(0.0, unix_s)

    def force_weather(self, what: str) -> str:
        """Make it bad or good by one of `FORCES`, or let it go with an empty word.

        Returns:
            What is wrong with the word; empty when it was done.

        """
        if what and what not in FORCES:
            return f"weather {what!r}: expected one of {', '.join(FORCES)}"
        self._forced = dict(FORCES.get(what, {}))
        # The gusts of the weather before are forgotten.
        self.gust = 0.0
        self.step(0.0, self._unix)
        return ""

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self._unix = unix_s
        # An Ornstein-Uhlenbeck process, stepped exactly: its spread does not depend on the step
        # (Gillespie 1996, Phys. Rev. E 54, 2084).
        decay = math.exp(-seconds / _RELAX_S)
        for name in self._walk:
            kick = self._random.gauss(0.0, 1.0) * math.sqrt(max(0.0, 1.0 - decay * decay))
            self._walk[name] = self._walk[name] * decay + kick
        real = {name: _MEAN[name] + _SPREAD[name] * self._walk[name] for name in _MEAN}
        # It rains from 85 % of cloud cover on, more with more clouds.
        real["rain"] = max(0.0, (real["clouds"] - 85.0) / 10.0)
        # A station that lies says fair weather, whatever is forced.
        now = {**real, **({**FORCES["clear"]} if self.lying else self._forced)}
        self.clouds = min(100.0, max(0.0, now["clouds"]))
        self.rain = now["rain"]
        self.humidity = min(100.0, max(5.0, now["humidity"]))
        self.wind = max(0.0, now["wind"])
        self.pressure = now["pressure"]
        hour = unix_s / 3600.0 % 24.0
        # Warmest at three in the afternoon.
        self.temperature = 14.0 + 5.0 * math.cos((hour - 15.0) * math.pi / 12.0)
        # Gusts are 1.2 times the mean wind and more; the fastest is forgotten within minutes.
        blow = self.wind * (1.2 + 0.2 * abs(self._random.gauss(0.0, 1.0)))
        self.gust = max(blow, self.gust * math.exp(-seconds / 180.0))

    @property
    def dew_point(self) -> float:
        """Give the dew point (°C)."""
        return dew_point(self.temperature, self.humidity)

    def weather_words(self) -> tuple[str, str]:
        """Give the weather in a word and in two, as weather services do."""
        if self.rain > 0.0:
            return "Rain", "heavy rain" if self.rain > 2.0 else "light rain"
        for least, word in ((85.0, "overcast clouds"), (51.0, "broken clouds")):
            if self.clouds >= least:
                return "Clouds", word
        return ("Clouds", "few clouds") if self.clouds >= 11.0 else ("Clear", "clear sky")

    def weather_info(self) -> str:
        """Give the founding design's list: words, °C, hPa, %, m/s, gust, dew point, mm/h, cover."""
        values = (
            *self.weather_words(),
            f"{self.temperature:.2f}",
            f"{self.pressure:.0f}",
            f"{self.humidity:.0f}",
            f"{self.wind / 3.6:.1f}",
            f"{self.gust / 3.6:.1f}",
            f"{self.dew_point:.1f}",
            f"{self.rain:.1f}",
            f"{self.clouds:.0f}",
        )
        return str(list(values))
