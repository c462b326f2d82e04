"""The simulated camera that looks at all of the sky."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.all_sky import EXPOSURE_S, SIZE, SkyView, draw_sky
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import ImageFrame, Server

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.units.astronomy import Observer
    from talaia.sim.observatory.servers.base import Value

__all__ = ["AllSkyServer"]


class AllSkyServer(Server):
    """A fisheye on the roof of the house."""

    name = "allsky"
    pictures = True

    def __init__(self, place: Observer, seed: int) -> None:
        """See a clear sky, until the weather is heard."""
        super().__init__()
        self._place, self._seed = place, seed
        self._clouds, self._unix = 0.0, 0.0
        # Since the last picture (s); the first is due at once.
        self._since = EXPOSURE_S
        self.triggers = {"status": lambda: Ticket.done("live")}
        self.hears = {"/weather/clouds": (float, self._see_clouds)}

    def _see_clouds(self, cover: float) -> None:
        self._clouds = cover

    def topic_values(self) -> Mapping[str, Value]:
        """Say that it sees."""
        return {"status": "live"}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self._since += seconds
        self._unix = unix_s

    def take_frame(self, *, watched: bool) -> ImageFrame | None:
        """Give a picture after each exposure, while somebody looks."""
        if not watched or self._since < EXPOSURE_S:
            return None
        self._since = 0.0
        picture = draw_sky(SkyView(self._place, self._unix, self._clouds, self._seed))
        return ImageFrame(SIZE, SIZE, "mono8", SIZE, picture.tobytes())
