"""rosbag 1, and rosbag 2 with either storage, as topics and raw messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2

from talaia.cli.importing.decoding import Definition, ros_type

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

    from rosbags.interfaces import Connection

__all__ = ["Bag"]

# The recording's word for a definition's language, to the word of `Definition.form`.
_FORMS = {
    MessageDefinitionFormat.MSG: "msg",
    MessageDefinitionFormat.IDL: "idl",
    MessageDefinitionFormat.NONE: "",
}


class Bag:
    """A bag that is open; see `talaia.cli.importing.messages.MessageFile`."""

    def __init__(self, path: Path, kind: str) -> None:
        """Open a file or a folder; raises what rosbags raises."""
        ros1 = kind == "rosbag 1"
        # Reads file and folder alike: a rosbag 2 may be one SQLite file without its metadata.
        self._reader = Reader1(path) if ros1 else Reader2(path)
        self._reader.open()
        # ROS 1 serializes in its own way; a rosbag 2 holds CDR, whichever storage it has.
        self._encoding = "ros1" if ros1 else "cdr"
        # By the reader's number: in a rosbag 1 each publisher of a topic is a connection of its
        # own.
        self._connections = {connection.id: connection for connection in self._reader.connections}
        # For the progress alone; it counts topics that are not read, too.
        self.count = self._reader.message_count
        # See `MessageFile.topics`; what the description reads is matched with these.
        self.topics = {
            number: (connection.topic, self._definition_of(connection))
            for number, connection in self._connections.items()
        }

    def iterate_messages(self, wanted: Collection[int]) -> Iterator[tuple[int, int, bytes]]:
        """Give number of the topic, time (ns) and bytes, in order of time."""
        chosen = [self._connections[number] for number in wanted]
        for connection, time_ns, data in self._reader.messages(connections=chosen):
            # The time of recording, which is there for every type; stamps inside are not.
            yield connection.id, time_ns, bytes(data)

    def reading_place(self) -> str:
        """Nothing is known of where the reader stands."""
        return ""

    def close(self) -> None:
        """Let go of the files."""
        self._reader.close()

    def _definition_of(self, connection: Connection) -> Definition:
        definition = connection.msgdef
        return Definition(
            self._encoding,
            ros_type(connection.msgtype),
            _FORMS[definition.format],
            definition.data,
        )
