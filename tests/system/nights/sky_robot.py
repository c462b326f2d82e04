"""The simulated observatory in this process, with faults, people at it and the hardware's truth."""

from __future__ import annotations

from typing import Any, NamedTuple

from talaia.cli.demo.in_process_observatory import InProcessObservatory
from talaia.clock import SECOND, HandClock
from talaia.model.site import Site
from talaia.sim.observatory.control_pipe import act_on
from talaia.sim.observatory.models.sky_picture import Chip

# Pictures as small as they may be: what is on them is another test's matter.
CHIP = Chip(width=24, height=16)


class Truth(NamedTuple):
    """How the hardware stood at a moment (s, monotonic), whatever its sensors said."""

    at: float
    sun: float
    roof: str
    telescope: str
    camera: str
    cooling: bool
    rain: float
    wind: float
    gust: float
    humidity: float
    dew_gap: float
    clouds: float
    # Nothing comes from the weather station.
    weather_silent: bool
    # The roof cannot move: no power, an obstacle, a controller that hangs.
    roof_dead: bool
    # Somebody on site has the switch.
    local: bool


class SkyRobot(InProcessObservatory):
    """That of the product, with foreign hands in it and a ledger of the hardware's truth."""

    def __init__(self, site: Site, clock: HandClock, seed: int) -> None:
        """Begin with everything at rest."""
        super().__init__(site, clock, seed=seed, chip=CHIP, kept=None)

    @property
    def lights(self) -> list[str]:
        """Name the pictures of the sky."""
        return [name for name, _ in self.pictures if "-light-" in name]

    # ── foreign hands ──

    def bring_about(self, device: str, words: str) -> None:
        """Do what a line of the control pipe says: a fault, or ``do open`` by hand."""
        server = self.servers[device]
        if act_on(server, words) is None:
            problem = server.inject_fault(words)
            assert not problem, problem

    def truth(self, sun: float) -> Truth:
        dome: Any = self.servers["dome"]
        weather: Any = self.servers["weather"]
        camera: Any = self.servers["camera"]
        telescope: Any = self.servers["telescope"]
        sky = weather.model
        return Truth(
            at=self._clock.monotonic_ns() / SECOND,
            sun=sun,
            roof=dome.truth,
            telescope=telescope.model.state,
            camera=camera.model.state,
            cooling=camera.model.cooling,
            rain=sky.rain,
            wind=sky.wind,
            gust=sky.gust,
            humidity=sky.humidity,
            dew_gap=sky.temperature - sky.dew_point,
            clouds=sky.clouds,
            weather_silent=weather.silent,
            roof_dead=dome.model.stuck or not dome.powered or dome.hanging,
            local=dome.model.local,
        )
