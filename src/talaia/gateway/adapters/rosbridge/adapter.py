"""The rosbridge adapter: the same over a rosbridge server, where nothing can be installed.

The protocol is in `protocol`. A server cannot be told what to say when we are gone: if this
process dies the robot hears nothing more, and its own time-out must stop it.

Long, because one socket carries all of it but raw topics.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING

from websockets.exceptions import ConnectionClosed, WebSocketException

from talaia.gateway.adapters.reconnection import reconnection_outcome
from talaia.gateway.adapters.rosbridge.camera_subscriptions import CameraSubscriptions
from talaia.gateway.adapters.rosbridge.credentials import read_credentials
from talaia.gateway.adapters.rosbridge.outgoing_frames import OutgoingFrames, ServerTopics
from talaia.gateway.adapters.rosbridge.pending_calls import PendingCalls
from talaia.gateway.adapters.rosbridge.protocol import nest_fields, read_message, write_frame
from talaia.gateway.adapters.rosbridge.raw_topics import MAX_RAW_FRAME, RosbridgeTopics
from talaia.gateway.adapters.rosbridge.server_connection import dial_server
from talaia.gateway.adapters.rosbridge.server_log import LOG_TOPIC, ServerLog
from talaia.gateway.adapters.topic_readers import SampleBuffer, make_live_plans
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.adapters.velocity import velocity_fields
from talaia.gateway.errors import AdapterLost, FieldError
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import RosbridgeConnection, topic_of
from talaia.model.site import CommandKind
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from websockets.asyncio.client import ClientConnection

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.rosbridge.protocol import ServerMessage
    from talaia.gateway.adapters.topic_readers import TopicPlan
    from talaia.gateway.ports import AdapterContext, AdapterStatus, ChannelReading
    from talaia.gateway.tap_ports import TopicDefinition
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.wire.frames import Scalar

__all__ = ["RosbridgeAdapter"]

log = logging.getLogger(__name__)
BOOL = "std_msgs/msg/Bool"
# A camera's picture as base64 in JSON is a third larger than it is.
_MAX_FRAME = 32 * 1024 * 1024
# Larger frames are read on another thread: driving must not wait behind a picture.
_LARGE = 64 * 1024
# Pace at which held-back values are given out.
_TURN_S = 0.1
_AGAIN_S = 3.0


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
        self._url = settings.url
        self._scope, self._status = scope, status
        self._clock, self._samples = context.clock, context.samples
        self._unreadable = UnreadableReports(context.events)
        headers, tls = read_credentials(settings, context.folder)
        self._dial = partial(dial_server, settings.url, headers, tls)
        # By address: newest readings of signals that safety depends on.
        self._latest: dict[str, ChannelReading] = {}
        # What was read and is not given out yet.
        self._gathered = SampleBuffer()
        # One for each topic and type.
        self._plans = make_live_plans(scope, self._latest, self._unreadable)
        # Messages come without their type: of two types for one topic the later one is read.
        self._by_topic = {plan.topic: plan for plan in self._plans}
        # Decodes pictures beside the event loop, in each run.
        self._pictures, self._budget = context.pictures, context.budget
        self._worker: PictureWorker | None = None
        self._connected = False
        self._outgoing = OutgoingFrames()
        self._topics = ServerTopics(self._outgoing, settings.ros)
        self._cameras = CameraSubscriptions(
            scope, self._topics, self._unreadable.report_unreadable, cbor=settings.cbor
        )
        self._calls = PendingCalls()
        self._log = ServerLog(settings, context)
        # Topics of which a message has come in this connection.
        self._heard: set[str] = set()
        self._raw_topics = RosbridgeTopics(
            sink=context.taps,
            settings=settings,
            dial=partial(self._dial, max_size=MAX_RAW_FRAME),
            clock=context.clock,
        )

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        where = self._url
        worker = self._worker = PictureWorker(self._pictures, self._clock, self._budget)
        worker.start()
        try:
            async with self._dial(max_size=_MAX_FRAME) as socket:
                await self._serve_connection(socket)
        except ConnectionClosed as error:
            raise AdapterLost(f"the rosbridge server at {where} is gone ({error})") from error
        except (OSError, TimeoutError, WebSocketException) as error:
            why = str(error) or type(error).__name__
            raise AdapterLost(f"no rosbridge server answers at {where} ({why})") from error
        finally:
            self._connected = False
            self._latest.clear()
            self._outgoing.clear_frames()
            self._calls.lose_all()
            # It joins a thread, which may be in the middle of a picture.
            await asyncio.get_running_loop().run_in_executor(None, worker.close)
        raise AdapterLost(f"the rosbridge server at {where} closed the connection")

    async def _serve_connection(self, socket: ClientConnection) -> None:
        self._heard.clear()
        self._connected = True
        self._describe_site()
        self._status.up()
        parts = [
            asyncio.ensure_future(part)
            for part in (
                self._read_frames(socket),
                self._outgoing.write_frames(socket),
                self._keep_pace(),
                self._raw_topics.run(),
            )
        ]
        try:
            done, _ = await asyncio.wait(parts, return_when=asyncio.FIRST_COMPLETED)
            for part in done:
                part.result()
        finally:
            await self._outgoing.write_rest(socket)
            for part in parts:
                part.cancel()
            await asyncio.gather(*parts, return_exceptions=True)

    async def _read_frames(self, socket: ClientConnection) -> None:
        loop = asyncio.get_running_loop()
        async for data in socket:
            try:
                # One after the other all the same: a topic's messages keep their order.
                large = len(data) > _LARGE
                heard = (
                    await loop.run_in_executor(None, read_message, data)
                    if large
                    else read_message(data)
                )
                self._on_message(heard)
            except FieldError as error:
                self._unreadable.report_once("rosbridge", str(error))

    async def _keep_pace(self) -> None:
        loop = asyncio.get_running_loop()
        again = loop.time() + _AGAIN_S
        while True:
            await asyncio.sleep(_TURN_S)
            if loop.time() >= again:
                again = loop.time() + _AGAIN_S
                self._ask_silent_topics()
                self._log.tell_left_out()
            now_us = self._clock.wall_ns() // 1000
            for plan in self._plans:
                plan.take_due(now_us, self._gathered)
            self._publish_samples()

    def _ask_silent_topics(self) -> None:
        """Subscribe anew what has never come.

        On ROS 2 a server offers the quality of service that fits who publishes at that moment;
        a robot that comes later, and sends best effort, would never be heard.
        """
        for plan in self._plans:
            if plan.topic not in self._heard:
                self._subscribe_again(plan)

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        self._cameras.watch_streams(streams, connected=self._connected)

    def tap_topics(self, topics: frozenset[str]) -> None:
        """See `TopicSource.tap_topics`."""
        self._raw_topics.tap_topics(topics)

    def watch_graph(self, *, wanted: bool) -> None:
        """See `GraphSource.watch_graph`."""
        self._raw_topics.watch_graph(wanted=wanted)

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """See `TopicSource.define_type`."""
        self._raw_topics.define_type(type_name, done)

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        described = self._scope.devices.get(device)
        if self._connected and described is not None and described.drive is not None:
            rule = described.drive
            fields = nest_fields(velocity_fields(rule, demand, key))
            text = write_frame("publish", topic=rule.topic, msg=fields)
            if key:
                # Characters may add up: none takes another's place.
                self._outgoing.append_frame(text)
            else:
                self._outgoing.replace_newest(f"drive {device}", text)

    def stop(self, device: str, *, stopped: bool) -> None:
        """See `CommandTarget.stop`."""
        described = self._scope.devices.get(device)
        if self._connected and described is not None and described.drive is not None:
            topic = described.drive.stop.topic
            if topic:
                text = write_frame("publish", topic=topic, msg={"data": stopped})
                self._outgoing.replace_newest(f"stop {device}", text)

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
            body = nest_fields(fields)
        except FieldError as error:
            done(CommandOutcome(CommandPhase.REFUSED, str(error)))
            return None
        # Numbered as they come, also those that nobody answers: so a log of the wire is readable.
        call, target = self._calls.next_name(), described.target
        send = self._outgoing.send_operation
        if described.kind is CommandKind.TOPIC:
            # A server does not say whether anybody listens.
            send("publish", topic=target, msg=body)
            done(CommandOutcome(CommandPhase.SUCCEEDED, "published"))
            return None
        if described.kind is CommandKind.PARAMETER:
            # rosapi could, but it is a node that a server may not have.
            done(CommandOutcome(CommandPhase.REFUSED, "a rosbridge sets no parameters"))
            return None
        self._calls.begin_call(call, described, done)
        kind = self._topics.type_name(described.type)
        if described.kind is CommandKind.SERVICE:
            send("call_service", id=call, service=target, type=kind, args=body)
            return None
        send("send_action_goal", id=call, action=target, action_type=kind, args=body, feedback=True)
        return lambda: send("cancel_action_goal", id=call, action=target)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`. A server does not say who publishes, so nothing is absent."""
        described = self._scope.devices.get(device)
        if not self._connected or described is None:
            done(CommandOutcome(CommandPhase.FAILED, "the robot's side cannot be reached now"))
            return
        topics = {topic_of(signal.source) for signal in described.signals.values()}
        for plan in self._plans:
            if plan.topic in topics:
                self._subscribe_again(plan)
        self._cameras.subscribe_again(device)
        done(reconnection_outcome(len(topics), []))

    # ── to the server ──

    def _describe_site(self) -> None:
        """Say to a server that has just come what we publish and want to hear."""
        for device in self._scope.devices.values():
            rule = device.drive
            if rule is not None:
                self._topics.advertise_topic(rule.topic, rule.message.value)
                if rule.stop.topic:
                    # Latched: a node of the robot that starts later hears of a STOP.
                    self._topics.advertise_topic(rule.stop.topic, BOOL, latch=True)
            for command in device.commands.values():
                if command.kind is CommandKind.TOPIC:
                    self._topics.advertise_topic(command.target, command.type)
        for plan in self._plans:
            self._topics.subscribe_topic(f"signal {plan.topic}", plan.topic, plan.type_name)
        self._cameras.begin_connection()
        self._log.subscribe(self._topics)

    def _subscribe_again(self, plan: TopicPlan) -> None:
        self._topics.unsubscribe_topic(f"signal {plan.topic}", plan.topic)
        self._topics.subscribe_topic(f"signal {plan.topic}", plan.topic, plan.type_name)

    # ── from the server ──

    def _on_message(self, heard: ServerMessage) -> None:
        match heard.op:
            case "publish":
                self._read_message(heard)
            case "service_response" | "action_result":
                self._calls.end_call(heard)
            case "action_feedback":
                self._calls.report_progress(heard)
            case "status":
                self._on_status(heard)
            case _:
                log.debug("the server said %s", heard.op)

    def _read_message(self, heard: ServerMessage) -> None:
        if heard.topic == LOG_TOPIC:
            self._log.read_message(heard.body)
        plan = self._by_topic.get(heard.topic)
        if plan is not None:
            self._heard.add(heard.topic)
            # The protocol carries no time of arrival: now is the best there is.
            now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
            plan.read_message(heard.body, now_us, now_ns, self._gathered)
            self._publish_samples()
        if self._worker is not None:
            for reader in self._cameras.readers_of(heard.topic):
                self._worker.offer_raw(reader, heard.body)

    def _publish_samples(self) -> None:
        columns = self._gathered.take_columns()
        if columns is not None:
            self._samples.put_samples(columns)

    def _on_status(self, heard: ServerMessage) -> None:
        words = heard.body if isinstance(heard.body, str) else ""
        # A server refuses a call by a status of the call's name, and not by an answer.
        if heard.level == "error" and self._calls.fail_call(heard.id, words):
            return
        if heard.level in {"error", "warning"}:
            self._unreadable.report_once(heard.id or "rosbridge", words[:500])
