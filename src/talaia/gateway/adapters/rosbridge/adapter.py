"""The rosbridge adapter: the same over a rosbridge server, where nothing can be installed.

The protocol is in `rosbridge_protocol`. A server cannot be told what to say when we are gone: if
this process dies the robot hears nothing more, and its own time-out must stop it. Long, because
one socket carries all of it.
"""

from __future__ import annotations

import asyncio
import logging
import os
import ssl
from collections import deque
from itertools import count
from typing import TYPE_CHECKING

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from talaia.gateway.adapters.reconnection import rejoined
from talaia.gateway.adapters.rosbridge.protocol import (
    bytes_of,
    ended,
    frame,
    nested,
    progress_of,
    read,
    type_for,
)
from talaia.gateway.adapters.topic_readers import SampleBuffer, plans_of
from talaia.gateway.adapters.unreadable import UnreadableReports
from talaia.gateway.adapters.velocity import velocity_fields
from talaia.gateway.errors import AdapterLost, FieldError, SettingsError
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.video.camera import PictureStream
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import RosbridgeConnection, RosSource, source_as, topic_of
from talaia.model.site import CommandKind
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection
    from pathlib import Path

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.rosbridge.protocol import ServerMessage
    from talaia.gateway.ports import AdapterContext, AdapterStatus, ChannelReading
    from talaia.model.site import Command, Stream
    from talaia.wire.frames import Scalar

__all__ = ["RosbridgeAdapter"]

log = logging.getLogger(__name__)
BOOL = "std_msgs/msg/Bool"
_MAX_FRAME = 32 * 1024 * 1024
# Larger frames are read on another thread: driving must not wait behind a picture.
_LARGE = 64 * 1024
_PING_S, _PONG_S, _OPEN_S = 0.7, 1.2, 3.0
_TURN_S = 0.1
_AGAIN_S = 3.0
_MAX_WAITING = 1000
MAX_PENDING = 1000
_CUT = "the connection was lost; look at the device to see what it did"


class _Call:
    """A command that waits for its end."""

    def __init__(self, command: Command, done: Callable[[CommandOutcome], None]) -> None:
        self.command = command
        self.done = done


