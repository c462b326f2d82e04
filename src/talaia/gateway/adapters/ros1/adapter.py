"""The ROS 1 adapter: hears what the description names and tells the robot what it may be told.

rospy runs in a process of the machine's own Python (`bridge`), for it lives in no virtual
environment. Messages come raw with their definitions and are decoded here, so that any type can
be read without its package; to say something, the package must be there.

rospy does not register anew when the master has begun anew. So the master is asked twice a second
whether it still knows our node; if not, the node's process is ended (it says zeros first) and the
gateway begins again. Long, because the life of that process must be read together.
"""

from __future__ import annotations

import asyncio
import logging
import os
from itertools import count
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.reconnection import WAIT_S, rejoined
from talaia.gateway.adapters.ros1.decode import decoder_of, full_name
from talaia.gateway.adapters.ros1.frames import ReceivedMessage
from talaia.gateway.adapters.ros1.master import RosMaster
from talaia.gateway.adapters.ros1.node import NodeProcess
from talaia.gateway.adapters.ros1.presence import Ros1Presence
from talaia.gateway.adapters.topic_readers import (
    SampleBuffer,
    file_in,
    parameter_plans_of,
    plans_of,
)
from talaia.gateway.adapters.unreadable import UnreadableReports
from talaia.gateway.adapters.velocity import velocity_fields
from talaia.gateway.driving.drive_keys import HALT
from talaia.gateway.errors import AdapterLost, FieldError, TypeMissing
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.video.camera import PictureStream
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import Ros1Connection, RosSource, source_as, topic_of
from talaia.model.site import CommandKind, DriveMessage
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus, ChannelReading, FileSink
    from talaia.model.site import Command
    from talaia.wire.frames import Scalar

__all__ = ["Ros1Adapter"]

log = logging.getLogger(__name__)
# Messages that rospy keeps for a reader that is behind.
DEPTH = 1_000
_LOOK_S = 0.5
# Importing rospy takes seconds where the machine has other work, too.
_START_S = 30.0
# A node that has not shown a sign of life in so many looks hangs; until it has done what it is
# told first, each of which is a question to the master, it is given more.
_MISSES = 4
_MISSES_FIRST = 20
MAX_PENDING = 1000
BOOL = "std_msgs/msg/Bool"
_CUT = "the connection was lost; look at the device to see what it did"
_DEFAULT_MASTER = "http://localhost:11311"


class _Wanted(NamedTuple):
    """A topic that is listened to: who takes its messages, and how often they may come."""

    topic: str
    type_name: str
    take: Callable[[ReceivedMessage], None]
    rate: float = 0.0


