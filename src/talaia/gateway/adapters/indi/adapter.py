"""The INDI adapter: one server's devices as signals and commands.

A small client of our own over asyncio's streams. It must see the end of the connection at once:
`indipyclient` 0.9.4 noticed a killed server after 40 s, this one in some milliseconds (see
docs/decisions/0043). All that decides stands in the modules beside; here bytes come and go.

Long, because reading, asking and the age of what was read scope one book.
"""

from __future__ import annotations

import asyncio
import logging
import math
import socket
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.discovery import devices_of
from talaia.gateway.adapters.indi.driver_connections import DriverConnections
from talaia.gateway.adapters.indi.errors import IndiError
from talaia.gateway.adapters.indi.fits_circumstances import circumstances
from talaia.gateway.adapters.indi.goals import CHOICE, SILENT_NS, IndiGoal, begin
from talaia.gateway.adapters.indi.protocol import (
    BlobEnd,
    BlobHead,
    BlobPart,
    DriverMessage,
    IndiParser,
    Vector,
    VectorKind,
    ask_blobs,
    ask_properties,
    new_vector,
)
from talaia.gateway.adapters.indi.standard_properties import (
    read_number,
    read_state,
    read_text,
    stamp_of,
)
from talaia.gateway.adapters.indi.state import IndiDeviceTree
from talaia.gateway.errors import AdapterLost
from talaia.gateway.fits.header import rewritten, values_of
from talaia.gateway.ports import ChannelReading, CommandOutcome
from talaia.model.connection import IndiConnection, IndiSource, source_as
from talaia.model.site import SignalType
from talaia.wire.columns import Columns
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.indi.state import IndiDevice
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.model.site import Device, Signal
    from talaia.wire.frames import Scalar

__all__ = ["IndiAdapter"]

log = logging.getLogger(__name__)
OPEN_S = 5.0
TICK_S = 0.25
READ_BYTES = 256 * 1024
# What a server may leave unread before we take it as stuck.
MAX_UNSENT = 1024 * 1024
PING_NS = SECOND
# Who is not there by then is told as absent.
SETTLE_NS = 3 * SECOND
# Drivers define their properties in bursts; after so long without one, that was all.
QUIET_NS = 2 * SECOND
# A server that has vanished without a word (power cut, cable) ends the connection after this.
_SILENT_TCP_S = 6
_MAX_TEXT = 2000


class _Plan(NamedTuple):
    """One signal: what is read, and where it goes."""

    address: str
    channel: int
    device: str
    signal: Signal
    source: IndiSource
    tapped: bool


class _Last:
    """What was given out of one signal."""

    __slots__ = ("at_ns", "value")

    def __init__(self) -> None:
        self.value: float | str | None = None
        self.at_ns = 0


class _Under(NamedTuple):
    """A command under way."""

    goal: IndiGoal
    done: Callable[[CommandOutcome], None]