class RosbridgeAdapter:
    """An `Adapter` for ROS behind a rosbridge server; see `talaia.gateway.ports`."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be served and where things go; `run` connects.

        Raises:
            SettingsError: the token or the certificate authorities cannot be read.

        """
        settings = scope.connection
        assert isinstance(settings, RosbridgeConnection)  # noqa: S101 - the catalog has seen to it
        self._settings = settings
        self._scope, self._status = scope, status
        self._clock = context.clock
        self._samples = context.samples
        self._unreadable = UnreadableReports(context.events)
        self._pictures = context.pictures
        self._headers, self._tls = _trust(settings, context.folder)
        self._latest: dict[str, ChannelReading] = {}
        self._gathered = SampleBuffer()
        self._plans = {
            (plan.topic, plan.type_name): plan
            for plan in plans_of(scope, self._latest, self._unreadable.report)
        }
        self._by_topic = {plan.topic: plan for plan in self._plans.values()}
        self._streams: dict[str, Stream] = {
            f"{device_id}/{stream_id}": stream
            for device_id, device in scope.devices.items()
            for stream_id, stream in device.streams.items()
        }
        self._takers: dict[str, dict[str, PictureStream]] = {}
        self._watched: frozenset[str] = frozenset()
        self._worker: PictureWorker | None = None
        self._connected = False
        self._wake = asyncio.Event()
        # Of velocities only the newest is worth sending.
        self._newest: dict[str, str] = {}
        self._waiting: deque[str] = deque()
        self._calls = count(1)
        self._pending: dict[str, _Call] = {}
        self._heard: set[str] = set()

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        where = self._settings.url
        worker = self._worker = PictureWorker(self._pictures, self._clock)
        worker.start()
        try:
            async with connect(
                where,
                additional_headers=self._headers,
                ssl=self._tls,
                ping_interval=_PING_S,
                ping_timeout=_PONG_S,
                open_timeout=_OPEN_S,
                close_timeout=0.5,
                max_size=_MAX_FRAME,
                compression=None,
                proxy=None,
            ) as socket:
                await self._talk(socket)
        except ConnectionClosed as error:
            raise AdapterLost(f"the rosbridge server at {where} is gone ({error})") from error
        except (OSError, TimeoutError, WebSocketException) as error:
            why = str(error) or type(error).__name__
            raise AdapterLost(f"no rosbridge server answers at {where} ({why})") from error
        finally:
            self._connected = False
            self._latest.clear()
            self._waiting.clear()
            self._newest.clear()
            self._fail_pending()
            await asyncio.get_running_loop().run_in_executor(None, worker.close)
        raise AdapterLost(f"the rosbridge server at {where} closed the connection")

    async def _talk(self, socket: ClientConnection) -> None:
        self._takers.clear()
        self._heard.clear()
        self._connected = True
        self._describe()
        self._status.up()
        parts = [
            asyncio.ensure_future(part)
            for part in (self._listen(socket), self._write(socket), self._keep_pace())
        ]
        try:
            done, _ = await asyncio.wait(parts, return_when=asyncio.FIRST_COMPLETED)
            for part in done:
                part.result()
        finally:
            # What was said last (a zero) still goes out.
            for text in (*self._newest.values(), *self._waiting):
                try:
                    async with asyncio.timeout(0.2):
                        await socket.send(text)
                except (ConnectionClosed, TimeoutError):
                    break
            for part in parts:
                part.cancel()
            await asyncio.gather(*parts, return_exceptions=True)

    async def _listen(self, socket: ClientConnection) -> None:
        loop = asyncio.get_running_loop()
        async for data in socket:
            try:
                large = len(data) > _LARGE
                said = await loop.run_in_executor(None, read, data) if large else read(data)
                self._hear(said)
            except FieldError as error:
                self._unreadable.report_once("rosbridge", str(error))

    async def _write(self, socket: ClientConnection) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._newest or self._waiting:
                while self._newest:
                    await socket.send(self._newest.pop(next(iter(self._newest))))
                if self._waiting:
                    await socket.send(self._waiting.popleft())

    async def _keep_pace(self) -> None:
        loop = asyncio.get_running_loop()
        again = loop.time() + _AGAIN_S
        while True:
            await asyncio.sleep(_TURN_S)
            if loop.time() >= again:
                again = loop.time() + _AGAIN_S
                self._ask_again()
            now_us = self._clock.wall_ns() // 1000
            for plan in self._plans.values():
                plan.take_due(now_us, self._gathered)
            self._publish_samples()

    def _ask_again(self) -> None:
        """Subscribe anew what has never come.

        On ROS 2 a server offers the quality of service that fits who publishes at that moment;
        a robot that comes later, and sends best effort, would never be heard.
        """
        for plan in self._plans.values():
            if plan.topic not in self._heard:
                self._send_operation("unsubscribe", topic=plan.topic, id=f"signal {plan.topic}")
                self._subscribe(f"signal {plan.topic}", plan.topic, plan.type_name)

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        before, self._watched = self._watched, frozenset(streams)
        if not self._connected:
            return
        for address in sorted(before ^ self._watched):
            if address in self._watched:
                self._begin_stream(address)
            else:
                self._end_stream(address)

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def drive(self, device: str, linear: float, angular: float, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        described = self._scope.devices.get(device)
        if self._connected and described is not None and described.drive is not None:
            rule = described.drive
            fields = nested(velocity_fields(rule, linear, angular, key))
            said = frame("publish", topic=rule.topic, msg=fields)
            if key:
                # Characters may add up: none takes another's place.
                self._waiting.append(said)
            else:
                self._newest[f"drive {device}"] = said
            self._wake.set()

    def stop(self, device: str, *, stopped: bool) -> None:
        """See `CommandTarget.stop`."""
        described = self._scope.devices.get(device)
        if self._connected and described is not None and described.drive is not None:
            topic = described.drive.stop.topic
            if topic:
                said = frame("publish", topic=topic, msg={"data": stopped})
                self._newest[f"stop {device}"] = said
                self._wake.set()

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        if not self._connected:
            done(CommandOutcome(CommandPhase.REFUSED, "the robot is not connected"))
            return None
        described = self._scope.devices[device].commands[command]
        try:
            body = nested(fields)
        except FieldError as error:
            done(CommandOutcome(CommandPhase.REFUSED, str(error)))
            return None
        call, target = f"call {next(self._calls)}", described.target
        if described.kind is CommandKind.TOPIC:
            self._send_operation("publish", topic=target, msg=body)
            done(CommandOutcome(CommandPhase.SUCCEEDED, "published"))
            return None
        if described.kind is CommandKind.PARAMETER:
            done(CommandOutcome(CommandPhase.REFUSED, "a rosbridge sets no parameters"))
            return None
        if len(self._pending) >= MAX_PENDING:
            self._pending.pop(next(iter(self._pending)))
        self._pending[call] = _Call(described, done)
        kind = type_for(described.type, self._settings.ros)
        if described.kind is CommandKind.SERVICE:
            self._send_operation("call_service", id=call, service=target, type=kind, args=body)
            return None
        self._send_operation(
            "send_action_goal", id=call, action=target, action_type=kind, args=body, feedback=True
        )
        return lambda: self._send_operation("cancel_action_goal", id=call, action=target)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`. A server does not say who publishes, so nothing is absent."""
        described = self._scope.devices.get(device)
        if not self._connected or described is None:
            done(CommandOutcome(CommandPhase.FAILED, "the robot's side cannot be reached now"))
            return
        topics = {topic_of(signal.source) for signal in described.signals.values()}
        for plan in self._plans.values():
            if plan.topic in topics:
                self._send_operation("unsubscribe", topic=plan.topic, id=f"signal {plan.topic}")
                self._subscribe(f"signal {plan.topic}", plan.topic, plan.type_name)
        for address in sorted(self._watched & self._streams.keys()):
            if address.startswith(f"{device}/"):
                self._end_stream(address)
                self._begin_stream(address)
        done(rejoined(len(topics), []))

    # ── to the server ──

    def _send_operation(self, op: str, **what: object) -> None:
        if len(self._waiting) >= _MAX_WAITING:
            # A server that takes nothing for so long is noticed by its pings.
            self._waiting.popleft()
        self._waiting.append(frame(op, **what))
        self._wake.set()

    def _describe(self) -> None:
        for device in self._scope.devices.values():
            rule = device.drive
            if rule is not None:
                self._advertise(rule.topic, rule.message.value)
                if rule.stop.topic:
                    self._advertise(rule.stop.topic, BOOL, latch=True)
            for command in device.commands.values():
                if command.kind is CommandKind.TOPIC:
                    self._advertise(command.target, command.type)
        for plan in self._plans.values():
            self._subscribe(f"signal {plan.topic}", plan.topic, plan.type_name)
        for address in sorted(self._watched & self._streams.keys()):
            self._begin_stream(address)

    def _advertise(self, topic: str, type_name: str, *, latch: bool = False) -> None:
        kind = type_for(type_name, self._settings.ros)
        self._send_operation("advertise", topic=topic, type=kind, latch=latch, queue_size=1)

    def _subscribe(self, name: str, topic: str, type_name: str, **more: object) -> None:
        self._send_operation(
            "subscribe",
            id=name,
            topic=topic,
            type=type_for(type_name, self._settings.ros),
            **more,
        )

    def _begin_stream(self, address: str) -> None:
        stream = self._streams.get(address)
        if stream is None:
            return
        taker = PictureStream(address, stream, bytes_of, self._unreadable.report)
        source = source_as(stream.source, RosSource)
        self._takers.setdefault(source.topic, {})[address] = taker
        # A little sooner than shown, so that the two paces do not lose every other picture.
        # Only pictures as CBOR: a server on ROS 2 cannot write lists of fixed length that way (the
        # covariance of an odometry), and pictures are what is worth it.
        self._subscribe(
            f"stream {address}",
            source.topic,
            source.type,
            throttle_rate=int(700 / stream.max_rate),
            queue_length=1,
            compression="cbor" if self._settings.cbor else "none",
        )

    def _end_stream(self, address: str) -> None:
        stream = self._streams.get(address)
        if stream is not None:
            topic = topic_of(stream.source)
            self._takers.get(topic, {}).pop(address, None)
            self._send_operation("unsubscribe", id=f"stream {address}", topic=topic)

    # ── from the server ──

    def _hear(self, said: ServerMessage) -> None:
        match said.op:
            case "publish":
                self._read_message(said)
            case "service_response" | "action_result":
                call = self._pending.pop(said.id, None)
                if call is not None:
                    call.done(ended(said))
            case "action_feedback":
                call = self._pending.get(said.id)
                if call is not None:
                    call.done(progress_of(said, call.command))
            case "status":
                self._on_status(said)
            case _:
                log.debug("the server said %s", said.op)

    def _read_message(self, said: ServerMessage) -> None:
        plan = self._by_topic.get(said.topic)
        if plan is not None:
            self._heard.add(said.topic)
            now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
            plan.read_message(said.body, now_us, now_ns, self._gathered)
            self._publish_samples()
        if self._worker is not None:
            for taker in list(self._takers.get(said.topic, {}).values()):
                self._worker.offer(taker, said.body)

    def _publish_samples(self) -> None:
        columns = self._gathered.take_columns()
        if columns is not None:
            self._samples.put_samples(columns)

    def _on_status(self, said: ServerMessage) -> None:
        words = said.body if isinstance(said.body, str) else ""
        call = self._pending.pop(said.id, None) if said.level == "error" else None
        if call is not None:
            call.done(CommandOutcome(CommandPhase.FAILED, words[:2000]))
        elif said.level in {"error", "warning"}:
            self._unreadable.report_once(said.id or "rosbridge", words[:500])

    def _fail_pending(self) -> None:
        pending, self._pending = self._pending, {}
        for call in pending.values():
            call.done(CommandOutcome(CommandPhase.UNKNOWN, _CUT))


def _trust(
    settings: RosbridgeConnection, folder: Path
) -> tuple[dict[str, str], ssl.SSLContext | None]:
    """Read token and authorities. Nothing of them is written anywhere."""
    token = ""
    if settings.token_env:
        token = os.environ.get(settings.token_env, "").strip()
        if not token:
            raise SettingsError(f"the variable {settings.token_env} with the token is not set")
    elif settings.token_file:
        path = folder / settings.token_file
        try:
            token = path.read_text().strip()
        except (OSError, UnicodeDecodeError) as error:
            raise SettingsError(f"the token in {path} cannot be read: {error}") from error
    if not token.isprintable():
        raise SettingsError("the token of the rosbridge server is not one line of text")
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    if not settings.url.startswith("wss://"):
        return headers, None
    try:
        ca = str(folder / settings.ca) if settings.ca else None
        return headers, ssl.create_default_context(cafile=ca)
    except (OSError, ssl.SSLError) as error:
        raise SettingsError(f"the authorities in {settings.ca} cannot be read: {error}") from error
