"""One server for each device of the observatory, whatever carries its words: ROS 2 or ROS 1.

A server says which topics it publishes, which services it offers, and what it does when it is
asked. The shells (`ros2_shell`, `ros1_shell`) bring that to the robot's network. Long, since the
whole face of the observatory stands here, one class for a device.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.model.units.astronomy import Observer, altaz, julian_day, sun
from talaia.sim.observatory import camera, cctv, enclosure, telescope
from talaia.sim.observatory.camera import CcdCamera, Scene
from talaia.sim.observatory.clamshell import Clamshell
from talaia.sim.observatory.enclosure import SimulatedEnclosure
from talaia.sim.observatory.heartbeat import ControllerWatchdog
from talaia.sim.observatory.power import OUTLETS, Power
from talaia.sim.observatory.telescope import Telescope
from talaia.sim.observatory.ticket import Ticket
from talaia.sim.observatory.weather import FORCES, Weather

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = [
    "DEVICES",
    "ENCLOSURES",
    "MONTSEC",
    "Ask",
    "ImageFrame",
    "Server",
    "Stamped",
    "Value",
    "make",
]

MONTSEC = Observer(42.0517, 0.7297, 1568.0)
# Kinds of roof: a dome with a slit, which turns, and a clamshell, which does not.
ENCLOSURES = ("dome", "clamshell")
DEVICES = ("dome", "telescope", "weather", "camera", "pdu", "cctv", "observatory")


class Stamped(NamedTuple):
    """A temperature (°C) with the time at which it was measured (s, UTC)."""

    value: float
    unix_s: float


# A bool goes as Bool, an int as UInt8, a float as Float64, a str as String, what has a time of its
# own as sensor_msgs/Temperature.
Value = bool | int | float | str | Stamped


class Ask(NamedTuple):
    """A request with arguments: their names with an example of each type, and who does it."""

    arguments: dict[str, Value]
    act: Callable[..., Ticket]


class ImageFrame(NamedTuple):
    """A picture for a topic.

    Attributes:
        encoding: as `sensor_msgs/Image` names it.
        step: bytes of a row.
        file: the whole file, where there is one.

    """

    width: int
    height: int
    encoding: str
    step: int
    data: bytes
    name: str = ""
    file: bytes = b""


class Server:
    """What the shells ask of a server.

    Attributes:
        triggers: services without arguments.
        switches: services with one truth.
        asks: services with named arguments.
        hears: topics of other servers, absolute, with what is done with their values.
        pictures: it has a topic for them.
        hanging: it neither answers nor publishes, as a process that is stuck.
        own_acts: what it has begun by itself, for the ledger.
        outlet: of the power distribution unit, counted from 1, that it hangs on; 0 for none.
        powered: it has power. Without it publishes nothing, moves nothing and refuses all.

    """

    name = ""
    outlet = 0
    pictures = False

    def __init__(self) -> None:
        """Offer nothing yet."""
        self.triggers: dict[str, Callable[[], Ticket]] = {}
        self.switches: dict[str, Callable[[bool], Ticket]] = {}
        self.asks: dict[str, Ask] = {}
        self.hears: dict[str, tuple[type, Callable[[Any], None]]] = {}
        self.hanging = False
        self.own_acts: list[tuple[str, Ticket]] = []
        self.powered = True
        if self.outlet:
            self.hears[f"/pdu/on{self.outlet}"] = (bool, self.feed)

    @property
    def silent(self) -> bool:
        """Tell whether nothing is published."""
        return self.hanging or not self.powered

    def feed(self, on: bool) -> None:  # noqa: FBT001 - a topic's value
        """Take power, or lose it: what moved stands, and nothing goes on when power is back."""
        if self.powered and not on:
            self.lose_power()
        self.powered = on

    def lose_power(self) -> None:
        """End what is under way, as a controller does that goes dark."""

    def pass_time(self, seconds: float, unix_s: float) -> None:
        """Let time pass; nothing moves without power."""
        if self.powered:
            self.step(seconds, unix_s)

    def without_power(self) -> Ticket | None:
        """Give the answer to whatever is asked while there is no power; none while there is."""
        if self.powered:
            return None
        return Ticket.refused(f"the {self.name} does not answer; it has no power")

    @property
    def truth(self) -> str:
        """Give how its hardware really stands, for the ledger; empty when nobody wants to know."""
        return ""

    def topics(self) -> Mapping[str, Value]:
        """Give what is published now, by the topic's name below the server's."""
        return {}

    def frame(self, *, watched: bool) -> ImageFrame | None:
        """Give a picture that nobody was given yet; ``watched`` tells whether anybody looks."""
        del watched
        return None

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""

    def fault(self, word: str) -> str:
        """Bring a fault about, or end all with ``ok``; give what is wrong with the word."""
        if word == "hang":
            self.hanging = True
            return ""
        if word == "ok":
            self.hanging = False
            return ""
        return f"{self.name}: there is no fault {word!r}"


class DomeServer(Server):
    """The roof's controller: its shutter, and rotation where it turns."""

    name = "dome"
    outlet = OUTLETS.index("Dome") + 1

    def __init__(self, model: SimulatedEnclosure) -> None:
        """Offer what a dome does."""
        super().__init__()
        self.model = model
        self.watchdog = ControllerWatchdog()
        self._stepped_s: float | None = None
        self.triggers = {
            "status": lambda: Ticket.done(model.word),
            "open": model.open,
            "close": model.close,
            "stop": model.stop,
            "heartbeat": self.watchdog.hear_heartbeat,
        }
        if model.can.can_rotate:
            self.triggers["park"] = model.park
            self.asks = {"goto": Ask({"azimuth": 0.0}, model.turn)}

    def lose_power(self) -> None:
        """Stand wherever it is."""
        self.model.stop()

    @property
    def truth(self) -> str:
        """Give where shutter and flap are."""
        return self.model.truth

    def topics(self) -> Mapping[str, Value]:
        """Give its sensors."""
        dome = self.model
        values: dict[str, Value] = {
            "status": dome.word,
            "state": enclosure.STATES.index(dome.state),
            "closed": dome.closed,
            "opened": dome.opened,
            "position": round(dome.position * 100.0, 1),
            "local": dome.local,
        }
        if dome.can.can_rotate:
            values |= {"azimuth": dome.shown_azimuth, "turning": dome.turning}
        return values

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass. Heartbeats come in real time, whatever the simulation's speed."""
        before, self._stepped_s = self._stepped_s, unix_s
        real_s = 0.0 if before is None else min(1.0, max(0.0, unix_s - before))
        if self.watchdog.step(real_s):
            self.own_acts.append(("close", self.model.close()))
        self.model.step(seconds)

    def fault(self, word: str) -> str:
        """See `Server.fault`: stuck, encoder, lying closed, lying opened, local."""
        dome = self.model
        if word == "stuck":
            dome.stuck = True
        elif word == "encoder" and dome.can.can_rotate:
            dome.lost = True
        elif word in ("lying closed", "lying opened"):
            dome.lying = word.split()[1]
        elif word == "local":
            dome.local = True
        else:
            if word == "ok":
                dome.stuck = dome.lost = dome.local = False
                dome.lying = ""
            return super().fault(word)
        return ""