class IndiAdapter:
    """An `Adapter` for the devices of one INDI server. See `talaia.gateway.ports`."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what it serves, where things go, and where it says how its side stands."""
        assert isinstance(scope.connection, IndiConnection)  # noqa: S101 - the catalogue's promise
        self._scope, self._status = scope, status
        self._connection = scope.connection
        self._clock, self._samples = context.clock, context.samples
        self._events, self._frames = context.events, context.frames
        self._site = context.site
        self.book = IndiDeviceTree()
        self._plans = _plans(scope)
        self._devices = {name: device.indi for name, device in scope.devices.items() if device.indi}
        self._last = {plan.address: _Last() for plan in self._plans}
        self._latest: dict[str, ChannelReading] = {}
        self._under: list[_Under] = []
        self._writer: asyncio.StreamWriter | None = None
        self._began_ns = 0
        self._pinged_ns = 0
        self._changed_ns = 0
        setups = {device.indi: device.setup for device in scope.devices.values() if device.setup}
        self._connections = DriverConnections(setups, connect=self._connection.connect)
        self._silent: set[str] = set()
        self._asked_blobs: set[str] = set()
        self._shooting = ""
        self._waiting: list[tuple[str, int, Callable[[CommandOutcome], None]]] = []
        self._told: dict[str, Device] = {}

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        where = f"{self._connection.host}:{self._connection.port}"
        try:
            async with asyncio.timeout(OPEN_S):
                reader, writer = await asyncio.open_connection(
                    self._connection.host, self._connection.port, limit=READ_BYTES
                )
        except (OSError, TimeoutError) as error:
            reason = str(error) or "no answer"
            raise AdapterLost(f"the INDI server {where} cannot be reached: {reason}") from error
        _keep_alive(writer)
        self._begin(writer)
        self._status.up()
        tasks = [asyncio.ensure_future(self._read(reader)), asyncio.ensure_future(self._tick())]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        except (OSError, IndiError) as error:
            raise AdapterLost(f"the INDI server {where} was lost: {error}") from error
        finally:
            for task in tasks:
                task.cancel()
            self._lose()
            writer.transport.abort()
            await asyncio.gather(*tasks, return_exceptions=True)
            if self._frames is not None:
                await self._frames.drop()
        raise AdapterLost(f"the INDI server {where} closed the connection")

    def watch(self, streams: Collection[str]) -> None:
        """Take no pictures of its own accord: a camera here is asked for each one."""

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def drive(self, device: str, linear: float, angular: float, key: str = "") -> None:
        """Tell nobody: nothing here is driven."""

    def stop(self, device: str, *, stopped: bool) -> None:
        """Abort whatever the device is doing."""
        name = self._devices.get(device, "")
        found = self.book.devices.get(name)
        if not stopped or found is None:
            return
        for held in found.vectors.values():
            if (
                held.name.endswith(("ABORT_MOTION", "ABORT_EXPOSURE"))
                and held.kind is VectorKind.SWITCH
            ):
                self._send(new_vector(VectorKind.SWITCH, name, held.name, {"ABORT": True}))

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
        goal = begin(
            book=self.book, device=described.indi, target=target, fields=fields, now_ns=now_ns
        )
        if isinstance(goal, str):
            done(CommandOutcome(CommandPhase.REFUSED, goal))
            return None
        try:
            data = goal.sends(self.book)
        except ValueError as error:
            done(CommandOutcome(CommandPhase.REFUSED, str(error)))
            return None
        if target == "CONNECTION":
            connect = fields.get("CONNECT") is True or fields.get(CHOICE) in ("CONNECT", "Connect")
            self._connections.command(described.indi, connect=connect, now_ns=now_ns)
        under = _Under(goal, done)
        self._under.append(under)
        self._send(data)
        return lambda: self._cancel(under)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`: asks for all its properties, and connects its driver."""
        name = self._devices.get(device, "")
        if self._writer is None:
            done(CommandOutcome(CommandPhase.FAILED, "the INDI server is not connected"))
            return
        self._connections.connect_again(name)
        self._send(ask_properties(name))
        self._waiting.append((name, self._clock.monotonic_ns() + 5 * SECOND, done))

    # ── the connection ──

    def _begin(self, writer: asyncio.StreamWriter) -> None:
        self.book.clear()
        self._writer = writer
        self._connections.restart()
        self._silent.clear()
        self._asked_blobs.clear()
        self._began_ns = self._pinged_ns = self._changed_ns = self._clock.monotonic_ns()
        self._send(ask_properties())

    def _lose(self) -> None:
        """The server is gone: nothing is known any more, and nobody will answer."""
        self._writer = None
        self.book.clear()
        for under in self._under:
            gone = "the INDI server went away meanwhile; look at the device"
            under.done(CommandOutcome(CommandPhase.UNKNOWN, gone))
        self._under.clear()
        for _, _, done in self._waiting:
            done(CommandOutcome(CommandPhase.FAILED, "the INDI server went away meanwhile"))
        self._waiting.clear()
        self._publish_values(self._plans)
        self._latest.clear()

    def _send(self, data: bytes) -> None:
        writer = self._writer
        if writer is None or not data:
            return
        writer.write(data)
        if writer.transport.get_write_buffer_size() > MAX_UNSENT:
            log.warning("the INDI server reads nothing any more; connecting anew")
            writer.transport.abort()

    async def _read(self, reader: asyncio.StreamReader) -> None:
        words = IndiParser()
        while data := await reader.read(READ_BYTES):
            touched: set[str] = set()
            now_ns = self._clock.monotonic_ns()
            for event in words.feed(data):
                match event:
                    case BlobHead():
                        await self._shoot(event)
                    case BlobPart():
                        if self._shooting and self._frames is not None:
                            await self._frames.write(event.data)
                    case BlobEnd():
                        await self._shot(event)
                    case _:
                        before = isinstance(event, Vector) and self.book.get(
                            event.device, event.name
                        )
                        held = self.book.apply(event, now_ns)
                        if held is not None and before is None:
                            self._changed_ns = now_ns
                            if held.name == "CONNECTION":
                                # Started anew by its server, within milliseconds of its crash.
                                self._connections.redefine(held.device)
                                self._asked_blobs.discard(held.device)
                        touched.add(event.device)
                        if (
                            isinstance(event, Vector)
                            and event.kind is VectorKind.BLOB
                            and event.new
                        ):
                            self._want_pictures(event.device)
                        if isinstance(event, DriverMessage):
                            log.debug("%s: %s", event.device, event.message)
                        self._follow_commands(now_ns, event.device)
            self._publish_values(
                plan for plan in self._plans if plan.device in touched or "" in touched
            )

    async def _tick(self) -> None:
        while True:
            await asyncio.sleep(TICK_S)
            now_ns = self._clock.monotonic_ns()
            if now_ns - self._pinged_ns >= PING_NS:
                self._pinged_ns = now_ns
                self._ping(now_ns)
            self._connect(now_ns)
            self._follow_commands(now_ns)
            self._answer_waiting(now_ns)
            self._say_who_is_there(now_ns)
            self._find(now_ns)
            self._publish_values(self._plans)

    def _ping(self, now_ns: int) -> None:
        """Ask every driver for one property: an answer says that it lives, and no more."""
        for device in self.book:
            name = (
                "CONNECTION" if "CONNECTION" in device.vectors else next(iter(device.vectors), "")
            )
            self._send(ask_properties(device.name, name))
            silent = now_ns - device.heard_ns > SILENT_NS
            if silent == (device.name in self._silent):
                continue
            if silent:
                self._silent.add(device.name)
                log.warning("the INDI driver of %s does not answer", device.name)
                self._record_event(
                    "driver_silent", device.name, "its driver does not answer", good=False
                )
            else:
                self._silent.discard(device.name)
                log.info("the INDI driver of %s answers again", device.name)
                self._record_event(
                    "driver_back", device.name, "its driver answers again", good=True
                )
        # One with nothing to ask for: what comes later is asked for anew.
        if not self.book.devices:
            self._send(ask_properties())

    def _record_event(self, kind: str, name: str, message: str, *, good: bool) -> None:
        ours = next((device for device, indi in self._devices.items() if indi == name), "")
        self._events.report_event(kind, f"{name}: {message}", device=ours, good=good)

    def _connect(self, now_ns: int) -> None:
        """Connect drivers, and set up those that are; see `DriverConnections`."""
        for device in self.book:
            if not self._is_ours(device):
                continue
            for due in self._connections.step(device, now_ns):
                if isinstance(due, bytes):
                    self._send(due)
                    continue
                log.warning("%s: %s: %s", device.name, due.kind, due.message)
                self._record_event(due.kind, device.name, due.message, good=False)

    def _say_who_is_there(self, now_ns: int) -> None:
        if now_ns - self._began_ns < SETTLE_NS:
            return
        for ours, name in self._devices.items():
            device = self.book.devices.get(name)
            why = ""
            if device is None:
                why = f"the INDI server has no device {name!r}"
            elif name in self._silent:
                why = "its driver does not answer"
            elif "CONNECTION" in device.vectors and not device.connected:
                why = "its driver is not connected to its hardware"
                if self._connections.is_left(name):
                    why = "somebody has disconnected its driver from its hardware"
            self._status.device(ours, there=not why, why=why)

    def _find(self, now_ns: int) -> None:
        """Tell of devices that are not described, once nothing new has come for a while."""
        if not self._connection.discover or now_ns - self._changed_ns < QUIET_NS:
            return
        named = set(self._devices.values())
        found = [
            device
            for device in self.book
            if self._is_ours(device)
            and (
                device.connected
                or "CONNECTION" not in device.vectors
                or self._connections.tried(device.name) > 1
                or not self._connection.connect
            )
        ]
        new = devices_of(
            [other for other in found if other.name not in named], self._scope.name, self._devices
        )
        grown = self._grown([other for other in found if other.name in named])
        told = {**new, **grown}
        if told and told != self._told:
            self._told = told
            self._status.found(told)

    def _grown(self, found: list[IndiDevice]) -> dict[str, Device]:
        """Give those that have more than when they were found: a driver connected only now."""
        names = {indi: ours for ours, indi in self._devices.items()}
        grown = {}
        for device in found:
            ours = names[device.name]
            known = self._scope.devices[ours]
            now = next(iter(devices_of([device], self._scope.name).values()), None)
            if now is None or not (
                now.signals.keys() - known.signals.keys()
                or now.commands.keys() - known.commands.keys()
            ):
                continue
            grown[ours] = msgspec.structs.replace(
                known,
                kind=now.kind,
                signals={**known.signals, **now.signals},
                commands={**known.commands, **now.commands},
            )
        return grown

    def _is_ours(self, device: IndiDevice) -> bool:
        if device.name in self._devices.values():
            return True
        wanted = self._connection.devices
        return self._connection.discover and (not wanted or device.name in wanted)

    # ── commands ──

    def _follow_commands(self, now_ns: int, device: str = "") -> None:
        for under in list(self._under):
            if device and under.goal.device != device:
                continue
            outcome = under.goal.evaluate_progress(self.book, now_ns)
            if outcome is None:
                continue
            under.done(outcome)
            if outcome.phase is not CommandPhase.RUNNING:
                self._under.remove(under)

    def _cancel(self, under: _Under) -> None:
        if under in self._under:
            self._send(under.goal.cancel(self.book))

    def _answer_waiting(self, now_ns: int) -> None:
        for waiter in list(self._waiting):
            name, due_ns, done = waiter
            device = self.book.devices.get(name)
            if device is not None and device.connected:
                done(CommandOutcome(CommandPhase.SUCCEEDED, f"the driver of {name} is connected"))
            elif now_ns >= due_ns:
                problem = "is not there" if device is None else "is not connected"
                done(CommandOutcome(CommandPhase.FAILED, f"the driver of {name} {problem}"))
            else:
                continue
            self._waiting.remove(waiter)

    # ── pictures ──

    def _want_pictures(self, device: str) -> None:
        if self._frames is not None and device not in self._asked_blobs:
            self._asked_blobs.add(device)
            self._send(ask_blobs(device))

    async def _shoot(self, head: BlobHead) -> None:
        ours = next((device for device, indi in self._devices.items() if indi == head.device), "")
        self._shooting = ""
        if self._frames is not None and ours and head.size > 0:
            self._shooting = head.device
            await self._frames.begin(
                ours, head.format, head.size, partial(self._complete, ours, head.device)
            )

    def _complete(self, ours: str, camera: str, header: bytes) -> bytes:
        """Write into a picture's header what all devices say now."""
        unix_s = self._clock.wall_ns() / 1e9
        known = values_of(header)
        return rewritten(
            header,
            circumstances(
                book=self.book,
                camera=camera,
                site=self._site,
                address=ours,
                header=known,
                unix_s=unix_s,
            ),
        )

    async def _shot(self, end: BlobEnd) -> None:
        if not self._shooting or self._frames is None:
            return
        problem = await self._frames.end(end.problem)
        for under in self._under:
            if under.goal.device == self._shooting:
                under.goal.picture(problem)
        self._follow_commands(self._clock.monotonic_ns(), self._shooting)
        self._shooting = ""

    # ── readings ──

    def _publish_values(self, plans: Iterable[_Plan]) -> None:
        """Give out what is new, and repeat what still holds before it looks old."""
        now_ns, wall_us = self._clock.monotonic_ns(), self._clock.wall_ns() // 1000
        channels: list[int] = []
        values: list[float] = []
        texts: dict[int, str] = {}
        for plan in plans:
            value = self._value(plan, now_ns)
            last = self._last[plan.address]
            if not self._is_news(plan, last, value, now_ns):
                continue
            last.value, last.at_ns = value, now_ns
            if isinstance(value, str):
                texts[len(channels)] = value
            channels.append(plan.channel)
            values.append(math.nan if isinstance(value, str) else value)
        if channels:
            self._samples.put_samples(
                Columns(
                    np.array(channels, np.uint16),
                    np.full(len(channels), wall_us, np.int64),
                    np.array(values, np.float64),
                    texts,
                )
            )

    def _value(self, plan: _Plan, now_ns: int) -> float | str:
        """Give a signal's value now; NaN, or the empty text, where it is not known."""
        signal, source = plan.signal, plan.source
        device, element = source.device or plan.device, source.element
        if signal.type is SignalType.TEXT:
            found = read_text(self.book, device, source.property, element)
        elif signal.type is SignalType.STATE:
            found = read_state(
                book=self.book,
                device=device,
                name=source.property,
                element=element,
                states=signal.states,
            )
        else:
            found = read_number(self.book, device, source.property, element)
        unknown = found is None or now_ns - found.mono_ns > round(signal.max_age * SECOND)
        if signal.type is SignalType.TEXT:
            return "" if found is None or unknown else str(found.value)[:_MAX_TEXT]
        if found is None or unknown:
            if found is None:
                # As if there never was one. One that is too old stays, and its age tells.
                self._latest.pop(plan.address, None)
            return math.nan
        value = float(found.value) * (signal.scale if signal.type is SignalType.NUMBER else 1.0)
        if plan.tapped:
            self._tap(plan, device, value, found.mono_ns)
        return value

    def _tap(self, plan: _Plan, device: str, value: float, mono_ns: int) -> None:
        """Keep a reading that safety depends on; with a stamp, from when that advanced."""
        source = plan.source
        if not source.stamp:
            self._latest[plan.address] = ChannelReading(value, mono_ns)
            return
        stamp = stamp_of(self.book, device, source.property)
        if stamp is None:
            return
        advanced_ns = stamp.arrived_ns if source.synchronized else stamp.advanced_ns
        if advanced_ns is None:
            self._latest.pop(plan.address, None)
        else:
            true_ns = min(mono_ns, advanced_ns)
            self._latest[plan.address] = ChannelReading(value, true_ns, stamp.stamp_ns, mono_ns)

    @staticmethod
    def _is_news(plan: _Plan, last: _Last, value: float | str, now_ns: int) -> bool:
        if last.value is None:
            # Nothing was ever known, and nothing is: no news.
            return value not in ("",) and value == value
        since = now_ns - last.at_ns
        if isinstance(value, str) or isinstance(last.value, str):
            changed = value != last.value
        elif math.isnan(value) or math.isnan(last.value):
            changed = math.isnan(value) != math.isnan(last.value)
            if not changed:
                return False  # unknown is said once
        else:
            changed = abs(value - last.value) > plan.signal.deadband or (
                plan.signal.deadband == 0 and value != last.value
            )
            rate = plan.signal.max_rate
            if changed and rate > 0 and since < SECOND / rate:
                return False  # the next tick takes it up
        if value == "" and not changed:
            return False
        return changed or since >= plan.signal.max_age * SECOND / 2


def _plans(scope: ConnectionScope) -> list[_Plan]:
    return [
        _Plan(
            f"{name}/{signal_name}",
            scope.channel[f"{name}/{signal_name}"],
            source_as(signal.source, IndiSource).device or device.indi,
            signal,
            source_as(signal.source, IndiSource),
            f"{name}/{signal_name}" in scope.guarded,
        )
        for name, device in scope.devices.items()
        for signal_name, signal in device.signals.items()
    ]


def _keep_alive(writer: asyncio.StreamWriter) -> None:
    """Let the kernel end a connection whose other side has vanished without a word."""
    sock: socket.socket | None = writer.get_extra_info("socket")
    if sock is None:
        return
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in (
        ("TCP_KEEPIDLE", 2),
        ("TCP_KEEPINTVL", 1),
        ("TCP_KEEPCNT", _SILENT_TCP_S - 2),
        ("TCP_USER_TIMEOUT", _SILENT_TCP_S * 1000),
    ):
        if hasattr(socket, option):
            sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
