"""The Socket.IO adapter: a server to which a robot's programs send, and which tells them nothing.

Programs of the founding vehicle's kind dial, with their sensed data and pictures. Nothing is driven
and nothing is commanded here: a character that waits for a poll comes whenever the program asks for
it, and none of its clients stops by itself when no other comes. See decision 0087.
"""

from __future__ import annotations

import asyncio
import ssl
from collections import Counter
from functools import partial
from typing import TYPE_CHECKING

from talaia.bounded_http import serve_bounded
from talaia.gateway.adapters.credentials import read_secret
from talaia.gateway.adapters.json_signals import JsonSignals
from talaia.gateway.adapters.socketio.engine_endpoint import EngineEndpoint
from talaia.gateway.adapters.socketio.event_data import (
    data_of,
    event_key,
    payload_of,
    pixels_of_event,
    place_of,
    sensors_in,
)
from talaia.gateway.adapters.undriven_adapter import JsonAdapter
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.errors import AdapterLost, SettingsError
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.video.camera import PictureStream
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import SocketioConnection, SocketioSource, source_as
from talaia.wire.frames import CommandPhase
from talaia.wire.socketio.engine_packets import MAX_SOCKETIO_BODY
from talaia.wire.socketio.founding_namespaces import NAMESPACES, PICTURES_IN, SENSED

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.model.site import Signal, Stream

__all__ = ["SocketioAdapter"]

# Pace at which held-back values are given out, and samples at most.
_TURN_S = 0.05
_SHORTEST_TOKEN = 16
# TCP connections at once.
_MOST_CONNECTIONS = 128
# Sensors that no signal is of, and which are told.
_MOST_NEW = 100
_NOBODY = "no program that sends it is connected"
_SENSED_PLACE, _PICTURE_PLACE = place_of(SENSED[0]), place_of(PICTURES_IN)


