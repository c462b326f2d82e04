"""The INDI adapter: one server's devices as signals and commands.

A small client of our own over asyncio's streams. It must see the end of the connection at once:
`indipyclient` 0.9.4 noticed a killed server after 40 s, this one in some milliseconds (see
docs/decisions/0043). Here bytes come and go; what they mean is in the modules beside: `state`
(what is known), `signal_readings` (what is given out of it), `commands_under_way`,
`picture_reception`, `driver_connections`, `driver_answers` and `found_devices`.

Long, because every event and every tick passes all of these parts, in an order that counts.
"""

from __future__ import annotations

import asyncio
import logging
import socket
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.commands_under_way import CommandsUnderWay
from talaia.gateway.adapters.indi.driver_answers import DriverAnswers
from talaia.gateway.adapters.indi.driver_connections import DriverConnections
from talaia.gateway.adapters.indi.errors import IndiError
from talaia.gateway.adapters.indi.found_devices import FoundDevices
from talaia.gateway.adapters.indi.goals import CHOICE
from talaia.gateway.adapters.indi.picture_reception import PictureReception
from talaia.gateway.adapters.indi.protocol import (
    BlobEnd,
    BlobHead,
    BlobPart,
    DriverMessage,
    IndiParser,
    Vector,
    VectorKind,
    ask_properties,
    new_vector,
)
from talaia.gateway.adapters.indi.signal_readings import SignalReadings
from talaia.gateway.adapters.indi.state import IndiDeviceTree
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import CommandOutcome
from talaia.model.connection import IndiConnection
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.indi.protocol import Deleted
    from talaia.gateway.ports import AdapterContext, AdapterStatus, ChannelReading
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.wire.frames import Scalar

__all__ = ["IndiAdapter"]

log = logging.getLogger(__name__)
OPEN_S = 5.0
# Pace of all that goes by time: connecting, progress, repeating values.
TICK_S = 0.25
READ_BYTES = 256 * 1024
# What a server may leave unread before we take it as stuck.
MAX_UNSENT = 1024 * 1024
PING_NS = SECOND
# Who is not there by then is told as absent.
SETTLE_NS = 3 * SECOND
# A server that has vanished without a word (power cut, cable) ends the connection after this.
_SILENT_TCP_S = 6


