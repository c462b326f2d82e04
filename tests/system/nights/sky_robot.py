"""The simulated observatory's own servers, asked as a gateway's adapter asks a robot. No ROS.

It is the pure core of `talaia sim observatory`: what its ROS shells put on topics and services is
handed over here. What it says of itself (`ledger`) is the hardware's truth and not a message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from talaia.clock import SECOND, HandClock
from talaia.gateway.ports import ChannelReading, CommandOutcome
from talaia.model.site import Site
from talaia.model.units.astronomy import Observer
from talaia.sim.observatory.control_pipe import act_on
from talaia.sim.observatory.models.camera import CcdCamera, Scene
from talaia.sim.observatory.models.sky_picture import Chip
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Server, Stamped
from talaia.sim.observatory.servers.camera import CameraServer
from talaia.sim.observatory.servers.catalog import make_server
from talaia.wire.frames import CommandPhase

DEVICES = ("dome", "telescope", "weather", "focuser", "wheel", "pdu")
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


class Waiting(NamedTuple):
    server: Server
    ticket: Ticket
    done: Callable[[CommandOutcome], None]


class Hung(NamedTuple):
    server: Server
    act: Callable[[], Ticket]
    done: Callable[[CommandOutcome], None]


class SkyRobot:
    """A robot for `Actuation`: its commands, and its newest readings.

    Attributes:
        pictures: name and bytes of each FITS file that the camera made.

    """

    def __init__(self, site: Site, clock: HandClock, seed: int) -> None:
        """Begin with everything at rest."""
        place = site.place
        assert place is not None
        self._site, self._clock = site, clock
        here = Observer(place.latitude, place.longitude, place.elevation)
        unix = clock.wall_ns() / SECOND
        self.servers: dict[str, Server] = {
            name: make_server(name, seed=seed, unix_s=unix, call=_nobody, place=here)
            for name in DEVICES
        }
        self.servers["camera"] = CameraServer(CcdCamera(Scene(here), CHIP))
        self.pictures: list[tuple[str, bytes]] = []
        self.picture_taken: Callable[[bytes], None] = lambda _file: None
        self._topics = {
            f"{device}/{name}": signal.source.topic
            for device, described in site.devices.items()
            for name, signal in described.signals.items()
            if hasattr(signal.source, "topic")
        }
        self._newest: dict[str, ChannelReading] = {}
        self._waiting: list[Waiting] = []
        self._hung: list[Hung] = []
        self._stepped_ns = clock.monotonic_ns()
        # Who hears a topic of another's.
        self._hears: dict[str, list[Callable[[Any], None]]] = {}
        for server in self.servers.values():
            for topic, (_, hear) in server.hears.items():
                self._hears.setdefault(topic, []).append(hear)

    @property
    def lights(self) -> list[str]:
        """Name the pictures of the sky."""
        return [name for name, _ in self.pictures if "-light-" in name]

    # ── what a gateway asks ──

    def latest(self, address: str) -> ChannelReading | None:
        return self._newest.get(self._topics.get(address, ""))

    def drive(self, device: str, linear: float, angular: float, key: str = "") -> None: ...

    def stop(self, device: str, *, stopped: bool) -> None: ...

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Any],
        done: Callable[[CommandOutcome], None],
    ) -> None:
        target = self._site.devices[device].commands[command].target.strip("/")
        name, _, service = target.partition("/")
        server = self.servers[name]

        def ask() -> Ticket:
            return server.without_power() or _ask(server, service, fields)

        if server.hanging:
            self._hung.append(Hung(server, ask, done))
            return
        self._waiting.append(Waiting(server, ask(), done))

    # ── time ──

    def step(self) -> None:
        """Let the time pass that has passed on the clock."""
        now_ns = self._clock.monotonic_ns()
        passed, self._stepped_ns = (now_ns - self._stepped_ns) / SECOND, now_ns
        unix = self._clock.wall_ns() / SECOND
        for hung in [one for one in self._hung if not one.server.hanging]:
            # What lay before a controller that hung is acted on late, as real ones do.
            self._hung.remove(hung)
            self._waiting.append(Waiting(hung.server, hung.act(), hung.done))
        for server in self.servers.values():
            server.pass_time(passed, unix)
            server.own_acts.clear()
        for waiting in [one for one in self._waiting if one.ticket.ended]:
            if waiting.server.hanging:
                continue
            self._waiting.remove(waiting)
            good = waiting.ticket.good
            phase = CommandPhase.SUCCEEDED if good else CommandPhase.FAILED
            waiting.done(CommandOutcome(phase, waiting.ticket.message))
        for server in self.servers.values():
            if not server.silent:
                self._publish(server, now_ns)
        self._read_picture()

    def _publish(self, server: Server, now_ns: int) -> None:
        values = server.topic_values()
        for name, value in values.items():
            topic = f"/{server.name}/{name}"
            number = value.value if isinstance(value, Stamped) else value
            if not isinstance(number, str):
                self._newest[topic] = ChannelReading(float(number), now_ns)
            for hear in self._hears.get(topic, ()):
                hear(value)

    def _read_picture(self) -> None:
        camera = self.servers["camera"]
        frame = None if camera.silent else camera.take_frame(watched=True)
        if frame is not None:
            self.pictures.append((frame.name, frame.file))
            self.picture_taken(frame.file)

    def forget_askers(self) -> None:
        """Answer nobody: who asked is dead. What was begun goes on."""
        self._waiting = [one._replace(done=_unheard) for one in self._waiting]
        self._hung = [one._replace(done=_unheard) for one in self._hung]

    def say_newest_picture(self) -> None:
        """Give the newest file once more, as a latched topic does to who comes later."""
        if self.pictures:
            self.picture_taken(self.pictures[-1][1])

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


def _nobody(device: str, what: str) -> Ticket:
    return Ticket.refused(f"/{device}/{what} is not there")


def _unheard(_outcome: CommandOutcome) -> None: ...


def _ask(server: Server, service: str, fields: dict[str, Any]) -> Ticket:
    if service in server.triggers:
        return server.triggers[service]()
    if service in server.switches:
        return server.switches[service](bool(fields["data"]))
    values: dict[str, Any] = {}
    for index in range(len(server.asks[service].arguments)):
        name = fields.get(f"parameters[{index}].name")
        given = [
            value
            for key, value in fields.items()
            if key.startswith(f"parameters[{index}].value.") and key.endswith("_value")
        ]
        if name and given:
            values[str(name)] = given[0]
    for name, example in server.asks[service].arguments.items():
        if name not in values and isinstance(example, str):
            values[name] = example
    return server.asks[service].act(**values)
