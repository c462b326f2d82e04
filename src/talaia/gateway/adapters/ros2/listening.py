"""What a gateway listens to on ROS 2: signals, streams, frames and what is recorded.

It turns the description of a scope into wanted topics and their readers. On the wait-set thread.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from rclpy.serialization import deserialize_message

from talaia.gateway.adapters.ros2.decode import decoder_for
from talaia.gateway.adapters.ros2.typed_topic import Deliver, TypedTopic
from talaia.gateway.adapters.topic_readers import SampleBuffer, TopicPlan, file_in
from talaia.gateway.errors import FieldError
from talaia.gateway.video.camera import PictureStream
from talaia.model.connection import RosSource, source_as

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.clock import Clock
    from talaia.gateway.adapters.arrival_times import Arrivals
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros2.subscriptions import Ros2Subscriptions
    from talaia.gateway.adapters.ros2.topic_types import TopicType, TopicTypes
    from talaia.gateway.adapters.unreadable_reports import UnreadableReports
    from talaia.gateway.ports import FileSink, RawSink
    from talaia.gateway.video.worker import PictureWorker
    from talaia.model.site import Stream

__all__ = ["Ros2Listening"]

# Far more than comes between two turns of the wait set: when a transport was stuck (after a crash
# for seconds), a reliable publisher sends all of it again at once, and what is over this is lost
# without a trace. Memory is taken only as it is needed.
_DEPTH = 5_000
# Of pictures that somebody looks at, only the newest counts.
_PICTURE_DEPTH = 1
# A file may have many megabytes, and a camera takes its time for each.
_FILE_DEPTH = 4
# What is listened to under keys that begin so does not also record.
_APART = ("stream ", "frames ")


class Ros2Listening:
    """All that one scope wants to hear."""

    def __init__(
        self,
        *,
        scope: ConnectionScope,
        plans: list[TopicPlan],
        subscriptions: Ros2Subscriptions,
        types: TopicTypes,
        clock: Clock,
        gathered: SampleBuffer,
        heard_ns: dict[str, int],
        arrivals: Arrivals,
        unreadable: UnreadableReports,
        worker: PictureWorker,
        files: FileSink | None,
        raw: RawSink | None,
    ) -> None:
        """Want the topics of the scope's signals.

        Args:
            scope: what is described.
            plans: of its topics.
            subscriptions: of the node.
            types: finds how topics are read.
            clock: for times of arrival.
            gathered: where samples go.
            heard_ns: when a message came last, monotonic, by topic; written here.
            arrivals: makes times of arrival out of the transport's.
            unreadable: told what cannot be read.
            worker: makes pictures of streams.
            files: takes files of cameras; none where nobody keeps them.
            raw: takes messages as they came; none where nothing is recorded.

        """
        self._scope = scope
        # One for each topic and type that signals are read from; they hold what is held back.
        self._plans = plans
        self._subscriptions = subscriptions
        self._types = types
        self._clock = clock
        self._gathered = gathered
        self._heard_ns = heard_ns
        self._arrivals = arrivals
        self._unreadable = unreadable
        self._worker = worker
        self._files = files
        self._raw = raw
        for plan in plans:
            self._want_plan(plan)

    def redescribe(self, scope: ConnectionScope, plans: list[TopicPlan]) -> None:
        """Bring what is wanted in line with another scope; what is the same goes on unbroken."""
        before, self._scope = self._scope, scope
        old = {_key(plan.topic, plan.type_name): plan for plan in self._plans}
        wanted = {_key(plan.topic, plan.type_name): plan for plan in plans}
        self._plans = plans
        for key in old.keys() - wanted.keys():
            self._subscriptions.unwant(key)
        for key, plan in wanted.items():
            if key in old:
                plan.take_over(old[key])
            # Who reads a topic also records it.
            self._subscriptions.unwant(f"raw {plan.topic}")
            self._want_plan(plan)
        for key in [key for key in self._subscriptions.wanted if key.startswith("stream ")]:
            device, _, stream = key.removeprefix("stream ").partition("/")
            if _stream_of(before, device, stream) != _stream_of(scope, device, stream):
                self._subscriptions.unwant(key)
        for device in [device for device in before.devices if _frames_of(before, device)]:
            if _frames_of(before, device) != _frames_of(scope, device):
                self._subscriptions.unwant(f"frames {device}")

    def update(self, watched: Collection[str], *, everything: bool = True) -> None:
        """Bring subscriptions in line with what is wanted and with what publishers offer.

        Args:
            watched: streams that somebody looks at, as ``device/stream``.
            everything: also look at topics that are subscribed, which costs more.

        """
        self._update_streams(watched)
        self._want_frames()
        if self._raw is not None:
            self._want_recorded(self._raw)
        self._subscriptions.match_publishers(everything=everything)

    def begin_anew(self, device: str) -> set[str]:
        """End a device's subscriptions, for `update` to make them anew.

        Returns:
            the keys of what the device listens to.

        """
        described = self._scope.devices[device]
        sources = [source_as(signal.source, RosSource) for signal in described.signals.values()]
        wanted = {_key(source.topic, source.type) for source in sources if source.topic}
        for plan in self._plans:
            # Its type may have been installed since.
            if _key(plan.topic, plan.type_name) in wanted - self._subscriptions.wanted:
                self._want_plan(plan)
        others = {f"stream {device}/{stream}" for stream in described.streams}
        wanted |= (others | {f"frames {device}"}) & self._subscriptions.wanted
        self._subscriptions.unsubscribe(wanted)
        return wanted

    def name_unheard(self, keys: Collection[str]) -> list[str]:
        """See `Ros2Subscriptions.name_unheard`."""
        return self._subscriptions.name_unheard(keys)

    def _want_plan(self, plan: TopicPlan) -> None:
        """Let a plan read its topic's messages; a subscription that is there already stays."""
        recorded = self._raw if self._raw is not None and plan.topic in self._raw.topics else None

        def deliver_as(kind: TopicType) -> Deliver:
            # Looked up once: this runs for each message.
            decode, read_message, gathered = kind.decode, plan.read_message, self._gathered

            def deliver(raw: bytes, time_us: int, mono_ns: int) -> None:
                if recorded is not None:
                    recorded.offer(
                        plan.topic, plan.type_name, raw, time_us * 1000, definition=kind.schema
                    )
                try:
                    message = decode(raw)
                except FieldError as error:
                    self._unreadable.report_once(plan.topic, error.problem)
                    return
                read_message(message, time_us, mono_ns, gathered)

            return deliver

        reader = self._reader(plan.topic, plan.type_name, deliver_as)
        key = _key(plan.topic, plan.type_name)
        self._subscriptions.want(key, plan.topic, plan.type_name, depth=_DEPTH, reader=reader)

    def _reader(
        self, topic: str, type_name: str, deliver_as: Callable[[TopicType], Deliver]
    ) -> _TimedReader:
        typed = TypedTopic(topic, type_name, self._types, deliver_as)
        # Looked up once: this runs for each message.
        wall_ns, monotonic_ns = self._clock.wall_ns, self._clock.monotonic_ns
        arrival_time, heard_ns = self._arrivals.arrival_time, self._heard_ns

        def read_message(raw: bytes, info: Any) -> None:  # noqa: ANN401
            now_ns = monotonic_ns()
            time_us = arrival_time(info["received_timestamp"] // 1000, wall_ns() // 1000, now_ns)
            heard_ns[topic] = now_ns
            (typed.deliver or typed.hold_message)(raw, time_us, now_ns)

        return _TimedReader(typed.set_publishers, read_message)

    def _update_streams(self, watched: Collection[str]) -> None:
        for device_id, device in self._scope.devices.items():
            for stream_id, stream in device.streams.items():
                address = f"{device_id}/{stream_id}"
                key = f"stream {address}"
                if address not in watched:
                    self._subscriptions.unwant(key)
                elif key not in self._subscriptions.wanted:
                    self._want_stream(key, address, stream)

    def _want_stream(self, key: str, address: str, stream: Stream) -> None:
        source = source_as(stream.source, RosSource)
        kind = self._types.installed_class(source.type, source.topic)
        if kind is None:
            return
        decode = decoder_for(source.type, lambda data: deserialize_message(data, kind))
        pictures = PictureStream(address, stream, decode, self._unreadable.report_unreadable)

        def offer_picture(raw: bytes, _: Any) -> None:  # noqa: ANN401
            self._worker.offer_raw(pictures, raw)

        reader = _TimedReader(_any_version, offer_picture)
        self._subscriptions.want(
            key, source.topic, source.type, depth=_PICTURE_DEPTH, reader=reader, large=True
        )

    def _want_frames(self) -> None:
        files = self._files
        for device_id in self._scope.devices if files is not None else ():
            source, key = _frames_of(self._scope, device_id), f"frames {device_id}"
            if source is None or key in self._subscriptions.wanted or files is None:
                continue
            kind = self._types.installed_class(source.type, source.topic)
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

            reader = _TimedReader(_any_version, keep_file)
            self._subscriptions.want(
                key, source.topic, source.type, depth=_FILE_DEPTH, reader=reader
            )

    def _want_recorded(self, sink: RawSink) -> None:
        """Hear topics that are recorded and that nothing else reads; the graph tells their type."""
        for topic in sink.topics - self._subscriptions.topics(without=_APART):
            type_name = self._subscriptions.offered_type(topic)
            if not type_name:
                continue

            def record_as(
                kind: TopicType, *, topic: str = topic, type_name: str = type_name
            ) -> Deliver:
                return lambda raw, time_us, _: sink.offer(
                    topic, type_name, raw, time_us * 1000, definition=kind.schema
                )

            reader = self._reader(topic, type_name, record_as)
            self._subscriptions.want(f"raw {topic}", topic, type_name, depth=_DEPTH, reader=reader)


class _TimedReader:
    """A `TopicReader` of two functions."""

    def __init__(
        self,
        set_publishers: Callable[[frozenset[str]], None],
        read_message: Callable[[bytes, Any], None],
    ) -> None:
        # As attributes, for each message goes through them.
        self.set_publishers = set_publishers
        self.read_message = read_message


def _any_version(_: frozenset[str]) -> None:
    """Stand where the versions of a type are no question: pictures and files say what they are."""


def _frames_of(scope: ConnectionScope, device: str) -> RosSource | None:
    described = scope.devices.get(device)
    frames = None if described is None else described.frames
    return frames if isinstance(frames, RosSource) else None


def _stream_of(scope: ConnectionScope, device: str, stream: str) -> Stream | None:
    described = scope.devices.get(device)
    return None if described is None else described.streams.get(stream)


def _key(topic: str, type_name: str) -> str:
    return f"{topic} {type_name}"