class ClamshellServer(DomeServer):
    """The controller of a clamshell: an end switch and an encoder for each shell, no azimuth."""

    model: Clamshell

    def __init__(self, model: Clamshell) -> None:
        """Offer what a clamshell does."""
        super().__init__(model)

    def topics(self) -> Mapping[str, Value]:
        """Give its sensors, then those of each shell."""
        values = dict(super().topics())
        for name, shell in self.model.shells.items():
            values[f"{name}_closed"] = shell.closed
            values[f"{name}_position"] = round(shell.position * 100.0, 1)
        return values

    def fault(self, word: str) -> str:
        """See `Server.fault`: what a dome may suffer, and of one shell ``west stuck`` and such."""
        name, _, what = word.partition(" ")
        shell = self.model.shells.get(name)
        if shell is None:
            if word == "ok":
                for each in self.model.shells.values():
                    each.stuck, each.lying = False, ""
            return super().fault(word)
        if what == "stuck":
            shell.stuck = True
        elif what in ("lying closed", "lying opened"):
            shell.lying = what.split()[1]
        else:
            return f"{self.name}: a shell has no fault {what!r}"
        return ""


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
        self.switches = {"track": model.track}
        self.asks = {
            "goto": Ask({"ra": 0.0, "dec": 0.0}, model.goto),
            "goto_altaz": Ask({"alt": 0.0, "az": 0.0}, model.goto_altaz),
        }

    def lose_power(self) -> None:
        """Stand wherever it is."""
        self.model.stop()

    def topics(self) -> Mapping[str, Value]:
        """Give its encoders."""
        ra, dec = self.model.radec
        away = self.model.sun
        return {
            "status": self.model.state,
            "state": telescope.STATES.index(self.model.state),
            "parked": self.model.state == "parked",
            "altitude": self.model.at.alt,
            "azimuth": self.model.at.az,
            "ra": ra,
            "dec": dec,
            "sun_altitude": away.alt,
        }

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds, unix_s)

    def fault(self, word: str) -> str:
        """See `Server.fault`: stuck."""
        if word in ("stuck", "ok"):
            self.model.stuck = word == "stuck"
        return "" if word == "stuck" else super().fault(word)


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
        self._said_instead: dict[str, Value] = {}
        self._stamps_stand = False
        self._stamp_s = 0.0
        self.triggers = {"info": lambda: Ticket.done(model.info())}

    def topics(self) -> Mapping[str, Value]:
        """Give its sensors."""
        values: dict[str, Value] = {each: float(getattr(self.model, each)) for each in self.VALUES}
        return {
            **values,
            "stamped": Stamped(self.model.temperature, self._stamp_s),
            "raining": self.model.rain > 0.0,
            "description": self.model.words()[1],
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

    def fault(self, word: str) -> str:
        """See `Server.fault`: lying, and the weathers that can be forced.

        ``set wind -999`` says that number instead of what is measured, ``freeze`` goes on with
        the same numbers bit for bit, ``old stamps`` with the same time of measuring.
        """
        if word.startswith("set ") and word.count(" ") == 2:
            return self._say_instead(*word.split()[1:])
        if word == "freeze":
            self._said_instead = {each: float(getattr(self.model, each)) for each in self.VALUES}
            return ""
        if word == "old stamps":
            self._stamps_stand = True
            return ""
        if word == "lying":
            self.model.lying = True
            return ""
        if word in FORCES:
            return self.model.force(word)
        if word == "ok":
            self.model.lying = self._stamps_stand = False
            self._said_instead.clear()
            self.model.force("")
        return super().fault(word)


class CameraServer(Server):
    """The CCD camera. It hears from the others what belongs into a header."""

    name = "camera"
    pictures = True
    outlet = OUTLETS.index("Camera") + 1

    def __init__(self, model: CcdCamera) -> None:
        """Offer what a camera does."""
        super().__init__()
        self.model = model
        self._given = ""
        self._last = ""
        self.triggers = {
            "status": lambda: Ticket.done(f"{model.state} {model.remaining:.1f}"),
            "abort": model.abort,
        }
        self.switches = {"cooler": model.cooler}
        self.asks = {
            "expose": Ask({"seconds": 0.0, "frame": "light", "target": ""}, model.expose),
            "cool": Ask({"celsius": 0.0}, model.cool),
        }
        scene = model.scene
        self.hears |= {
            "/telescope/ra": (float, lambda value: setattr(scene, "ra", value)),
            "/telescope/dec": (float, lambda value: setattr(scene, "dec", value)),
            "/dome/closed": (bool, lambda value: setattr(scene, "dome_open", not value)),
        }
        for each in ("temperature", "humidity", "dew_point", "wind", "clouds", "pressure"):
            self.hears[f"/weather/{each}"] = (float, self._weather(each))

    def _weather(self, name: str) -> Callable[[float], None]:
        return lambda value: self.model.scene.weather.__setitem__(name, value)

    def lose_power(self) -> None:
        """Lose the exposure, and the cold."""
        self.model.abort()
        self.model.cooler(False)  # noqa: FBT003 - a switch, as the service has it

    def topics(self) -> Mapping[str, Value]:
        """Give its state."""
        model = self.model
        return {
            "status": model.state,
            "state": camera.STATES.index(model.state),
            "remaining": model.remaining,
            "temperature": model.celsius,
            "setpoint": model.setpoint,
            "cooling": model.cooling,
            "file": self._last,
        }

    def frame(self, *, watched: bool) -> ImageFrame | None:
        """Give a new picture once, watched or not: it is a file as well."""
        del watched
        newest = self.model.newest
        if newest is None or newest.name == self._given:
            return None
        self._given = self._last = newest.name
        width, height = len(newest.rows[0]), len(newest.rows)
        # Pictures of ROS have their top row first.
        data = b"".join(row.tobytes() for row in reversed(newest.rows))
        return ImageFrame(width, height, "mono16", width * 2, data, newest.name, newest.fits)

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds, unix_s)