class Ros1Adapter:
    """An `Adapter` for ROS 1. See `talaia.gateway.ports` for its promises."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be served and where things go; `run` joins ROS."""
        settings = scope.connection
        assert isinstance(settings, Ros1Connection)  # noqa: S101 - the catalog has seen to it
        self._settings = settings
        self._scope, self._status = scope, status
        self._clock = context.clock
        self._samples, self._events = context.samples, context.events
        self._unreadable = UnreadableReports(context.events)
        self._pictures = context.pictures
        self._raw, self._files = context.raw, context.files
        # By number: the type and its definition, as the publisher told them.
        self._told: dict[int, tuple[str, str]] = {}
        self._recorded: list[int] = []
        uri = settings.master or os.environ.get("ROS_MASTER_URI") or _DEFAULT_MASTER
        self._master = RosMaster(uri)
        self._latest: dict[str, ChannelReading] = {}
        self._gathered = SampleBuffer()
        self._plans = plans_of(scope, self._latest, self._unreadable.report)
        self._parameters = parameter_plans_of(scope, self._latest, self._unreadable.report)
        self._wanted: dict[int, _Wanted] = {}
        self._streams: dict[str, int] = {}
        # By device: where its FITS files come.
        self._frames: dict[str, int] = {}
        self._decoders: dict[int, Callable[[bytes], object]] = {}
        self._watched: frozenset[str] = frozenset()
        self._complained: set[str] = set()
        self._worker: PictureWorker | None = None
        self._node: NodeProcess | None = None
        self._presence: Ros1Presence | None = None
        self._ready: asyncio.Future[str] | None = None
        # What the node has said that only its main thread says, and whether it is through with
        # what it was told first.
        self._signs = 0
        self._settled = False
        self._calls = count()
        self._pending: dict[int, Callable[[CommandOutcome], None]] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        loop = asyncio.get_running_loop()
        await loop.run_in_executor(None, self._master.check)
        failed: asyncio.Future[str] = loop.create_future()
        self._ready = loop.create_future()
        worker = self._worker = PictureWorker(self._pictures, self._clock)
        worker.start()
        self._plan(worker)

        def fail(why: str) -> None:
            loop.call_soon_threadsafe(_settle, failed, why)

        node = attending = None
        try:
            node = NodeProcess(
                settings=self._settings,
                uri=self._master.uri,
                heard=lambda frame: self._hear(frame, loop),
                turned=self._turn,
                failed=fail,
            )
            self._settled = False
            node.send_frame(node=self._settings.node, namespace=self._settings.namespace)
            name = await self._joined(failed)
            self._node = node
            self._describe(node)
            self._status.up()
            presence = Ros1Presence(self._scope, self._master, self._clock, self._on_presence)
            self._presence = presence
            attending = asyncio.ensure_future(presence.run())
            await self._stay(node, name, failed)
        finally:
            self._node = self._presence = None
            if attending is not None:
                attending.cancel()
                await asyncio.gather(attending, return_exceptions=True)
            self._latest.clear()
            self._fail_pending()
            if node is not None:
                node.hang_up()
                await asyncio.shield(loop.run_in_executor(None, node.wait))
            self._decoders.clear()
            worker.close()

    async def _joined(self, failed: asyncio.Future[str]) -> str:
        assert self._ready is not None  # noqa: S101 - made by `run`
        done, _ = await asyncio.wait(
            [failed, self._ready], timeout=_START_S, return_when=asyncio.FIRST_COMPLETED
        )
        if self._ready in done:
            return self._ready.result()
        if failed in done:
            raise AdapterLost(f"ROS 1 cannot be joined: {failed.result()}")
        raise AdapterLost(f"ROS 1 cannot be joined: its node is not there after {_START_S:g} s")

    def _on_presence(self, device: str, why: str, sure: bool) -> None:  # noqa: FBT001
        self._status.device(device, there=not why, why=why, sure=sure)

    async def _stay(self, node: NodeProcess, name: str, failed: asyncio.Future[str]) -> None:
        """Stay until the node ends or hangs, or the master knows it no more."""
        loop = asyncio.get_running_loop()
        asked = seen = missed = 0
        while True:
            asked += 1
            node.send_frame(op="ping", n=asked)
            await asyncio.wait([failed], timeout=_LOOK_S)
            if failed.done():
                raise AdapterLost(failed.result())
            # Looks are counted, not time: if this process stood still, the node is not to blame.
            missed = missed + 1 if self._signs == seen else 0
            seen = self._signs
            if missed >= (_MISSES if self._settled else _MISSES_FIRST):
                node.kill()
                raise AdapterLost("ROS 1's node hangs")
            if not await loop.run_in_executor(None, self._master.knows, name):
                raise AdapterLost(f"the ROS master at {self._master.uri} began anew")

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        before, self._watched = self._watched, frozenset(streams)
        node = self._node
        if node is None:
            return
        for address, number in self._streams.items():
            if address in self._watched and address not in before:
                self._listen(node, number)
            elif address in before and address not in self._watched:
                node.send_frame(op="leave", topic=number)

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def drive(self, device: str, linear: float, angular: float, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        described = self._scope.devices.get(device)
        if self._node is not None and described is not None and described.drive is not None:
            fields = velocity_fields(described.drive, linear, angular, key)
            self._node.send_frame(op="say", id=f"drive {device}", fields=fields)

    def stop(self, device: str, *, stopped: bool) -> None:
        """See `CommandTarget.stop`."""
        if self._node is not None:
            self._node.send_frame(op="say", id=f"stop {device}", fields={"data": stopped})

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        node = self._node
        if node is None:
            done(CommandOutcome(CommandPhase.REFUSED, "the robot is not connected"))
            return None
        if len(self._pending) >= MAX_PENDING:
            # Calls that were never answered; their callers have long given up.
            self._pending.pop(next(iter(self._pending)))
        address, call = f"{device}/{command}", next(self._calls)
        described = self._scope.devices[device].commands[command]
        self._pending[call] = done
        node.send_frame(op="act", id=address, call=call, fields=fields, target=described.target)
        if described.kind is not CommandKind.ACTION:
            return None
        return lambda: node.send_frame(op="cancel", id=address, call=call)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`."""
        node, described = self._node, self._scope.devices.get(device)
        if node is None or described is None:
            done(CommandOutcome(CommandPhase.FAILED, "the robot's side cannot be reached now"))
            return
        sources = {topic_of(signal.source) for signal in described.signals.values()}
        topics = {topic for topic in sources if topic}
        for number, wanted in self._wanted.items():
            apart = (*self._streams.values(), *self._frames.values())
            if wanted.topic in topics and number not in apart:
                self._listen(node, number)
        for address in sorted(self._watched & self._streams.keys()):
            if address.startswith(f"{device}/"):
                topics.add(self._wanted[self._streams[address]].topic)
                self._listen(node, self._streams[address])
        if device in self._frames:
            topics.add(self._wanted[self._frames[device]].topic)
            self._listen(node, self._frames[device])
        for name, command in described.commands.items():
            self._offer(node, f"{device}/{name}", command)
        task = asyncio.ensure_future(self._rejoin(topics, list(described.commands.values()), done))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _rejoin(
        self, topics: set[str], commands: list[Command], done: Callable[[CommandOutcome], None]
    ) -> None:
        loop = asyncio.get_running_loop()
        until = loop.time() + WAIT_S
        while True:
            try:
                graph = await loop.run_in_executor(None, self._master.graph)
            except AdapterLost as error:
                done(CommandOutcome(CommandPhase.FAILED, str(error)))
                return
            absent = [
                f"{topic} (nobody publishes it)"
                for topic in sorted(topics)
                if topic not in graph.published
            ]
            for command in commands:
                target = command.target
                if command.kind is CommandKind.SERVICE and target not in graph.services:
                    absent.append(f"{command.target} (no such service now)")
                elif command.kind is CommandKind.ACTION and f"{target}/goal" not in graph.heard:
                    absent.append(f"{command.target} (no such action now)")
            if not absent or loop.time() >= until:
                done(rejoined(len(topics) + len(commands), absent))
                return
            await asyncio.sleep(_LOOK_S)

    # ── what the node is to do ──

    def _plan(self, worker: PictureWorker) -> None:
        """Number every topic that may be listened to."""
        self._wanted.clear()
        self._streams.clear()
        for number, plan in enumerate(self._plans):

            def read_message(heard: ReceivedMessage, number: int = number) -> None:
                self._record(heard, number)
                decode = self._decoders.get(number)
                if decode is None:
                    return
                now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
                # It came when the node had it; unless clocks jumped.
                late_us = now_us - heard.time_us
                late_us = late_us if 0 <= late_us < 1_000_000 else 0
                mono_ns = now_ns - late_us * 1000
                if self._presence is not None:
                    self._presence.heard_ns[self._plans[number].topic] = now_ns
                self._plans[number].read_message(
                    decode(heard.raw), now_us - late_us, mono_ns, self._gathered
                )

            self._wanted[number] = _Wanted(plan.topic, plan.type_name, read_message)
        for device_id, device in self._scope.devices.items():
            for stream_id, stream in device.streams.items():
                number, address = len(self._wanted), f"{device_id}/{stream_id}"

                def decode(raw: bytes, number: int = number) -> object:
                    known = self._decoders.get(number)
                    if known is None:
                        raise FieldError("", "its type is not known")
                    return known(raw)

                taker = PictureStream(address, stream, decode, self._unreadable.report)

                def take_picture(heard: ReceivedMessage, taker: PictureStream = taker) -> None:
                    worker.offer(taker, heard.raw)

                self._streams[address] = number
                source = source_as(stream.source, RosSource)
                # A little more than is shown, so that the two paces do not lose every other one.
                rate = stream.max_rate * 1.5
                self._wanted[number] = _Wanted(source.topic, source.type, take_picture, rate)

        self._plan_frames()
        self._recorded = []
        heard = {plan.topic for plan in self._plans}
        for topic in sorted(self._raw.topics - heard) if self._raw is not None else ():
            number = len(self._wanted)

            def record(heard: ReceivedMessage, number: int = number) -> None:
                self._record(heard, number)

            self._wanted[number] = _Wanted(topic, "", record)
            self._recorded.append(number)

    def _plan_frames(self) -> None:
        self._frames.clear()
        for device_id, device in self._scope.devices.items():
            source = device.frames
            if not isinstance(source, RosSource) or self._files is None:
                continue
            number, files = len(self._wanted), self._files

            def keep_file(
                heard: ReceivedMessage,
                number: int = number,
                device: str = device_id,
                files: FileSink = files,
            ) -> None:
                decode = self._decoders.get(number)
                if decode is not None:
                    files.keep_file(device, lambda: file_in(decode(heard.raw)))

            self._frames[device_id] = number
            self._wanted[number] = _Wanted(source.topic, source.type, keep_file)

    def _record(self, heard: ReceivedMessage, number: int) -> None:
        """Give a message to who records, if it is one of those and its type is known."""
        topic, told = self._wanted[number].topic, self._told.get(number)
        if self._raw is not None and told is not None and topic in self._raw.topics:
            self._raw.offer(topic, told[0], heard.raw, heard.time_us * 1000, definition=told[1])

    def _describe(self, node: NodeProcess) -> None:
        for device_id, device in self._scope.devices.items():
            rule = device.drive
            if rule is not None:
                # Characters may add up: none takes another's place before it is sent.
                node.send_frame(
                    op="voice",
                    id=f"drive {device_id}",
                    topic=rule.topic,
                    type=rule.message.value,
                    zero=velocity_fields(rule, 0.0, 0.0, HALT),
                    deep=20 if rule.message is DriveMessage.KEYS else 1,
                )
                if rule.stop.topic:
                    node.send_frame(
                        op="voice",
                        id=f"stop {device_id}",
                        topic=rule.stop.topic,
                        type=BOOL,
                        latch=True,
                    )
            for name, command in device.commands.items():
                self._offer(node, f"{device_id}/{name}", command)
        for number, _ in enumerate(self._plans):
            self._listen(node, number)
        for number in (*self._frames.values(), *self._recorded):
            self._listen(node, number)
        for address in sorted(self._watched & self._streams.keys()):
            self._listen(node, self._streams[address])
        node.send_frame(op="parameters", names=[parameter.topic for parameter in self._parameters])

    def _offer(self, node: NodeProcess, address: str, command: Command) -> None:
        match command.kind:
            case CommandKind.TOPIC:
                node.send_frame(
                    op="voice", id=address, topic=command.target, type=command.type, deep=10
                )
            case CommandKind.ACTION:
                node.send_frame(
                    op="action",
                    id=address,
                    name=command.target,
                    type=command.type,
                    progress=command.progress,
                    progress_end=command.progress_end,
                )
            case CommandKind.SERVICE:
                node.send_frame(op="service", id=address, name=command.target, type=command.type)
            case _:
                # Parameters are set by name, without anything to get ready.
                return

    def _listen(self, node: NodeProcess, number: int) -> None:
        wanted = self._wanted[number]
        deep = 1 if wanted.rate else DEPTH
        node.send_frame(op="listen", topic=number, name=wanted.topic, rate=wanted.rate, deep=deep)

    # ── on the node's thread ──

    def _hear(
        self, frame: ReceivedMessage | dict[str, Any], loop: asyncio.AbstractEventLoop
    ) -> None:
        if isinstance(frame, ReceivedMessage):
            wanted = self._wanted.get(frame.topic)
            if wanted is None:
                return
            try:
                wanted.take(frame)
            except FieldError as error:
                self._unreadable.report_once(wanted.topic, str(error))
        elif frame["op"] == "type":
            self._learn(frame)
        elif frame["op"] == "parameter":
            plan = self._parameters[frame["number"]]
            message = SimpleNamespace(data=frame["value"])
            plan.read_message(message, frame["at"], self._clock.monotonic_ns(), self._gathered)
        else:
            loop.call_soon_threadsafe(self._on_said, frame)

    def _turn(self) -> None:
        now_us = self._clock.wall_ns() // 1000
        for plan in (*self._plans, *self._parameters):
            plan.take_due(now_us, self._gathered)
        columns = self._gathered.take_columns()
        if columns is not None:
            self._samples.put_samples(columns)

    def _learn(self, said: dict[str, Any]) -> None:
        number = said["topic"]
        wanted, found = self._wanted[number], full_name(said["type"])
        self._decoders.pop(number, None)
        self._told[number] = (found, said["definition"])
        if not wanted.type_name:
            return
        if found != wanted.type_name:
            problem = f"is of type {found}, and not {wanted.type_name} as the description says"
            self._unreadable.report_once(wanted.topic, problem)
            return
        try:
            self._decoders[number] = decoder_of(found, said["definition"])
        except FieldError as error:
            self._unreadable.report_once(wanted.topic, str(error))

    # ── what the node says, on the event loop ──

    def _on_said(self, said: dict[str, Any]) -> None:
        match said["op"]:
            case "ready":
                if self._ready is not None and not self._ready.done():
                    self._ready.set_result(said["node"])
            case "pong":
                self._signs += 1
                self._settled = True
            case "working":
                self._signs += 1
            case "outcome":
                self._on_outcome(said)
            case "missing":
                self._tell_missing(said["type"], said["used_by"])
            case "complaint":
                self._unreadable.report_once(said["id"], said["problem"])
            case _:
                log.debug("the node said %s", said["op"])

    def _tell_missing(self, type_name: str, used_by: str) -> None:
        problem = str(TypeMissing(type_name, used_by))
        if problem not in self._complained:
            self._complained.add(problem)
            log.warning("%s", problem)
            self._events.report_event("type_missing", problem)

    def _on_outcome(self, said: dict[str, Any]) -> None:
        phase = CommandPhase(said["phase"])
        running = phase is CommandPhase.RUNNING
        call = said["call"]
        done = self._pending.get(call) if running else self._pending.pop(call, None)
        if done is not None:
            done(CommandOutcome(phase, said["message"][:2000], said["progress"]))

    def _fail_pending(self) -> None:
        pending, self._pending = self._pending, {}
        for done in pending.values():
            done(CommandOutcome(CommandPhase.UNKNOWN, _CUT))


def _settle(future: asyncio.Future[str], why: str) -> None:
    if not future.done():
        future.set_result(why)
