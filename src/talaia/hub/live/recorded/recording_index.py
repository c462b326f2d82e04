"""An MCAP file read at any moment by its index: bounded in bytes, on the caller's thread.

Any writer's file that has an index will do. Nothing is read but the chunks that hold what is asked
for; a file may have been made by anyone who has a gateway's key, so sizes are judged before
anything is unpacked.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.hub.live.recorded.errors import RecordingUnreadable
from talaia.hub.live.recorded.mcap_records import (
    McapDamaged,
    messages_of_chunk,
    read_mcap_summary,
)
from talaia.model.topics import is_latched_by_convention

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from typing import BinaryIO

    from talaia.hub.files.ports import Openable
    from talaia.hub.live.recorded.mcap_records import (
        ChannelRecord,
        ChunkIndexRecord,
        McapSummary,
        MessageRecord,
        SchemaRecord,
    )

__all__ = ["RecordedMessage", "RecordedStretch", "RecordedTopic", "RecordingIndex"]

# Of one chunk, packed and unpacked: writers make them of a few megabytes (bytes).
_MOST_CHUNK = 64 * 1024 * 1024
# Bytes that are unpacked for one question.
_MOST_UNPACKED = 256 * 1024 * 1024
# Bytes of a message that is never thinned out: transforms and joints that come behind one another
# are often of different parts.
_LIGHT = 4096
# Chunks that are read for the last message before a moment: chunks may overlap a little.
_MOST_BACK = 6
# Of a latched topic, said before a moment: so many messages, so many chunks.
_MOST_LATCHED, _MOST_LATCHED_CHUNKS = 100, 32
# Encodings of messages that can be read.
_READABLE = ("cdr", "ros1")


class RecordedTopic(NamedTuple):
    """A topic of a recording.

    Attributes:
        topic: its absolute name.
        type: ``package/msg/Name``, also where ROS 1 recorded it.
        latched: what it said holds until it says something else.
        encoding: of the messages: ``cdr`` or ``ros1``.
        form: of the definition: ``ros2msg``, ``ros2idl`` or ``ros1msg``.
        definition: how its messages are read.
        problem: why they cannot be read; empty: they can.

    """

    topic: str
    type: str
    latched: bool
    encoding: str
    form: str
    definition: str
    problem: str = ""


class RecordedMessage(NamedTuple):
    """A message as it was recorded.

    Attributes:
        time_us: when it came to who recorded it (UTC).
        publish_us: when it was published (UTC).
        data: as the robot serialized it.

    """

    topic: str
    time_us: int
    publish_us: int
    data: bytes


class RecordedStretch(NamedTuple):
    """What was read of a stretch of time.

    Attributes:
        messages: by time; those of before the stretch first.
        until_us: all up to here is there (not included); less than was asked for where there
            was too much.

    """

    messages: list[RecordedMessage]
    until_us: int


class RecordingIndex:
    """One file's index.

    Attributes:
        topics: by name; of two definitions of one name the later one.
        begin_us: of its first message (UTC).
        end_us: of its last one (UTC).
        count: how many messages are in it.

    """

    def __init__(self, file: Openable) -> None:
        """Read the index of a file.

        Raises:
            RecordingUnreadable: it is none, or has no index.
            OSError: it cannot be read.

        """
        self._file = file
        with file.open("rb") as stream:
            self._summary = _read_summary(stream)
        self._chunks = sorted(
            self._summary.chunk_indexes, key=lambda chunk: chunk.message_start_time
        )
        self.topics = {
            channel.topic: _topic_of(channel, self._summary.schemas.get(channel.schema_id))
            for channel in self._summary.channels.values()
        }
        # A latched message that was put before the others has no time of its own.
        self.begin_us = min(chunk.message_start_time for chunk in self._chunks) // 1000
        self.end_us = max(chunk.message_end_time for chunk in self._chunks) // 1000
        self.count = self._summary.message_count

    def read_stretch(
        self, rates: Mapping[str, float], from_us: int, to_us: int, *, most_bytes: int
    ) -> RecordedStretch:
        """Read the messages of topics from ``from_us`` on, before ``to_us``, and the last before.

        Of a latched topic all that was said before counts, as far as there is room.

        Args:
            rates: topics, and how many messages a second of each are wanted (Hz).
            from_us: see above.
            to_us: see above.
            most_bytes: of messages together; the first chunk is read in any case.

        Raises:
            RecordingUnreadable: the file is damaged, or its chunks are too large.
            OSError: it cannot be read.

        """
        with self._file.open("rb") as stream:
            chunks = _ChunkReader(stream, self._summary, rates)
            before = [
                message
                for topic in rates
                for message in self._last_before(chunks, topic, from_us * 1000)
            ]
            before.sort(key=lambda message: message.log_time)
            span_ns = (from_us * 1000, to_us * 1000)
            within, until_ns = self._within(chunks, _RateGate(rates), span_ns, most_bytes)
            topic_of = chunks.topic_of
        found = [
            RecordedMessage(
                topic_of[message.channel_id],
                message.log_time // 1000,
                message.publish_time // 1000,
                message.data,
            )
            for message in (*before, *within)
        ]
        return RecordedStretch(found, until_ns // 1000)

    def _within(
        self, chunks: _ChunkReader, gate: _RateGate, span_ns: tuple[int, int], most_bytes: int
    ) -> tuple[list[MessageRecord], int]:
        from_ns, until_ns = span_ns
        found: list[MessageRecord] = []
        size = 0
        for chunk in self._chunks:
            if chunk.message_start_time >= until_ns:
                break
            if chunk.message_end_time < from_ns or not chunks.holds_any(chunk):
                continue
            # All that lies before this chunk's begin is there.
            if size > most_bytes and chunk.message_start_time > from_ns:
                until_ns = chunk.message_start_time
                break
            for message in chunks.messages_of(chunk):
                if from_ns <= message.log_time < until_ns and gate.passes(
                    chunks.topic_of[message.channel_id], message
                ):
                    found.append(message)
                    size += len(message.data)
        found.sort(key=lambda message: message.log_time)
        return [message for message in found if message.log_time < until_ns], until_ns

    def _last_before(self, chunks: _ChunkReader, topic: str, from_ns: int) -> list[MessageRecord]:
        latched = self.topics[topic].latched if topic in self.topics else False
        held = [
            chunk
            for chunk in self._chunks
            if chunk.message_start_time < from_ns and chunks.holds(chunk, topic)
        ]
        # The one that ends last is looked at first.
        held.sort(key=lambda chunk: chunk.message_end_time, reverse=True)
        found: list[MessageRecord] = []
        for chunk in held[: _MOST_LATCHED_CHUNKS if latched else _MOST_BACK]:
            # No chunk that is left has anything later.
            if found and not latched and chunk.message_end_time < found[-1].log_time:
                break
            found += [
                message
                for message in chunks.messages_of(chunk)
                if message.log_time < from_ns and chunks.topic_of[message.channel_id] == topic
            ]
            found.sort(key=lambda message: message.log_time)
            found = found[-_MOST_LATCHED:] if latched else found[-1:]
        return found


class _RateGate:
    """Leaves out what comes oftener than is wanted, unless it is light."""

    def __init__(self, rates: Mapping[str, float]) -> None:
        self._least_ns = {topic: SECOND / rate for topic, rate in rates.items() if rate > 0}
        self._next_ns: dict[str, float] = {}

    def passes(self, topic: str, message: MessageRecord) -> bool:
        if len(message.data) <= _LIGHT:
            return True
        least_ns = self._least_ns.get(topic, 0.0)
        if message.log_time < self._next_ns.get(topic, 0.0):
            return False
        # A little less: who publishes at just this rate is not halved.
        self._next_ns[topic] = message.log_time + 0.9 * least_ns
        return True


class _ChunkReader:
    """Unpacks chunks for one question, each once.

    Attributes:
        topic_of: the topics that are wanted, by the number of their channel.

    """

    def __init__(self, stream: BinaryIO, summary: McapSummary, topics: Mapping[str, float]) -> None:
        self._stream = stream
        self.topic_of = {
            number: channel.topic
            for number, channel in summary.channels.items()
            if channel.topic in topics
        }
        self._unpacked = 0
        self._read: dict[int, list[MessageRecord]] = {}

    def holds_any(self, chunk: ChunkIndexRecord) -> bool:
        """Tell whether any topic that is wanted may be in a chunk."""
        offsets = chunk.message_index_offsets
        # Some writers leave out which channels a chunk holds.
        return not offsets or any(number in offsets for number in self.topic_of)

    def holds(self, chunk: ChunkIndexRecord, topic: str) -> bool:
        """Tell whether a topic may be in a chunk."""
        offsets = chunk.message_index_offsets
        return not offsets or any(
            name == topic and number in offsets for number, name in self.topic_of.items()
        )

    def messages_of(self, chunk: ChunkIndexRecord) -> list[MessageRecord]:
        """Give the messages that are wanted of a chunk, by time.

        Raises:
            RecordingUnreadable: see `RecordingIndex.read_stretch`.

        """
        known = self._read.get(chunk.chunk_start_offset)
        if known is None:
            known = self._read[chunk.chunk_start_offset] = sorted(
                self._unpack(chunk), key=lambda message: message.log_time
            )
        return known

    def _unpack(self, index: ChunkIndexRecord) -> Iterator[MessageRecord]:
        self._unpacked += index.uncompressed_size
        if max(index.chunk_length, index.uncompressed_size) > _MOST_CHUNK:
            raise RecordingUnreadable(
                f"a part of it takes {index.uncompressed_size} bytes; {_MOST_CHUNK} is the most"
            )
        if self._unpacked > _MOST_UNPACKED:
            raise RecordingUnreadable("too much would have to be unpacked for this moment")
        self._stream.seek(index.chunk_start_offset)
        raw = self._stream.read(index.chunk_length)
        try:
            for message in messages_of_chunk(raw, index):
                if message.channel_id in self.topic_of:
                    yield message
        except McapDamaged as error:
            raise RecordingUnreadable(f"a part of it is damaged: {error}") from error


def _read_summary(stream: BinaryIO) -> McapSummary:
    try:
        summary = read_mcap_summary(stream, _MOST_CHUNK)
    except McapDamaged as error:
        raise RecordingUnreadable(f"it is no whole MCAP file: {error}") from error
    if summary is None or not summary.chunk_indexes:
        raise RecordingUnreadable("it has no index; `mcap recover` makes one")
    return summary


def _topic_of(channel: ChannelRecord, schema: SchemaRecord | None) -> RecordedTopic:
    name, form, text = (
        ("", "", b"") if schema is None else (schema.name, schema.encoding, schema.data)
    )
    package, _, short = name.partition("/")
    # ROS 1 has no folder between.
    type_name = f"{package}/msg/{short}" if short and "/" not in short else name
    problem = ""
    if channel.message_encoding not in _READABLE:
        problem = f"its messages are encoded as {channel.message_encoding}, which is not read here"
    return RecordedTopic(
        topic=channel.topic,
        type=type_name,
        latched=_is_latched(channel, type_name),
        encoding=channel.message_encoding,
        form=form,
        definition=text.decode("utf-8", "replace"),
        problem=problem,
    )


def _is_latched(channel: ChannelRecord, type_name: str) -> bool:
    """Tell whether what a topic said holds on: as the recorder says, else as ROS names it."""
    told = channel.metadata
    if told.get("latching") in ("1", "true"):
        return True
    # rosbag2 writes the profiles as YAML, with numbers before Jazzy.
    profiles = told.get("offered_qos_profiles", "").replace('"', "")
    if "durability: transient_local" in profiles or "durability: 1\n" in profiles:
        return True
    return is_latched_by_convention(channel.topic, type_name)
