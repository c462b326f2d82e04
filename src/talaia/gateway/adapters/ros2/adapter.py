"""The ROS 2 adapter: hears what the description names and tells the robot what it may be told.

This file joins the parts: `ros2_waitset` (the thread), `ros2_decode` (messages to samples),
`pictures` (images to JPEG), `ros2_services` (commands), `ros2_motion` (driving and STOP),
`ros2_presence` (who is there) and `ros2_qos`. Long, because joining, matching and leaving scope
one node and must be read together.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
from functools import partial
from typing import TYPE_CHECKING, Any

# Where ROS comes from Python wheels, this finds their libraries, starting the process anew
# (same pid) if need be; so it stands before the first import of rclpy.
with contextlib.suppress(ImportError):
    import ros_wheels_bootstrapper  # noqa: F401
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions

from talaia.gateway.adapters.arrivals import Arrivals
from talaia.gateway.adapters.presence import Deafness
from talaia.gateway.adapters.reconnection import ReconnectionAttempts
from talaia.gateway.adapters.ros2.decode import decoder_for
from talaia.gateway.adapters.ros2.motion import Ros2Motion
from talaia.gateway.adapters.ros2.parameters import Ros2Parameters
from talaia.gateway.adapters.ros2.participant_number import ParticipantNumber, domain_of
from talaia.gateway.adapters.ros2.presence import Ros2Presence
from talaia.gateway.adapters.ros2.qos import QosProfile, fits, quality_for
from talaia.gateway.adapters.ros2.requests import class_of
from talaia.gateway.adapters.ros2.services import Ros2Commands
from talaia.gateway.adapters.ros2.waitset import WaitThread
from talaia.gateway.adapters.topic_readers import SampleBuffer, TopicPlan, file_in, plans_of
from talaia.gateway.adapters.unreadable import UnreadableReports
from talaia.gateway.errors import AdapterLost, TypeMissing
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.video.camera import PictureStream
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import Ros2Connection, RosSource, source_as
from talaia.shared_memory import remove_dead_segments_at_start
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import (
        AdapterContext,
        AdapterStatus,
        ChannelReading,
        FileSink,
        RawSink,
    )
    from talaia.model.site import Stream
    from talaia.wire.frames import Scalar

__all__ = ["Ros2Adapter"]

log = logging.getLogger(__name__)
# Far more than comes between two turns of the wait set: when a transport was stuck (after a crash
# for seconds), a reliable publisher sends all of it again at once, and what is over this is lost
# without a trace. Memory is taken only as it is needed.
DEPTH = 5_000
PICTURE_DEPTH = 1
# A file may have many megabytes, and a camera takes its time for each.
FILE_DEPTH = 4
# Turns of a quarter of a second: seldom enough to cost nothing, often enough for 20 s of memory.
MARK_EVERY = 16

# What is listened to under these does not also record.
_APART = ("stream ", "frames ")


class _Listening:
    """A topic that is wanted: its class, who takes its messages, and the subscription, if any."""

    def __init__(
        self,
        topic: str,
        kind: Any,  # noqa: ANN401 - rclpy ships no types
        depth: int,
        take: Callable[[bytes, Any], None],
    ) -> None:
        self.topic = topic
        self.kind = kind
        self.depth = depth
        self.take = take
        self.quality: QosProfile | None = None
        self.subscription: Any = None

    def taken(self, raw: bytes, info: Any) -> None:  # noqa: ANN401
        """Give a message to whoever takes them now."""
        self.take(raw, info)


class Ros2Adapter:
    """An `Adapter` for ROS 2. See `talaia.gateway.ports` for its promises."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be served and where things go; `run` joins ROS."""
        settings = scope.connection
        assert isinstance(settings, Ros2Connection)  # noqa: S101 - the catalog has seen to it
        self._scope = scope
        self._status = status
        self._clock = context.clock
        self._samples = context.samples
        self._pictures = context.pictures
        self._events = context.events
        self._unreadable = UnreadableReports(context.events)
        self._domain = settings.domain if context.domain is None else context.domain
        self._node_name = settings.node
        self._raw = context.raw
        self._files = context.files
        self._latest: dict[str, ChannelReading] = {}
        self._gathered = SampleBuffer()
        self._plans = plans_of(scope, self._latest, self._unreadable.report)
        self._watched: frozenset[str] = frozenset()
        self._listening: dict[str, _Listening] = {}
        self._motion: Ros2Motion | None = None
        self._missing: set[str] = set()
        self._commands: Ros2Commands | None = None
        self._parameters: Ros2Parameters | None = None
        self._presence: Ros2Presence | None = None
        self._thread: WaitThread | None = None
        self._worker: PictureWorker | None = None
        self._node: Any = None
        self._turn = 0
        self._number = ParticipantNumber(None)
        self._rejoining = ReconnectionAttempts(self._clock)
        self._arrivals = Arrivals(self._clock.monotonic_ns())
        self._deafness = Deafness()

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        loop = asyncio.get_running_loop()
        failed: asyncio.Future[None] = loop.create_future()

        def fail(error: BaseException) -> None:
            loop.call_soon_threadsafe(_fail, failed, error)

        remove_dead_segments_at_start()
        context = Context()
        try:
            self._join(context, fail)
        except Exception as error:
            self._leave(context)
            raise AdapterLost(f"ROS 2 cannot be joined: {error}") from error
        self._status.up()
        try:
            await failed
        finally:
            await asyncio.shield(loop.run_in_executor(None, self._leave, context))

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        self._watched = frozenset(streams)
        if self._thread is not None:
            self._thread.run_soon(self._update_subscriptions)

    def redescribe(self, scope: ConnectionScope) -> None:
        """See `DescriptionFollower`."""
        if self._thread is None:
            # It is joined with the next `run`.
            self._scope = scope
            self._plans = plans_of(scope, self._latest, self._unreadable.report)
        else:
            self._thread.run_soon(lambda: self._redescribe(scope))

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def drive(self, device: str, linear: float, angular: float, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        if self._motion is not None:
            self._motion.drive(device, linear, angular, key)

    def stop(self, device: str, *, stopped: bool) -> None:
        """See `CommandTarget.stop`."""
        if self._motion is not None:
            self._motion.stop(device, stopped=stopped)

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        thread, commands = self._thread, self._commands
        if thread is None or commands is None:
            done(Ros2Commands.away())
            return None
        return commands.begin(f"{device}/{command}", fields, done, thread.run_soon)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`."""
        thread = self._thread
        if thread is None:
            done(CommandOutcome(CommandPhase.FAILED, "the robot's side cannot be reached now"))
        else:
            thread.run_soon(lambda: self._rejoin(device, done))

    # ── joining and leaving ──

    def _join(self, context: Any, fail: Callable[[BaseException], None]) -> None:  # noqa: ANN401
        self._number = ParticipantNumber(_fast_dds_domain(self._domain))
        # Nothing spins this node, so it offers no services that nobody would answer.
        quiet = Parameter("start_type_description_service", value=False)
        with self._number.held():
            rclpy.init(
                args=["--ros-args", "--disable-rosout-logs", "--disable-external-lib-logs"],
                context=context,
                domain_id=self._domain,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            self._node = Node(
                self._node_name,
                context=context,
                use_global_arguments=False,
                enable_rosout=False,
                start_parameter_services=False,
                parameter_overrides=[quiet],
            )
        self._number.mark_used()
        guard = self._node.create_guard_condition(lambda: None)
        thread = WaitThread(
            context=context.handle,
            guard=guard.handle,
            after=self._after,
            idle=self._on_idle,
            failed=fail,
        )
        self._worker = PictureWorker(self._pictures, self._clock)
        self._commands = Ros2Commands(self._scope, self._node, thread, self._tell_missing)
        self._parameters = Ros2Parameters(
            scope=self._scope,
            node=self._node,
            thread=thread,
            clock=self._clock,
            gathered=self._gathered,
            latest=self._latest,
            complain=self._unreadable.report,
        )
        self._presence = Ros2Presence(
            scope=self._scope,
            node=self._node,
            thread=thread,
            clock=self._clock,
            commands=self._commands,
            tell=self._on_presence,
            deafness=self._deafness,
            rejoin=lambda why: fail(AdapterLost(why)),
        )
        for plan in self._plans:
            self._plan(plan)
        self._motion = Ros2Motion(self._scope, self._node, self._tell_missing)
        self._worker.start()
        self._thread = thread
        thread.start()

    def _leave(self, context: Any) -> None:  # noqa: ANN401
        thread, self._thread = self._thread, None
        # First nobody publishes any more, then the thread ends, then the node goes.
        self._motion = self._commands = self._parameters = self._presence = None
        if thread is not None:
            thread.end()
        self._rejoining.end()
        if self._worker is not None:
            self._worker.close()
        self._listening.clear()
        self._latest.clear()
        if self._node is not None:
            self._node.destroy_node()
            self._node = None
        rclpy.try_shutdown(context=context)

    def _redescribe(self, scope: ConnectionScope) -> None:
        """Bring all in line with another scope; on the wait-set thread, between two turns."""
        before, self._scope = self._scope, scope
        old = {_key(plan.topic, plan.type_name): plan for plan in self._plans}
        self._plans = plans_of(scope, self._latest, self._unreadable.report)
        wanted = {_key(plan.topic, plan.type_name): plan for plan in self._plans}
        for key in old.keys() - wanted.keys():
            self._end_listening(key)
        for key, plan in wanted.items():
            if key in old:
                plan.take_over(old[key])
            self._end_listening(f"raw {plan.topic}")
            self._plan(plan)
        for key in [key for key in self._listening if key.startswith("stream ")]:
            device, _, stream = key.removeprefix("stream ").partition("/")
            if _stream_of(before, device, stream) != _stream_of(scope, device, stream):
                self._end_listening(key)
        for device in [device for device in before.devices if _frames_of(before, device)]:
            if _frames_of(before, device) != _frames_of(scope, device):
                self._end_listening(f"frames {device}")
        for address in [key for key in self._latest if _moved(before, scope, key)]:
            del self._latest[address]
        if self._commands is not None:
            self._commands.redescribe(scope)
        if self._parameters is not None:
            self._parameters.redescribe(scope)
        if self._motion is not None:
            self._motion.redescribe(scope)
        self._update_subscriptions()

    def _end_listening(self, key: str) -> None:
        listening = self._listening.pop(key, None)
        if listening is not None:
            self._drop(listening)

    def _plan(self, plan: TopicPlan) -> None:
        """Let a plan take its topic's messages; a subscription that is there already stays."""
        kind = self._class(plan.type_name, plan.topic)
        if kind is None:
            return
        decode = decoder_for(plan.type_name, lambda data: deserialize_message(data, kind))
        recorded = self._raw if self._raw is not None and plan.topic in self._raw.topics else None

        def read_message(raw: bytes, info: Any) -> None:  # noqa: ANN401
            now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
            time_us = self._arrivals.at(info["received_timestamp"] // 1000, now_us, now_ns)
            if recorded is not None:
                recorded.offer(plan.topic, plan.type_name, raw, time_us * 1000)
            if self._presence is not None:
                self._presence.heard_ns[plan.topic] = now_ns
            plan.read_message(decode(raw), time_us, now_ns, self._gathered)

        listening = self._listening.get(_key(plan.topic, plan.type_name))
        if listening is None:
            listening = _Listening(plan.topic, kind, DEPTH, read_message)
            self._listening[_key(plan.topic, plan.type_name)] = listening
        else:
            listening.take = read_message

    def _class(self, type_name: str, used_by: str) -> Any:  # noqa: ANN401
        try:
            return class_of(type_name, used_by)
        except TypeMissing as error:
            self._tell_missing(error)
            return None

    def _tell_missing(self, error: TypeMissing) -> None:
        if str(error) not in self._missing:
            self._missing.add(str(error))
            log.warning("%s", error)
            self._events.report_event("type_missing", str(error))

    # ── on the wait-set thread ──

    def _after(self) -> bool:
        now_us = self._clock.wall_ns() // 1000
        held = False
        own = self._parameters.plans if self._parameters is not None else []
        for plan in (*self._plans, *own):
            held = plan.take_due(now_us, self._gathered) or held
        columns = self._gathered.take_columns()
        if columns is not None:
            self._samples.put_samples(columns)
        self._arrivals.awake(self._clock.monotonic_ns())
        return held

    def _on_idle(self) -> None:
        self._turn += 1
        if self._turn % MARK_EVERY == 0:
            self._number.mark_used()
        if self._parameters is not None and self._turn % 4 == 0:
            self._parameters.ask()
        if self._turn % 2 == 0:
            self._update_subscriptions(everything=self._turn % 8 == 0)
            self._rejoining.report_finished()
        if self._presence is not None:
            self._presence.judge_devices()

    def _on_presence(self, device: str, why: str, sure: bool) -> None:  # noqa: FBT001
        self._status.device(device, there=not why, why=why, sure=sure)

    def _rejoin(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Make the subscriptions and clients of a device anew; its publishers of motion stay.

        Topics that it scopes with other devices are taken anew for them, too.
        """
        commands = self._commands
        if commands is None or device not in self._scope.devices:
            done(CommandOutcome(CommandPhase.FAILED, "there is no such device at the robot now"))
            return
        described = self._scope.devices[device]
        sources = [source_as(signal.source, RosSource) for signal in described.signals.values()]
        wanted = {_key(source.topic, source.type) for source in sources if source.topic}
        for plan in self._plans:
            if _key(plan.topic, plan.type_name) in wanted - self._listening.keys():
                self._plan(plan)
        others = {f"stream {device}/{stream}" for stream in described.streams}
        wanted |= (others | {f"frames {device}"}) & self._listening.keys()
        for key in wanted & self._listening.keys():
            self._drop(self._listening[key])
        commands.rejoin(device)
        self._update_subscriptions()

        def absent() -> list[str]:
            return sorted(self._unheard(wanted)) + commands.absent(device)

        self._rejoining.begin(len(wanted) + len(described.commands), absent, done)

    def _unheard(self, wanted: Collection[str]) -> list[str]:
        """Name the topics that nobody publishes now, and types not known here."""
        unheard = []
        for key in wanted:
            listening = self._listening.get(key)
            if listening is None:
                unheard.append(f"{key.split(' ', 1)[0]} (its type is not known here)")
            elif listening.subscription is None:
                unheard.append(f"{listening.topic} (nobody publishes it)")
        return unheard

    def _update_subscriptions(self, *, everything: bool = True) -> None:
        """Bring subscriptions in line with what is wanted and with what publishers offer."""
        self._look_at_streams()
        self._look_at_frames()
        if self._raw is not None:
            self._look_at_recorded(self._raw)
        for listening in self._listening.values():
            if everything or listening.subscription is None:
                self._match(listening)

    def _look_at_streams(self) -> None:
        for device_id, device in self._scope.devices.items():
            for stream_id, stream in device.streams.items():
                address = f"{device_id}/{stream_id}"
                key = f"stream {address}"
                if address in self._watched and key not in self._listening:
                    self._begin_stream(key, address, stream)
                elif address not in self._watched and key in self._listening:
                    self._drop(self._listening.pop(key))

    def _begin_stream(self, key: str, address: str, stream: Stream) -> None:
        source = source_as(stream.source, RosSource)
        kind = self._class(source.type, source.topic)
        if kind is None:
            return
        decode = decoder_for(source.type, lambda data: deserialize_message(data, kind))
        taker = PictureStream(address, stream, decode, self._unreadable.report)
        worker = self._worker

        def offer_picture(raw: bytes, _: Any) -> None:  # noqa: ANN401
            if worker is not None:
                worker.offer(taker, raw)

        self._listening[key] = _Listening(source.topic, kind, PICTURE_DEPTH, offer_picture)

    def _look_at_frames(self) -> None:
        files = self._files
        for device_id in self._scope.devices if files is not None else ():
            source, key = _frames_of(self._scope, device_id), f"frames {device_id}"
            if source is None or key in self._listening or files is None:
                continue
            kind = self._class(source.type, source.topic)
            if kind is None:
                continue
            decode = decoder_for(source.type, partial(deserialize_message, message_type=kind))

            def keep_file(
                raw: bytes,
                _: Any,  # noqa: ANN401
                *,
                device: str = device_id,
                files: FileSink = files,
                decode: Callable[[bytes], object] = decode,
            ) -> None:
                files.keep_file(device, lambda: file_in(decode(raw)))

            self._listening[key] = _Listening(source.topic, kind, FILE_DEPTH, keep_file)

    def _look_at_recorded(self, sink: RawSink) -> None:
        """Hear topics that are recorded and that nothing else reads; the graph tells their type."""
        heard = {
            listener.topic for key, listener in self._listening.items() if key[:7] not in _APART
        }
        for topic in sink.topics - heard:
            offered = [
                publisher.topic_type for publisher in self._node.get_publishers_info_by_topic(topic)
            ]
            kind = self._class(offered[0], topic) if offered else None
            if kind is not None:
                self._listening[f"raw {topic}"] = _Listening(
                    topic, kind, DEPTH, self._recording(sink, topic, offered[0])
                )

    def _recording(self, sink: RawSink, topic: str, type_name: str) -> Callable[[bytes, Any], None]:
        def record_message(raw: bytes, info: Any) -> None:  # noqa: ANN401
            now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
            time_us = self._arrivals.at(info["received_timestamp"] // 1000, now_us, now_ns)
            sink.offer(topic, type_name, raw, time_us * 1000)

        return record_message

    def _match(self, listening: _Listening) -> None:
        offers = [
            QosProfile(
                info.qos_profile.reliability != ReliabilityPolicy.BEST_EFFORT,
                info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
            )
            for info in self._node.get_publishers_info_by_topic(listening.topic)
        ]
        # Before anybody publishes there is nothing to match, and a wrong guess would have to be
        # changed just when the first messages come.
        if not offers or (listening.quality is not None and fits(listening.quality, offers)):
            return
        self._drop(listening)
        listening.quality = quality_for(offers)
        profile = QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=listening.depth,
            reliability=ReliabilityPolicy.RELIABLE
            if listening.quality.reliable
            else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL
            if listening.quality.latched
            else DurabilityPolicy.VOLATILE,
        )
        listening.subscription = self._node.create_subscription(
            listening.kind, listening.topic, _never, profile, raw=True
        )
        if self._thread is not None:
            self._thread.add_subscription(
                listening.subscription.handle, listening.kind, listening.taken
            )

    def _drop(self, listening: _Listening) -> None:
        if listening.subscription is not None and self._thread is not None:
            self._thread.remove_subscription(listening.subscription.handle)
            self._node.destroy_subscription(listening.subscription)
        listening.subscription, listening.quality = None, None


def _frames_of(scope: ConnectionScope, device: str) -> RosSource | None:
    described = scope.devices.get(device)
    frames = None if described is None else described.frames
    return frames if isinstance(frames, RosSource) else None


def _stream_of(scope: ConnectionScope, device: str, stream: str) -> Stream | None:
    described = scope.devices.get(device)
    return None if described is None else described.streams.get(stream)


def _moved(before: ConnectionScope, after: ConnectionScope, address: str) -> bool:
    """Tell whether a signal's newest reading says nothing of what is described there now."""
    if address not in after.guarded:
        return True
    device, _, signal = address.partition("/")
    if device not in before.devices or device not in after.devices:
        return True
    was, now = before.devices[device].signals.get(signal), after.devices[device].signals[signal]
    return was is None or (was.source, was.type, was.scale) != (now.source, now.type, now.scale)


def _fast_dds_domain(described: int | None) -> int | None:
    """Give the domain's number where Fast DDS is in use, or None."""
    if not rclpy.get_rmw_implementation_identifier().startswith("rmw_fastrtps"):
        return None
    return domain_of(os.environ.get("ROS_DOMAIN_ID") if described is None else str(described))


def _key(topic: str, type_name: str) -> str:
    return f"{topic} {type_name}"


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""


def _fail(future: asyncio.Future[None], error: BaseException) -> None:
    if future.done():
        return
    if not isinstance(error, AdapterLost):
        error = AdapterLost(f"ROS 2 was lost: {type(error).__name__}: {error}")
    future.set_exception(error)