class SocketioAdapter(JsonAdapter):
    """An `Adapter` for programs that send by Socket.IO, and the `EventReceiver` of all of them."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be read; `run` listens.

        Raises:
            SettingsError: the token or the certificate cannot be read.

        """
        settings = scope.connection
        assert isinstance(settings, SocketioConnection)  # noqa: S101 - the catalog has seen to it
        self._settings = settings
        self._scope = scope
        self._status = status
        self._context = context
        self._clock = context.clock
        self._token = _read_token(settings, context)
        self._tls = _read_certificate(settings, context)
        self._unreadable = UnreadableReports(context.events)
        signals = JsonSignals(scope, _key_of_signal, self._unreadable.report_unreadable)
        super().__init__(signals, context.samples, "socketio")
        self._new_sensors: set[str] = set()
        # By address: where the pictures of each camera are sent, and how they are found there.
        self._cameras = {
            f"{device_id}/{stream_id}": _source_of_stream(stream)
            for device_id, device in scope.devices.items()
            for stream_id, stream in device.streams.items()
        }
        # Of those that somebody looks at.
        self._pictures: dict[str, PictureStream] = {}
        self._worker: PictureWorker | None = None
        self._endpoint: EngineEndpoint | None = None
        # By namespace: how many programs are in it; by device: the namespaces it is sent in.
        self._programs: Counter[str] = Counter()
        self._places_of = _places_of_devices(scope)
        described = {place for places in self._places_of.values() for place in places}
        self.places: Collection[str] = frozenset({*map(place_of, NAMESPACES), *described})

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        settings = self._settings
        endpoint = EngineEndpoint(
            token=self._token, receiver=self, clock=self._clock, events=self._context.events
        )
        self._worker = PictureWorker(self._context.pictures, self._clock, self._context.budget)
        self._worker.start()
        self._programs.clear()
        try:
            serving = serve_bounded(
                endpoint,
                settings.host,
                settings.port,
                most_connections=_MOST_CONNECTIONS,
                tls=self._tls,
                websocket_bytes=MAX_SOCKETIO_BODY,
            )
            async with serving:
                self._endpoint = endpoint
                self._status.up()
                for device in self._places_of:
                    self._report_device(device)
                try:
                    await self._keep_pace()
                finally:
                    await endpoint.end_lines()
        except OSError as error:
            where = f"{settings.host}:{settings.port}"
            raise AdapterLost(f"programs cannot be listened for at {where}: {error}") from error
        finally:
            self._endpoint = None
            self._signals.forget_readings()
            worker, self._worker = self._worker, None
            await asyncio.shield(asyncio.to_thread(worker.close))

    def watch(self, streams: Collection[str]) -> None:
        """Read pictures of these cameras alone."""
        for address in self._pictures.keys() - set(streams):
            del self._pictures[address]
        for address in self._cameras.keys() & (set(streams) - self._pictures.keys()):
            device, _, name = address.partition("/")
            self._pictures[address] = PictureStream(
                address,
                self._scope.devices[device].streams[name],
                partial(pixels_of_event, path=self._cameras[address].path),
                self._unreadable.report_unreadable,
            )

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """End the lines of all programs, which connect anew by themselves."""
        if self._endpoint is None:
            said = "the gateway does not listen; it is tried every second"
            done(CommandOutcome(CommandPhase.FAILED, said))
            return
        task = asyncio.ensure_future(self._endpoint.close_lines())
        said = "its programs were sent away, and are to connect anew"
        task.add_done_callback(lambda _: done(CommandOutcome(CommandPhase.SUCCEEDED, said)))

    async def _keep_pace(self) -> None:
        while True:
            await asyncio.sleep(_TURN_S)
            self._signals.gather_due(self._clock.wall_ns() // 1000)
            self._publish_samples()

    # ── EventReceiver ──

    def receive_event(self, place: str, event: str, args: Sequence[object], *, fresh: bool) -> str:
        """See `EventReceiver.receive_event`."""
        known = self._offer_picture(place, event, args)
        data, keys = data_of(args), self._signals.keys
        now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
        # Of any event of the namespace, and of this one.
        events = ("", event) if event else ("",)
        for name in events:
            key = event_key(place, name)
            if key in keys:
                known = True
                payload = payload_of(data)
                self._signals.read_parsed(key, payload, now_us, now_ns, fresh=fresh)
        unknown = ""
        for sensor, payload in sensors_in(data):
            found = [at for at in (event_key(place, name, sensor) for name in events) if at in keys]
            for key in found:
                self._signals.read_parsed(key, payload, now_us, now_ns, fresh=fresh)
            known = known or bool(found)
            unknown = unknown if found else sensor
        if unknown:
            self._report_sensor(place, unknown)
        if known:
            return ""
        what = f"sensor {unknown[:60]!r}" if unknown else f"event {event[:60]!r}"
        return f"{what} of {place} is in no source of the description; no commands are taken here"

    def count_program(self, place: str, change: int) -> None:
        """See `EventReceiver.count_program`."""
        self._programs[place] += change
        for device, places in self._places_of.items():
            if place in places:
                self._report_device(device)

    def describe_site(self) -> dict[str, object]:
        """Name what is read, in the words of the founding vehicle's configuration."""
        units: dict[str, str] = {}
        sensors: list[str] = []
        for device in self._scope.devices.values():
            for signal_id, signal in device.signals.items():
                name = source_as(signal.source, SocketioSource).name or signal_id
                sensors.append(name)
                units.update({name: signal.unit} if signal.unit else {})
        return {
            "name": self._context.site,
            "sensors": sensors,
            "units": units,
            "cameras": list(self._cameras),
            "vehicles": [],
        }

    def _offer_picture(self, place: str, event: str, args: Sequence[object]) -> bool:
        known = False
        for address, source in self._cameras.items():
            if place_of(source.namespace) != place or source.event not in {"", event}:
                continue
            known = True
            stream = self._pictures.get(address)
            if stream is not None and self._worker is not None:
                self._worker.offer_raw(stream, args[0] if len(args) == 1 else list(args))
        return known

    def _report_device(self, device: str) -> None:
        there = any(self._programs[place] > 0 for place in self._places_of[device])
        if not there:
            self._signals.forget_readings(device)
        self._status.device(device, there=there, why="" if there else _NOBODY)

    def _report_sensor(self, place: str, name: str) -> None:
        if name not in self._new_sensors and len(self._new_sensors) < _MOST_NEW:
            self._new_sensors.add(name)
            shown = name[:100]
            said = f"it is not in the description; add a signal with source: {{name: {shown}}}"
            self._unreadable.report_once(f"{place} {shown!r}", said)


def _source_of_stream(stream: Stream) -> SocketioSource:
    source = source_as(stream.source, SocketioSource)
    return SocketioSource(
        namespace=source.namespace or _PICTURE_PLACE, event=source.event, path=source.path
    )


def _place_of_signal(signal: Signal) -> str:
    return place_of(source_as(signal.source, SocketioSource).namespace or _SENSED_PLACE)


def _key_of_signal(signal: Signal) -> tuple[str, str]:
    source = source_as(signal.source, SocketioSource)
    key = event_key(_place_of_signal(signal), source.event, source.name)
    return key, source.path or ("magnitude" if source.name else "")


def _places_of_devices(scope: ConnectionScope) -> dict[str, frozenset[str]]:
    return {
        name: frozenset(
            [_place_of_signal(signal) for signal in device.signals.values()]
            + [place_of(_source_of_stream(stream).namespace) for stream in device.streams.values()]
        )
        for name, device in scope.devices.items()
    }


def _read_token(settings: SocketioConnection, context: AdapterContext) -> str:
    token = read_secret(
        "token", context.folder, file=settings.token_file, variable=settings.token_env
    )
    # Too short to be left open to guessing, even at one try a second.
    if len(token) < _SHORTEST_TOKEN:
        raise SettingsError(f"the token of programs has at least {_SHORTEST_TOKEN} letters")
    return token


def _read_certificate(
    settings: SocketioConnection, context: AdapterContext
) -> ssl.SSLContext | None:
    if not settings.certificate:
        return None
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    # TLS 1.0 and 1.1 are deprecated (RFC 8996).
    tls.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        tls.load_cert_chain(context.folder / settings.certificate, context.folder / settings.key)
    except (OSError, ssl.SSLError) as error:
        where = context.folder / settings.certificate
        raise SettingsError(f"the certificate {where} cannot be used: {error}") from error
    return tls
