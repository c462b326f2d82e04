"""Recorded messages to samples, through the same plans that a gateway reads a robot with."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

from talaia.cli.errors import BadFile
from talaia.cli.importing.bags import Bag
from talaia.cli.importing.decoding import Undecodable, decoder_of, ros_type
from talaia.cli.importing.mcap_file import McapFile
from talaia.cli.importing.source import Findings, Piece
from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.adapters.topic_readers import SampleBuffer, plans_of
from talaia.model.connection import (
    Ros1Connection,
    Ros2Connection,
    RosbridgeConnection,
    RosSource,
    source_as,
)
from talaia.model.site import parts_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping
    from pathlib import Path

    from talaia.cli.importing.decoding import Definition
    from talaia.gateway.adapters.topic_readers import TopicPlan
    from talaia.model.site import Site

__all__ = ["MessageFile", "Messages"]

# Whose signals are fields of messages.
_ROS = (Ros2Connection, Ros1Connection, RosbridgeConnection)

# Messages between two pieces.
_AT_ONCE = 4096


class MessageFile(Protocol):
    """A file of messages that is open. What it raises is whatever its library raises.

    Attributes:
        topics: by number: the topic's name, and how its messages are written.
        count: messages of all topics; 0 if the file does not say.

    """

    @property
    def topics(self) -> Mapping[int, tuple[str, Definition]]:
        """See above."""
        ...

    @property
    def count(self) -> int:
        """See above."""
        ...

    def iterate_messages(self, wanted: Collection[int]) -> Iterator[tuple[int, int, bytes]]:
        """Give the messages of some topics in order of time: number, time (ns), bytes."""
        ...

    def reading_place(self) -> str:
        """Tell where in the file the reader stands, if that is known."""
        ...

    def close(self) -> None:
        """Let go of the file."""
        ...


class Messages:
    """A `Source` of a file of messages."""

    def __init__(self, path: Path, kind: str, site: Site) -> None:
        """Open a file and match its topics with the description.

        Raises:
            BadFile: it cannot be opened.

        """
        self.kind = kind
        # What the description lacks or the file lacks; complete only when `read_pieces` has ended.
        self.findings = Findings()
        self._path = path
        try:
            self._file: MessageFile = McapFile(path) if kind == "MCAP" else Bag(path, kind)
        except Exception as error:
            raise self._file_error(error, "") from error
        # Addresses that cannot be read, with the reason.
        self._unreadable: dict[str, str] = {}
        # Connections of the file that are read: what is taken from each, and its decoder.
        self._read: dict[int, tuple[TopicPlan, Callable[[bytes], object]]] = {}
        self._match_channels(site)

    def read_pieces(self) -> Iterator[Piece]:
        """See `Source.pieces`."""
        gathered = SampleBuffer()
        # Messages read, those since the last piece, and the newest time until now (µs).
        read, waiting, past_us = 0, 0, -(2**63)
        # Unknown, the share stays at zero, which is better than one that runs past its end.
        total = self._file.count or math.inf
        messages = self._file.iterate_messages(list(self._read)) if self._read else iter(())
        while True:
            try:
                found = next(messages, None)
            except Exception as error:
                place = self._file.reading_place() or f"after message {read}"
                raise self._file_error(error, place) from error
            if found is None:
                break
            number, time_ns, data = found
            plan, decode = self._read[number]
            read += 1
            try:
                message = decode(data)
            except Exception as error:
                topic = self._file.topics[number][0]
                raise self._file_error(
                    error, f"message {read} of the topics read, on {topic}"
                ) from error
            time_us = time_ns // 1000
            past_us = max(past_us, time_us)
            # Before the message: values that thinning held back come out at their own turn, in
            # order.
            plan.take_past(time_us, gathered)
            # No monotonic time: it serves interlocks, and nothing is driven by a recording.
            plan.read_message(message, time_us, 0, gathered)
            waiting += 1
            if waiting == _AT_ONCE:
                waiting = 0
                columns = gathered.take_columns()
                if columns is not None:
                    yield Piece(min(1.0, read / total), columns)
        for plan, _ in self._read.values():
            # The end of the file is the end of time: nothing may stay held back.
            plan.take_past(2**62, gathered)
        columns = gathered.take_columns()
        if columns is not None:
            yield Piece(1.0, columns)
        for address, problem in self._unreadable.items():
            self.findings.notes.append(f"{address}: {problem}")

    def close(self) -> None:
        """See `Source.close`."""
        self._file.close()

    def _match_channels(self, site: Site) -> None:
        def complain(address: str, problem: str) -> None:
            self._unreadable.setdefault(address, problem)

        # The gateway's own plans: a recording is thinned and scaled as the live robot is.
        plans = [
            plan
            for share in scopes_of(site)
            if isinstance(share.connection, _ROS)
            for plan in plans_of(share, {}, complain)
        ]
        # Addresses by topic and type, to say what is missing when a topic cannot be read.
        reads: dict[str, list[str]] = {}
        for device_id, device in site.devices.items():
            for signal_id, signal in device.signals.items():
                source = source_as(signal.source, RosSource)
                key = f"{source.topic} {source.type}"
                parts = [f".{part}" if part else "" for part in parts_of(signal)]
                reads.setdefault(key, []).extend(f"{device_id}/{signal_id}{p}" for p in parts)
        matched: set[int] = set()
        for plan in plans:
            here = [
                (number, definition)
                for number, (topic, definition) in self._file.topics.items()
                # A topic may be recorded without its first slash.
                if "/" + topic.lstrip("/") == plan.topic
            ]
            why = "" if here else f"the file has no topic {plan.topic}"
            for number, definition in here:
                matched.add(number)
                # Same name and another type: bytes would be read as something that they are not.
                if definition.type_name not in ("", ros_type(plan.type_name)):
                    why = f"{plan.topic} is {definition.type_name} in the file"
                    why += f", and {plan.type_name} in the description"
                    continue
                try:
                    self._read[number] = (plan, decoder_of(definition))
                except Undecodable as error:
                    why = f"{plan.topic}: {error}"
            # Another connection of the topic could be read: nothing is missing.
            if why and not any(number in self._read for number, _ in here):
                for address in reads[f"{plan.topic} {plan.type_name}"]:
                    self.findings.absent[address] = why
        for number, (topic, definition) in self._file.topics.items():
            if number not in matched:
                self.findings.unread[topic] = definition.type_name

    def _file_error(self, error: Exception, place: str) -> BadFile:
        said = str(error) or type(error).__name__
        remedy = ""
        # By its words: the library raises one class for many reasons.
        if self.kind == "rosbag 1" and "index" in said.lower():
            remedy = "`rosbag reindex` makes the index that a bag lacks which was cut off"
        elif self.kind == "MCAP":
            remedy = "if it was cut off, `mcap recover` saves what is there"
        return BadFile(str(self._path), place, f"it cannot be read as {self.kind}: {said}", remedy)
