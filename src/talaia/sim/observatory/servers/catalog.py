"""How the server of each device of the simulated observatory is made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.camera import CcdCamera, Scene
from talaia.sim.observatory.models.clamshell import Clamshell
from talaia.sim.observatory.models.enclosure import SimulatedEnclosure
from talaia.sim.observatory.models.filter_wheel import FilterWheel
from talaia.sim.observatory.models.focuser import Focuser
from talaia.sim.observatory.models.power import Power
from talaia.sim.observatory.models.telescope import Telescope
from talaia.sim.observatory.models.weather import Weather
from talaia.sim.observatory.servers.all_sky import AllSkyServer
from talaia.sim.observatory.servers.camera import CameraServer
from talaia.sim.observatory.servers.cctv import CctvServer
from talaia.sim.observatory.servers.devices import MONTSEC
from talaia.sim.observatory.servers.dome import ClamshellServer, DomeServer
from talaia.sim.observatory.servers.filter_wheel import FilterWheelServer
from talaia.sim.observatory.servers.focuser import FocuserServer
from talaia.sim.observatory.servers.power import PowerServer
from talaia.sim.observatory.servers.sequencer import GlobalServer
from talaia.sim.observatory.servers.telescope import TelescopeServer
from talaia.sim.observatory.servers.weather import WeatherServer

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.units.astronomy import Observer
    from talaia.sim.observatory.models.ticket import Ticket
    from talaia.sim.observatory.servers.base import Server

__all__ = ["make_server"]


def make_server(
    name: str,
    *,
    seed: int,
    unix_s: float,
    call: Callable[[str, str], Ticket],
    place: Observer = MONTSEC,
    roof: str = "dome",
) -> Server:
    """Make the server of a device.

    Args:
        name: one of `DEVICES`.
        seed: of the weather.
        unix_s: now.
        call: how the global server asks the others.
        place: where the observatory stands.
        roof: one of `ENCLOSURES`.

    """
    turns = roof == "dome"
    match name:
        case "dome":
            return DomeServer(SimulatedEnclosure()) if turns else ClamshellServer(Clamshell())
        case "telescope":
            return TelescopeServer(Telescope(place, unix_s))
        case "weather":
            return WeatherServer(Weather(seed, unix_s))
        case "camera":
            return CameraServer(CcdCamera(Scene(place)))
        case "focuser":
            return FocuserServer(Focuser())
        case "wheel":
            return FilterWheelServer(FilterWheel())
        case "pdu":
            return PowerServer(Power())
        case "allsky":
            return AllSkyServer(place, seed)
        case "cctv":
            return CctvServer(place, slit=turns)
        case _:
            return GlobalServer(call, dome_turns=turns)