class IndiAdapter:
    """An `Adapter` for the devices of one INDI server. See `talaia.gateway.ports`.

    Nothing is known of a device but what the server of now has said: with the connection the tree
    is cleared, and every command that was under way is told as unknown.
    """

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what it serves, where things go, and where it says how its side stands."""
        settings = scope.connection
        assert isinstance(settings, IndiConnection)  # noqa: S101 - the catalogue's promise
        self._scope, self._settings, self._status = scope, settings, status
        self._clock, self._events = context.clock, context.events
        # By the name in the description: INDI's name.
        self._devices = {name: device.indi for name, device in scope.devices.items() if device.indi}
        # By INDI's name: that in the description; the first, where two stand for one.
        self._names: dict[str, str] = {}
        for name, indi in self._devices.items():
            self._names.setdefault(indi, name)
        # What the server has said; written by this class only.
        self._tree = IndiDeviceTree()
        # To the server; none while there is none.
        self._writer: asyncio.StreamWriter | None = None
        # When the connection began, and when drivers were asked last (monotonic).
        self._began_ns = 0
        self._pinged_ns = 0
        setups = {device.indi: device.setup for device in scope.devices.values() if device.setup}
        # Outlives a connection: who was disconnected by a person stays so.
        self._connections = DriverConnections(setups, connect=settings.connect)
        self._answers = DriverAnswers(self._tree, self._send_bytes, self._record_event)
        self._commands = CommandsUnderWay(self._tree, self._send_bytes)
        self._pictures = PictureReception(self._names, self._tree, context, self._send_bytes)
        self._readings = SignalReadings(scope, self._tree, context.clock, context.samples)
        self._found = FoundDevices(scope, settings, self._connections, status)

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        where = f"{self._settings.host}:{self._settings.port}"
        try:
            async with asyncio.timeout(OPEN_S):
                reader, writer = await asyncio.open_connection(
                    self._settings.host, self._settings.port, limit=READ_BYTES
                )
        except (OSError, TimeoutError) as error:
            reason = str(error) or "no answer"
            raise AdapterLost(f"the INDI server {where} cannot be reached: {reason}") from error
        _keep_alive(writer)
        self._begin_connection(writer)
        self._status.up()
        tasks = [
            asyncio.ensure_future(self._read_events(reader)),
            asyncio.ensure_future(self._tick_loop()),
        ]
        try:
            # Reading ends with the connection; ticking ends only by an error.
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        except (OSError, IndiError) as error:
            raise AdapterLost(f"the INDI server {where} was lost: {error}") from error
        finally:
            for task in tasks:
                task.cancel()
            # Before anything is awaited: by the time that `run` raises, all has been told.
            self._end_connection()
            # Not closed in good order: a stuck server would hold that up.
            writer.transport.abort()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._pictures.drop_picture()
        raise AdapterLost(f"the INDI server {where} closed the connection")

    def watch(self, streams: Collection[str]) -> None:
        """Take no pictures of its own accord: a camera here is asked for each one."""

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._readings.latest_of(address)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Tell nobody: nothing here is driven."""

    def stop(self, device: str, *, stopped: bool) -> None:
        """Abort whatever the device is doing."""
        name = self._devices.get(device, "")
        found = self._tree.devices.get(name)
        # INDI knows no state of being stopped, so there is nothing to release.
        if not stopped or found is None:
            return
        for held in found.vectors.values():
            # Dome, telescope, focuser, rotator: each has its own (DOME_ABORT_MOTION, ...).
            if (
                held.name.endswith(("ABORT_MOTION", "ABORT_EXPOSURE"))
                and held.kind is VectorKind.SWITCH
            ):
                self._send_bytes(new_vector(VectorKind.SWITCH, name, held.name, {"ABORT": True}))

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        now_ns = self._clock.monotonic_ns()
        if self._writer is None:
            done(CommandOutcome(CommandPhase.REFUSED, "the INDI server is not connected"))
            return None
        described = self._scope.devices[device]
        target = described.commands[command].target
        cancel = self._commands.begin_command(
            device=described.indi, target=target, fields=fields, now_ns=now_ns, done=done
        )
        if cancel is not None and target == "CONNECTION":
            # Who disconnects a driver by hand must not find it connected again by us.
            connect = fields.get("CONNECT") is True or fields.get(CHOICE) in ("CONNECT", "Connect")
            self._connections.set_wanted(described.indi, connect=connect, now_ns=now_ns)
        return cancel

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`: asks for all its properties, and connects its driver."""
        name = self._devices.get(device, "")
        if self._writer is None:
            done(CommandOutcome(CommandPhase.FAILED, "the INDI server is not connected"))
            return
        self._connections.connect_again(name)
        self._send_bytes(ask_properties(name))
        self._commands.await_connection(name, self._clock.monotonic_ns(), done)

    # ── the connection ──

    def _begin_connection(self, writer: asyncio.StreamWriter) -> None:
        self._tree.forget_all()
        self._writer = writer
        self._connections.restart()
        self._answers.restart()
        self._pictures.restart()
        self._began_ns = self._pinged_ns = self._clock.monotonic_ns()
        self._found.note_change(self._began_ns)
        # Until it is asked, a server says nothing at all.
        self._send_bytes(ask_properties())

    def _end_connection(self) -> None:
        """The server is gone: nothing is known any more, and nobody will answer."""
        self._writer = None
        self._tree.forget_all()
        self._commands.lose_all()
        self._readings.forget_all()

    def _send_bytes(self, data: bytes) -> None:
        writer = self._writer
        if writer is None or not data:
            return
        writer.write(data)
        # Never awaited: a server that reads nothing must hold up no reading of ours.
        if writer.transport.get_write_buffer_size() > MAX_UNSENT:
            log.warning("the INDI server reads nothing any more; connecting anew")
            writer.transport.abort()

    # ── from the server ──

    async def _read_events(self, reader: asyncio.StreamReader) -> None:
        parser = IndiParser()
        while data := await reader.read(READ_BYTES):
            touched: set[str] = set()
            now_ns = self._clock.monotonic_ns()
            for event in parser.parse_data(data):
                match event:
                    case BlobHead():
                        await self._pictures.begin_picture(event)
                    case BlobPart():
                        await self._pictures.write_part(event)
                    case BlobEnd():
                        ended = await self._pictures.end_picture(event)
                        if ended is not None:
                            camera, problem = ended
                            self._commands.picture_ended(
                                camera, problem, self._clock.monotonic_ns()
                            )
                    case _:
                        touched.add(event.device)
                        self._apply_event(event, now_ns)
            # Once for all that came together: a burst of properties is one batch of samples.
            self._readings.publish_devices(touched)

    def _apply_event(self, event: Vector | Deleted | DriverMessage, now_ns: int) -> None:
        known = (
            self._tree.find_vector(event.device, event.name) if isinstance(event, Vector) else None
        )
        held = self._tree.apply_event(event, now_ns)
        if held is not None and known is None:
            self._found.note_change(now_ns)
            if held.name == "CONNECTION":
                # Started anew by its server, within milliseconds of its crash.
                self._connections.redefine(held.device)
                self._pictures.redefine(held.device)
        if isinstance(event, Vector) and event.kind is VectorKind.BLOB and event.new:
            self._pictures.ask_camera(event.device)
        if isinstance(event, DriverMessage):
            log.debug("%s: %s", event.device, event.message)
        # After each event and not after all: a state may pass within one burst (Busy, then Ok).
        self._commands.follow_commands(now_ns, event.device)

    # ── what goes by time ──

    async def _tick_loop(self) -> None:
        while True:
            await asyncio.sleep(TICK_S)
            now_ns = self._clock.monotonic_ns()
            if now_ns - self._pinged_ns >= PING_NS:
                self._pinged_ns = now_ns
                self._answers.ask_drivers(now_ns)
            self._connect_drivers(now_ns)
            self._commands.follow_commands(now_ns)
            self._commands.answer_reconnections(now_ns)
            self._report_presence(now_ns)
            self._found.report_found(self._tree, now_ns)
            self._readings.publish_all()

    def _connect_drivers(self, now_ns: int) -> None:
        """Connect drivers, and set up those that are; see `DriverConnections`."""
        for device in self._tree:
            # Another's devices on the same server are left as they are.
            if not self._found.is_served(device.name):
                continue
            for due in self._connections.next_actions(device, now_ns):
                if isinstance(due, bytes):
                    self._send_bytes(due)
                    continue
                log.warning("%s: %s: %s", device.name, due.kind, due.message)
                self._record_event(due.kind, device.name, due.message, good=False)

    def _report_presence(self, now_ns: int) -> None:
        # Drivers need some seconds to define themselves; until then nobody is absent.
        if now_ns - self._began_ns < SETTLE_NS:
            return
        for described, name in self._devices.items():
            device = self._tree.devices.get(name)
            why = ""
            if device is None:
                why = f"the INDI server has no device {name!r}"
            elif self._answers.is_silent(name):
                why = "its driver does not answer"
            elif "CONNECTION" in device.vectors and not device.connected:
                why = "its driver is not connected to its hardware"
                if self._connections.is_left(name):
                    why = "somebody has disconnected its driver from its hardware"
            self._status.device(described, there=not why, why=why)

    def _record_event(self, kind: str, device: str, message: str, *, good: bool) -> None:
        described = self._names.get(device, "")
        self._events.report_event(kind, f"{device}: {message}", device=described, good=good)


def _keep_alive(writer: asyncio.StreamWriter) -> None:
    """Let the kernel end a connection whose other side has vanished without a word."""
    sock: socket.socket | None = writer.get_extra_info("socket")
    if sock is None:
        return
    # Small frames (a STOP) must not wait for others to fill a packet.
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    # Linux ends an idle connection by the first three (tcp(7)), one with unread words of ours by
    # the last; with its own defaults that takes hours.
    for option, value in (
        ("TCP_KEEPIDLE", 2),
        ("TCP_KEEPINTVL", 1),
        ("TCP_KEEPCNT", _SILENT_TCP_S - 2),
        ("TCP_USER_TIMEOUT", _SILENT_TCP_S * 1000),
    ):
        if hasattr(socket, option):
            sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
