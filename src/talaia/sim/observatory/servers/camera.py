"""The simulated CCD camera as a server: exposures, cooling, and its pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models import camera
from talaia.sim.observatory.models.power import OUTLETS
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Ask, ImageFrame, Server

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.sim.observatory.models.camera import CcdCamera
    from talaia.sim.observatory.servers.base import Value

__all__ = ["CameraServer"]

_LAMP = OUTLETS.index("Lamp") + 1


class CameraServer(Server):
    """The CCD camera. It hears from the others what belongs into a header."""

    name = "camera"
    pictures = True
    outlet = OUTLETS.index("Camera") + 1

    def __init__(self, model: CcdCamera) -> None:
        """Offer what a camera does."""
        super().__init__()
        self.model = model
        # Half of where the telescope points, until the other half comes.
        self._axis_ra = 0.0
        # Name of the picture that was given last: each is given once.
        self._given = ""
        self._last = ""
        self.triggers = {
            "status": lambda: Ticket.done(f"{model.state} {model.remaining:.1f}"),
            "abort": model.abort_exposure,
        }
        self.switches = {"cooler": model.switch_cooler}
        self.asks = {
            "expose": Ask({"seconds": 0.0, "frame": "light", "target": ""}, model.start_exposure),
            "cool": Ask({"celsius": 0.0}, model.cool_to),
            "binning": Ask({"factor": 1.0}, model.set_binning),
            "gain": Ask({"gain": 0.0}, model.set_gain),
        }
        # The model's own: what is heard here stands in the header of the next exposure.
        scene = model.scene
        self.hears |= {
            "/telescope/ra": (float, lambda value: setattr(scene, "ra", value)),
            "/telescope/dec": (float, lambda value: setattr(scene, "dec", value)),
            "/telescope/axis_ra": (float, self._receive_axis_ra),
            "/telescope/axis_dec": (float, self._receive_axis_dec),
            "/dome/closed": (bool, lambda value: setattr(scene, "dome_open", not value)),
            "/focuser/position": (float, lambda value: setattr(scene, "focus", value)),
            "/focuser/mirror": (float, lambda value: setattr(scene, "mirror", value)),
            "/focuser/temperature": (float, lambda value: setattr(scene, "tube", value)),
            "/wheel/filter": (str, lambda value: setattr(scene, "filter_name", value)),
            f"/pdu/on{_LAMP}": (bool, lambda value: setattr(scene, "lamp", value)),
        }
        for quantity in ("temperature", "humidity", "dew_point", "wind", "clouds", "pressure"):
            self.hears[f"/weather/{quantity}"] = (float, self._weather_receiver(quantity))

    def _receive_axis_ra(self, value: float) -> None:
        self._axis_ra = value

    def _receive_axis_dec(self, value: float) -> None:
        self.model.scene.axis = self._axis_ra, value

    def _weather_receiver(self, name: str) -> Callable[[float], None]:
        return lambda value: self.model.scene.weather.__setitem__(name, value)

    def lose_power(self) -> None:
        """Lose the exposure, and the cold."""
        self.model.abort_exposure()
        self.model.switch_cooler(False)  # noqa: FBT003 - a switch, as the service has it

    def topic_values(self) -> Mapping[str, Value]:
        """Give its state."""
        model = self.model
        return {
            "status": model.state,
            "state": camera.STATES.index(model.state),
            "remaining": model.remaining,
            "temperature": model.celsius,
            "setpoint": model.setpoint,
            "cooling": model.cooling,
            "binning": model.binning,
            "gain": model.gain,
            "file": self._last,
        }

    def take_frame(self, *, watched: bool) -> ImageFrame | None:
        """Give a new picture once, watched or not: it is a file as well."""
        del watched
        newest = self.model.newest
        if newest is None or newest.name == self._given:
            return None
        self._given = self._last = newest.name
        height, width = newest.counts.shape
        # Pictures of ROS have their top row first.
        data = newest.counts[::-1].tobytes()
        return ImageFrame(width, height, "mono16", width * 2, data, newest.name, newest.fits)

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds, unix_s)