class PowerServer(Server):
    """The outlets."""

    name = "pdu"

    def __init__(self, model: Power) -> None:
        """Offer a switch for each outlet."""
        super().__init__()
        self.model = model
        self.triggers = {"status": lambda: Ticket.done(model.words())}
        for number in range(1, len(OUTLETS) + 1):
            self.switches[f"outlet{number}"] = self._switch(number)
        self.asks = {"reboot": Ask({"outlet": 1.0}, lambda outlet: model.reboot(int(outlet)))}

    def _switch(self, number: int) -> Callable[[bool], Ticket]:
        return lambda on: self.model.switch(number, on=on)

    def topics(self) -> Mapping[str, Value]:
        """Give the outlets."""
        outlets: dict[str, Value] = {f"on{n}": on for n, on in enumerate(self.model.on, 1)}
        return {**outlets, "power": self.model.watt}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self.model.step(seconds)


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
        self._seen = {
            "position": 0.0,
            "slit": 0.0,
            "east": 0.0,
            "west": 0.0,
            "alt": 10.0,
            "az": 10.0,
        }
        self._light = 0.0
        self._lamp = False
        self._since = self.EVERY_S
        self.triggers = {"status": lambda: Ticket.done("live")}
        self.hears |= {
            "/telescope/altitude": (float, self._see("alt")),
            "/telescope/azimuth": (float, self._see("az")),
            "/pdu/on6": (bool, self._see_lamp),
        }
        roof = {"position": "position", "azimuth": "slit"}
        if not slit:
            roof = {"position": "position", "east_position": "east", "west_position": "west"}
        self.hears |= {f"/dome/{topic}": (float, self._see(seen)) for topic, seen in roof.items()}

    def _see(self, name: str) -> Callable[[float], None]:
        def receive_value(value: float) -> None:
            if math.isfinite(value):
                self._seen[name] = value

        return receive_value

    def _see_lamp(self, on: bool) -> None:  # noqa: FBT001 - a topic's value
        self._lamp = on

    def topics(self) -> Mapping[str, Value]:
        """Say that it sees."""
        return {"status": "live"}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self._since += seconds
        jd = julian_day(unix_s)
        height = altaz(*sun(jd), self._place, jd).alt
        self._light = min(1.0, max(0.0, (height + 12.0) / 18.0))

    def frame(self, *, watched: bool) -> ImageFrame | None:
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
        return ImageFrame(cctv.WIDTH, cctv.HEIGHT, "rgb8", cctv.WIDTH * 3, cctv.draw(view))


