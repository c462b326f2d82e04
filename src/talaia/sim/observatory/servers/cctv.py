"""The simulated surveillance camera in the dome."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.units.astronomy import equatorial_to_horizontal, julian_day, sun_position
from talaia.sim.observatory.models import cctv
from talaia.sim.observatory.models.power import OUTLETS
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import ImageFrame, Server

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.model.units.astronomy import Observer
    from talaia.sim.observatory.servers.base import Value

__all__ = ["CctvServer"]


class CctvServer(Server):
    """A camera on the wall of the dome."""

    name = "cctv"
    pictures = True
    outlet = OUTLETS.index("CCTV") + 1
    EVERY_S = 1.0

    def __init__(self, place: Observer, *, slit: bool = True) -> None:
        """See a closed roof at night; one without a slit is a clamshell."""
        super().__init__()
        self._place = place
        self._slit = slit
        # What was heard last; parts of the roof in %, angles in degrees.
        self._seen = {
            "position": 0.0,
            "slit": 0.0,
            "east": 0.0,
            "west": 0.0,
            "alt": 10.0,
            "az": 10.0,
        }
        # Of the sky: 0 at night, 1 by day.
        self._light = 0.0
        self._lamp = False
        # Since the last picture (s); the first is due at once.
        self._since = self.EVERY_S
        self.triggers = {"status": lambda: Ticket.done("live")}
        self.hears |= {
            "/telescope/altitude": (float, self._value_receiver("alt")),
            "/telescope/azimuth": (float, self._value_receiver("az")),
            # The lamp's outlet; see `OUTLETS`.
            "/pdu/on6": (bool, self._see_lamp),
        }
        roof = {"position": "position", "azimuth": "slit"}
        if not slit:
            roof = {"position": "position", "east_position": "east", "west_position": "west"}
        self.hears |= {
            f"/dome/{topic}": (float, self._value_receiver(seen)) for topic, seen in roof.items()
        }

    def _value_receiver(self, name: str) -> Callable[[float], None]:
        def receive_value(value: float) -> None:
            # A dome that has lost its encoder says NaN: it is drawn where it was.
            if math.isfinite(value):
                self._seen[name] = value

        return receive_value

    def _see_lamp(self, on: bool) -> None:  # noqa: FBT001 - a topic's value
        self._lamp = on

    def topic_values(self) -> Mapping[str, Value]:
        """Say that it sees."""
        return {"status": "live"}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self._since += seconds
        jd = julian_day(unix_s)
        height = equatorial_to_horizontal(*sun_position(jd), self._place, jd).alt
        # Night until the Sun is 12° below the horizon, day from 6° above.
        self._light = min(1.0, max(0.0, (height + 12.0) / 18.0))

    def take_frame(self, *, watched: bool) -> ImageFrame | None:
        """Give a picture once a second while somebody looks."""
        if not watched or self._since < self.EVERY_S:
            return None
        self._since = 0.0
        seen = self._seen
        shells = None if self._slit else (seen["east"] / 100.0, seen["west"] / 100.0)
        view = cctv.View(
            shutter=seen["position"] / 100.0,
            slit=seen["slit"],
            alt=seen["alt"],
            az=seen["az"],
            light=self._light,
            lamp=self._lamp,
            shells=shells,
        )
        return ImageFrame(cctv.WIDTH, cctv.HEIGHT, "rgb8", cctv.WIDTH * 3, cctv.draw_view(view))
