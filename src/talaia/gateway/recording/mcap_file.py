"""MCAP files of ROS messages: written, and made whole again."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mcap.records import Channel, Header, Message, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from talaia import __version__
from talaia.gateway.recording.recording_store import RecoveredFile

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path
    from typing import BinaryIO

    from mcap.records import McapRecord

    from talaia.gateway.recording.message_ring import RawMessage

__all__ = ["McapFileWriter", "recover_file"]

# What a killed gateway loses of a recording is at most one chunk.
_CHUNK = 128 * 1024


class McapFileWriter:
    """One file that is being written. Used by one thread.

    Attributes:
        messages: how many are in it.
        size: bytes on the disk, about.

    """

    def __init__(self, path: Path, definition: Callable[[str], str]) -> None:
        """Begin a file; ``definition`` gives the full text of a type.

        Raises:
            OSError: it cannot be written.

        """
        self._stream = path.open("wb")
        # Begun by the first message, which tells the profile.
        self._begun: Writer | None = None
        self._definition = definition
        # By type and text: a topic's publisher may come back with another version.
        self._schemas: dict[tuple[str, str], int] = {}
        self._channels: dict[tuple[str, str, str], int] = {}
        self.messages = 0

    @property
    def size(self) -> int:
        """See above."""
        return self._stream.tell()

    @property
    def topics(self) -> list[str]:
        """The topics that have messages in it."""
        return sorted({topic for topic, _, _ in self._channels})

    def add_message(self, raw: RawMessage) -> None:
        """Write a message.

        Raises:
            OSError: the disk is full, or worse.
            NoDefinition: nothing is known of its type.

        """
        key = (raw.topic, raw.type_name, raw.definition)
        channel = self._channels.get(key)
        if channel is None:
            channel = self._channels[key] = self._channel_of(raw)
        said_ns = raw.said_ns or raw.time_ns
        self._writer_for().add_message(channel, raw.time_ns, raw.data, said_ns, self.messages)
        self.messages += 1

    def write_metadata(self, about: dict[str, str]) -> None:
        """Write what is known of the recording into it."""
        self._writer_for().add_metadata("talaia", about)

    def finish_file(self) -> None:
        """Write the index and close.

        Raises:
            OSError: the disk is full, or worse.

        """
        try:
            self._writer_for().finish()  # type: ignore[no-untyped-call]
            self._stream.flush()
        finally:
            self._stream.close()

    def drop_file(self) -> None:
        """Close without an index."""
        self._stream.close()

    def _channel_of(self, raw: RawMessage) -> int:
        writer = self._writer_for("ros1" if raw.encoding == "ros1" else "ros2")
        if raw.encoding == "ros1":
            package, _, name = raw.type_name.split("/")
            schema = writer.register_schema(f"{package}/{name}", "ros1msg", raw.definition.encode())
            return writer.register_channel(raw.topic, "ros1", schema)
        known = self._schemas.get((raw.type_name, raw.definition))
        if known is None:
            text = raw.definition or self._definition(raw.type_name)
            known = writer.register_schema(raw.type_name, "ros2msg", text.encode())
            self._schemas[raw.type_name, raw.definition] = known
        return writer.register_channel(raw.topic, "cdr", known, {"offered_qos_profiles": ""})

    def _writer_for(self, profile: str = "ros2") -> Writer:
        if self._begun is None:
            self._begun = _start_writer(self._stream, profile)
        return self._begun


def recover_file(broken: Path, whole: Path) -> RecoveredFile:
    """Copy all that can be read of a file into one with an index.

    Raises:
        OSError: it cannot be read or written.
        ValueError: there is no message in it.

    """
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    count = end_ns = 0
    with broken.open("rb") as source, whole.open("wb") as target:
        records = _whole_records(source)
        header = next(records, None)
        writer = _start_writer(target, header.profile if isinstance(header, Header) else "ros2")
        for record in records:
            match record:
                case Schema():
                    schemas[record.id] = writer.register_schema(
                        record.name, record.encoding, record.data
                    )
                case Channel():
                    channels[record.id] = writer.register_channel(
                        record.topic,
                        record.message_encoding,
                        schemas.get(record.schema_id, 0),
                        record.metadata,
                    )
                # Of a channel that was not damaged itself: else nobody knows what the message is.
                case Message() if record.channel_id in channels:
                    writer.add_message(
                        channels[record.channel_id],
                        record.log_time,
                        record.data,
                        record.publish_time,
                        record.sequence,
                    )
                    count += 1
                    end_ns = max(end_ns, record.log_time)
                case _:
                    continue
        writer.finish()  # type: ignore[no-untyped-call]
    if not count:
        whole.unlink()
        raise ValueError("it holds no message")
    return RecoveredFile(count, end_ns // 1000)


def _whole_records(source: BinaryIO) -> Iterator[McapRecord]:
    """Give the records up to where the file was cut off; none of what is no such file."""
    try:
        yield from StreamReader(source, validate_crcs=True).records
    except Exception:  # noqa: BLE001 - here it was cut off, however the reader says it
        return


def _start_writer(stream: object, profile: str) -> Writer:
    writer = Writer(stream, chunk_size=_CHUNK, compression=CompressionType.ZSTD)  # type: ignore[arg-type]
    writer.start(profile, library=f"talaia {__version__}")
    return writer
