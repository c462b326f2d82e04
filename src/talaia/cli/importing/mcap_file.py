"""An MCAP file with messages of ROS 1, ROS 2 or JSON, as topics and raw messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mcap.reader import NonSeekingReader, make_reader

from talaia.cli.importing.decoding import Definition, ros_type

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

    from mcap.records import Channel, Schema

__all__ = ["McapFile"]

# MCAP's registered names of encodings for definitions; all others cannot be read here.
_FORMS = {"ros2msg": "msg", "ros1msg": "msg", "ros2idl": "idl", "omgidl": "idl"}


class McapFile:
    """A file that is open; see `talaia.cli.importing.messages.MessageFile`."""

    def __init__(self, path: Path) -> None:
        """Open a file; raises what mcap raises."""
        # Closed by `close`, or at once when the file turns out to be none.
        self._stream = path.open("rb")
        # As the file's statistics say; 0 where its writer left them out.
        self.count = 0
        self.topics: dict[int, tuple[str, Definition]] = {}
        try:
            # With checksums: a flipped bit in a recording would else become a measured value.
            self._reader = make_reader(self._stream, validate_crcs=True)
            summary = self._reader.get_summary()
            if summary is None or not summary.channels:
                # Its writer left the index out: read it once to see what is in it.
                self._stream.seek(0)
                self._reader = NonSeekingReader(self._stream, validate_crcs=True)
                summary = self._reader.get_summary()
            if summary is not None:
                for number, channel in summary.channels.items():
                    self._add_definition(number, channel, summary.schemas.get(channel.schema_id))
                if summary.statistics is not None:
                    self.count = summary.statistics.message_count
        # Ctrl-C included: nobody has this object yet who could close it.
        except BaseException:
            self._stream.close()
            raise

    def iterate_messages(self, wanted: Collection[int]) -> Iterator[tuple[int, int, bytes]]:
        """Give number of the topic, time (ns) and bytes, in order of time."""
        # The reader chooses by topic; channels of one topic with another definition are dropped
        # below.
        topics = sorted({self.topics[number][0] for number in wanted})
        chosen = set(wanted)
        for _, channel, message in self._reader.iter_messages(topics=topics):
            if channel.id in chosen:
                # The recorder's time, as for bags: `publish_time` is whatever the publisher's clock
                # said.
                yield channel.id, message.log_time, message.data

    def reading_place(self) -> str:
        """Tell where in the file the reader stands."""
        return f"byte {self._stream.tell()}"

    def close(self) -> None:
        """Let go of the file."""
        self._stream.close()

    def _add_definition(self, number: int, channel: Channel, schema: Schema | None) -> None:
        name = ros_type(schema.name) if schema is not None else ""
        form = _FORMS.get(schema.encoding, "") if schema is not None else ""
        # Replaced, not refused: a comment in another encoding must not lose a topic.
        text = schema.data.decode("utf-8", "replace") if schema is not None and form else ""
        self.topics[number] = (
            channel.topic,
            Definition(channel.message_encoding, name, form, text),
        )
