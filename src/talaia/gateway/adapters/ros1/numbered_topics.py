"""Every topic that may be listened to at ROS 1, by its number, and who reads it.

The pipe from the node carries numbers, not names. Two things hold while a node runs: a number means
the same topic and the same reader, and no message is decoded by a definition that its own publisher
has not told. Numbers are given anew before each start of the node. Long, because whoever reads a
topic reads it under its number.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros1.decode import decoder_of, full_name
from talaia.gateway.adapters.topic_readers import (
    SampleBuffer,
    file_in,
    make_live_plans,
    parameter_plans_of,
)
from talaia.gateway.errors import FieldError
from talaia.gateway.video.camera import PictureStream
from talaia.model.connection import RosSource, source_as, topic_of
from talaia.model.list_texts import list_text

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros1.frames import ReceivedMessage
    from talaia.gateway.adapters.ros1.robot_messages import RobotMessages, RobotTopic
    from talaia.gateway.adapters.topic_readers import TopicPlan
    from talaia.gateway.adapters.unreadable_reports import UnreadableReports
    from talaia.gateway.ports import AdapterContext, ChannelReading, FileSink
    from talaia.gateway.video.worker import PictureWorker
    from talaia.model.site import Stream

__all__ = ["NumberedTopics"]

# Messages that rospy keeps for a reader that is behind.
DEPTH = 1_000
# A message cannot have waited longer than that, unless a clock was set meanwhile (µs).
_MAX_LATE_US = 1_000_000


class _Topic(NamedTuple):
    """A topic that is listened to: who reads its messages, and how often they may come."""

    name: str
    # As described; empty where any type will do.
    type_name: str
    read: Callable[[ReceivedMessage], None]
    # Hz; 0 for all of them.
    rate: float = 0.0


class NumberedTopics:
    """All topics of one connection.

    Numbered on the event loop while no node runs; read on the node's thread.

    Attributes:
        latest: by address: newest readings of signals that safety depends on; any thread reads.

    """

    def __init__(
        self,
        scope: ConnectionScope,
        context: AdapterContext,
        unreadable: UnreadableReports,
        robot: RobotMessages,
    ) -> None:
        """Take what is wanted of the robot, where it goes, and who is told what cannot be read."""
        self._scope, self._unreadable, self._robot = scope, unreadable, robot
        self._clock, self._samples = context.clock, context.samples
        self._raw, self._files = context.raw, context.files
        self.latest: dict[str, ChannelReading] = {}
        # By topic: when a message came last; none where nobody asks.
        self._heard_ns: dict[str, int] | None = None
        # What was read and is not given out yet.
        self._gathered = SampleBuffer()
        # A plan's number is its place here.
        self._plans = make_live_plans(scope, self.latest, unreadable, robot.shift_us)
        self._parameters = parameter_plans_of(scope, self.latest, unreadable.report_unreadable)
        self._topics: dict[int, _Topic] = {}
        # By address: cameras, which are listened to only while somebody looks at them.
        self._streams: dict[str, int] = {}
        # By device: where its FITS files come.
        self._frames: dict[str, int] = {}
        # Topics that are recorded and that nobody reads, and those of the robot itself.
        self._recorded: list[int] = []
        self._of_robot: list[int] = []
        # By number: the type and its definition, as the publisher told them.
        self._told: dict[int, tuple[str, str]] = {}
        # By number: reads messages of that definition; none while it is not known or not fitting.
        self._decoders: dict[int, Callable[[bytes], object]] = {}

    # ── on the event loop ──

    @property
    def streams(self) -> Mapping[str, int]:
        """Numbers of cameras, by address."""
        return self._streams

    @property
    def parameters(self) -> list[str]:
        """Names of the parameters that are signals; a value's number is its place here."""
        return [parameter.topic for parameter in self._parameters]

    def number_topics(self, worker: PictureWorker) -> None:
        """Number every topic that may be listened to; ``worker`` decodes pictures."""
        self._topics.clear()
        self._streams.clear()
        self._frames.clear()
        for plan in self._plans:
            self._number_plan(plan)
        for device_id, device in self._scope.devices.items():
            for stream_id, stream in device.streams.items():
                self._number_stream(f"{device_id}/{stream_id}", stream, worker)
        if self._files is not None:
            for device_id, device in self._scope.devices.items():
                if isinstance(device.frames, RosSource):
                    self._number_files(device_id, device.frames, self._files)
        self._number_recorded()
        self._robot.forget_time()
        self._of_robot = [self._number_robot(topic) for topic in self._robot.topics]

    def write_arrivals(self, heard_ns: dict[str, int] | None) -> None:
        """Write from now on when each topic's last message came (monotonic, ns); none: nowhere."""
        self._heard_ns = heard_ns

    def forget_types(self) -> None:
        """Forget how messages are decoded: the next node's publishers tell it anew."""
        self._decoders.clear()

    def standing_numbers(self) -> list[int]:
        """Give what is listened to all the time."""
        standing = (*self._frames.values(), *self._recorded, *self._of_robot)
        return [*range(len(self._plans)), *standing]

    def device_numbers(self, device: str, watched: Collection[str]) -> list[int]:
        """Give what belongs to a device, of its cameras only those that are ``watched``."""
        described = self._scope.devices[device]
        topics = {topic_of(signal.source) for signal in described.signals.values()}
        apart = (*self._streams.values(), *self._frames.values())
        numbers = [
            number
            for number, topic in self._topics.items()
            if topic.name and topic.name in topics and number not in apart
        ]
        numbers += [
            self._streams[address]
            for address in sorted(self._streams.keys() & set(watched))
            if address.startswith(f"{device}/")
        ]
        if device in self._frames:
            numbers.append(self._frames[device])
        return numbers

    def device_topics(self, device: str, watched: Collection[str]) -> set[str]:
        """Name the topics of a device: those of its signals, and those of `device_numbers`."""
        described = self._scope.devices[device]
        signals = {topic_of(signal.source) for signal in described.signals.values()}
        numbers = self.device_numbers(device, watched)
        return {*(topic for topic in signals if topic), *(self._topics[n].name for n in numbers)}

    def listen_frame(self, number: int) -> dict[str, object]:
        """Ask the node to listen to a topic."""
        topic = self._topics[number]
        # What is thinned out is a picture: only the newest is worth keeping.
        depth = 1 if topic.rate else DEPTH
        return {
            "op": "listen",
            "topic": number,
            "name": topic.name,
            "rate": topic.rate,
            "deep": depth,
        }

    def _add_topic(self, topic: _Topic) -> int:
        number = len(self._topics)
        self._topics[number] = topic
        return number

    def _number_plan(self, plan: TopicPlan) -> None:
        number = len(self._topics)

        def read(heard: ReceivedMessage) -> None:
            self._record_message(heard, number)
            decode = self._decoders.get(number)
            if decode is None:
                return
            now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
            # It came when the node had it; unless clocks jumped.
            late_us = now_us - heard.time_us
            late_us = late_us if 0 <= late_us < _MAX_LATE_US else 0
            mono_ns = now_ns - late_us * 1000
            # Read once: the event loop may take it away meanwhile.
            heard_ns = self._heard_ns
            if heard_ns is not None:
                heard_ns[plan.topic] = now_ns
            plan.read_message(decode(heard.raw), now_us - late_us, mono_ns, self._gathered)

        self._add_topic(_Topic(plan.topic, plan.type_name, read))

    def _number_stream(self, address: str, stream: Stream, worker: PictureWorker) -> None:
        number = len(self._topics)

        def decode(raw: bytes) -> object:
            known = self._decoders.get(number)
            if known is None:
                raise FieldError("", "its type is not known")
            return known(raw)

        reader = PictureStream(address, stream, decode, self._unreadable.report_unreadable)

        def read(heard: ReceivedMessage) -> None:
            worker.offer_raw(reader, heard.raw)

        source = source_as(stream.source, RosSource)
        # A little more than is shown, so that the two paces do not lose every other one.
        rate = stream.max_rate * 1.5
        self._streams[address] = self._add_topic(_Topic(source.topic, source.type, read, rate))

    def _number_files(self, device: str, source: RosSource, files: FileSink) -> None:
        number = len(self._topics)

        def read(heard: ReceivedMessage) -> None:
            decode = self._decoders.get(number)
            if decode is not None:
                # Decoded on the archive's thread: a file may have 100 MB.
                files.keep_file(device, lambda: file_in(decode(heard.raw)))

        self._frames[device] = self._add_topic(_Topic(source.topic, source.type, read))

    def _number_recorded(self) -> None:
        self._recorded = []
        # What is read as signals is recorded on the way; the rest is listened to for that alone.
        of_signals = {plan.topic for plan in self._plans}
        for name in sorted(self._raw.topics - of_signals) if self._raw is not None else ():
            number = len(self._topics)

            def read(heard: ReceivedMessage, number: int = number) -> None:
                self._record_message(heard, number)

            self._recorded.append(self._add_topic(_Topic(name, "", read)))

    def _number_robot(self, topic: RobotTopic) -> int:
        number = len(self._topics)

        def read(heard: ReceivedMessage) -> None:
            decode = self._decoders.get(number)
            if decode is not None:
                topic.read(heard.raw, heard.time_us, decode)

        return self._add_topic(_Topic(topic.name, topic.type_name, read, topic.rate))

    # ── on the node's thread ──

    def read_message(self, heard: ReceivedMessage) -> None:
        """Give a message to its reader."""
        topic = self._topics.get(heard.topic)
        if topic is None:
            return
        try:
            topic.read(heard)
        except FieldError as error:
            self._unreadable.report_once(topic.name, str(error))

    def read_parameter(self, frame: Mapping[str, Any]) -> None:
        """Read a parameter's value, as a message with it as ``data``."""
        plan = self._parameters[frame["number"]]
        value = frame["value"]
        message = SimpleNamespace(data=list_text(value) if isinstance(value, list) else value)
        plan.read_message(message, frame["at"], self._clock.monotonic_ns(), self._gathered)

    def learn_type(self, frame: Mapping[str, Any]) -> None:
        """Take in the type of a topic's next messages, as its publisher has told it."""
        number = frame["topic"]
        topic, found = self._topics[number], full_name(frame["type"])
        # Whatever comes next is not of the type before.
        self._decoders.pop(number, None)
        self._told[number] = (found, frame["definition"])
        if not topic.type_name:
            return
        if found != topic.type_name:
            problem = f"is of type {found}, and not {topic.type_name} as the description says"
            self._unreadable.report_once(topic.name, problem)
            return
        try:
            self._decoders[number] = decoder_of(found, frame["definition"])
        except FieldError as error:
            self._unreadable.report_once(topic.name, str(error))

    def publish_samples(self) -> None:
        """Give out what was read, and what was held back and is due."""
        now_us = self._clock.wall_ns() // 1000
        for plan in (*self._plans, *self._parameters):
            plan.take_due(now_us, self._gathered)
        columns = self._gathered.take_columns()
        if columns is not None:
            self._samples.put_samples(columns)

    def _record_message(self, heard: ReceivedMessage, number: int) -> None:
        """Give a message to who records, if it is one of those and its type is known."""
        topic, told = self._topics[number].name, self._told.get(number)
        if self._raw is not None and told is not None and topic in self._raw.topics:
            self._raw.offer(
                topic,
                told[0],
                heard.raw,
                heard.time_us * 1000,
                definition=told[1],
                encoding="ros1",
            )