class GlobalServer(Server):
    """The one service that moves all, by asking the others."""

    name = "observatory"
    # A step that takes longer is left behind: a dome closes even if the telescope does not park.
    WITHIN_S = 60.0

    def __init__(self, call: Callable[[str, str], Ticket], *, dome_turns: bool = True) -> None:
        """Take how another server is asked (its name, its service); one that turns is parked."""
        super().__init__()
        self._call = call
        self._ticket = Ticket.done("")
        self._steps: list[tuple[str, str]] = []
        self._under_way: Ticket | None = None
        self._name = ""
        self._left = 0.0
        self._failed: list[str] = []
        self.triggers = {
            "status": lambda: Ticket.done(self._name or "idle"),
            "open": lambda: self._begin("opening", ("dome", "open"), ("telescope", "unpark")),
            "close": lambda: self._begin(
                "closing", ("camera", "abort"), ("telescope", "park"), ("dome", "close")
            ),
            "stop": self._stop,
        }
        park = [("camera", "abort"), ("telescope", "park"), *[("dome", "park")] * dome_turns]
        self.triggers["park"] = lambda: self._begin("parking", *park)

    def _begin(self, name: str, *steps: tuple[str, str]) -> Ticket:
        self._ticket.end("another command came", good=False)
        self._ticket, self._steps, self._name = Ticket(), list(steps), name
        self._under_way, self._failed = None, []
        return self._ticket

    def _stop(self) -> Ticket:
        self._ticket.end("the observatory was stopped", good=False)
        self._steps, self._name, self._under_way = [], "", None
        for device in ("dome", "telescope"):
            self._call(device, "stop")
        return Ticket.done("the observatory is stopped")

    def topics(self) -> Mapping[str, Value]:
        """Say what it does."""
        return {"status": self._name or "idle"}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        del unix_s
        if not self._name:
            return
        if self._under_way is not None:
            self._left -= seconds
            if not self._under_way.ended and self._left > 0:
                return
            if not self._under_way.good:
                said = self._under_way.message or "no answer"
                self._failed.append(f"{'/'.join(self._steps[0])}: {said}")
            self._steps.pop(0)
            self._under_way = None
        if self._steps:
            self._under_way = self._call(*self._steps[0])
            self._left = self.WITHIN_S
            return
        said = "; ".join(self._failed) or f"{self._name} is done"
        self._ticket.end(said, good=not self._failed)
        self._name = ""


def make(
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
        case "pdu":
            return PowerServer(Power())
        case "cctv":
            return CctvServer(place, slit=turns)
        case _:
            return GlobalServer(call, dome_turns=turns)
