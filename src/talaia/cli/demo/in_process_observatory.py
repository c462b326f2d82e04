"""The simulated observatory's own servers, asked as a gateway's adapter asks a robot. No ROS.

It is the pure core of `talaia sim observatory`: what its ROS shells put on topics and services is
handed over here, so that simulator and gateway can live on one simulated clock.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.ports import ChannelReading, CommandOutcome
from talaia.model.units.astronomy import Observer
from talaia.sim.observatory.models.camera import CcdCamera, Scene
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Stamped
from talaia.sim.observatory.servers.camera import CameraServer
from talaia.sim.observatory.servers.catalog import make_server
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.clock import Clock
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.model.site import Site
    from talaia.sim.observatory.models.sky_picture import Chip
    from talaia.sim.observatory.servers.base import Server, Value

__all__ = ["InProcessObservatory"]

DEVICES = ("dome", "telescope", "weather", "focuser", "wheel", "pdu")


class _Waiting(NamedTuple):
    server: Server
    ticket: Ticket
    done: Callable[[CommandOutcome], None]


class _Hung(NamedTuple):
    server: Server
    act: Callable[[], Ticket]
    done: Callable[[CommandOutcome], None]


class InProcessObservatory:
    """A robot for `Actuation`: its commands, and its newest readings. One thread.

    Attributes:
        servers: by name.
        pictures: name and bytes of the newest FITS files that the camera made, the newest last.
        picture_taken: told of each file.

    """

    def __init__(
        self, site: Site, clock: Clock, *, seed: int, chip: Chip | None = None, kept: int | None = 1
    ) -> None:
        """Begin with everything at rest.

        Args:
            site: the description, with a place.
            clock: its time.
            seed: of the weather.
            chip: the camera's; none: that of `talaia sim observatory`.
            kept: so many pictures are kept at hand; none: all of them.

        """
        place = site.place
        if place is None:
            raise ValueError(f"{site.site} has no place")
        self._site, self._clock = site, clock
        here = Observer(place.latitude, place.longitude, place.elevation)
        unix = clock.wall_ns() / SECOND
        self.servers: dict[str, Server] = {
            name: make_server(name, seed=seed, unix_s=unix, call=_nobody, place=here)
            for name in DEVICES
        }
        self.servers["camera"] = CameraServer(CcdCamera(Scene(here), chip))
        self.pictures: deque[tuple[str, bytes]] = deque(maxlen=kept)
        self.picture_taken: Callable[[bytes], None] = lambda _file: None
        self._topics = {
            f"{device}/{name}": topic
            for device, described in site.devices.items()
            for name, signal in described.signals.items()
            if isinstance(topic := getattr(signal.source, "topic", None), str)
        }
        self._newest: dict[str, ChannelReading] = {}
        self._texts: dict[str, str] = {}
        self._waiting: list[_Waiting] = []
        self._hung: list[_Hung] = []
        self._stepped_ns = clock.monotonic_ns()
        # Who hears a topic of another's.
        self._hears: dict[str, list[Callable[[Value], None]]] = {}
        for server in self.servers.values():
            for topic, (_, hear) in server.hears.items():
                self._hears.setdefault(topic, []).append(hear)

    # ── what a gateway asks ──

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._newest.get(self._topics.get(address, ""))

    def text_of(self, address: str) -> str | None:
        """Give a text signal's newest value."""
        return self._texts.get(self._topics.get(address, ""))

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Nothing here is driven."""

    def stop(self, device: str, *, stopped: bool) -> None:
        """Nothing here has a STOP topic."""

    def act(
        self,
        device: str,
        command: str,
        fields: Mapping[str, object],
        done: Callable[[CommandOutcome], None],
    ) -> None:
        """See `CommandTarget.act`; nothing can be asked to end early."""
        target = self._site.devices[device].commands[command].target.strip("/")
        name, _, service = target.partition("/")
        server = self.servers[name]

        def ask() -> Ticket:
            return server.without_power() or _ask(server, service, fields)

        if server.hanging:
            self._hung.append(_Hung(server, ask, done))
            return
        self._waiting.append(_Waiting(server, ask(), done))

    # ── time ──

    def step(self) -> None:
        """Let the time pass that has passed on the clock."""
        now_ns = self._clock.monotonic_ns()
        passed, self._stepped_ns = (now_ns - self._stepped_ns) / SECOND, now_ns
        unix = self._clock.wall_ns() / SECOND
        for hung in [one for one in self._hung if not one.server.hanging]:
            # What lay before a controller that hung is acted on late, as real ones do.
            self._hung.remove(hung)
            self._waiting.append(_Waiting(hung.server, hung.act(), hung.done))
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
        for name, value in server.topic_values().items():
            topic = f"/{server.name}/{name}"
            number = value.value if isinstance(value, Stamped) else value
            if isinstance(number, str):
                self._texts[topic] = number
            else:
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


def _nobody(device: str, what: str) -> Ticket:
    return Ticket.refused(f"/{device}/{what} is not there")


def _unheard(_outcome: CommandOutcome) -> None: ...


def _ask(server: Server, service: str, fields: Mapping[str, object]) -> Ticket:
    if service in server.triggers:
        return server.triggers[service]()
    if service in server.switches:
        return server.switches[service](bool(fields["data"]))
    values: dict[str, object] = {}
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
