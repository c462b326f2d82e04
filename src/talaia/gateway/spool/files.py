"""Segment files: what is known of one, how one from an earlier run is read back or set aside."""

from __future__ import annotations

import logging
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.spool.packing import unpack_record
from talaia.gateway.spool.segment import RecordKind, SampleRecord, read_records
from talaia.wire.errors import PeerError
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch

if TYPE_CHECKING:
    from pathlib import Path

__all__ = [
    "Segment",
    "SegmentHead",
    "boot_of",
    "ranges_of",
    "remove_file",
    "scan_segment",
    "set_aside",
    "write_all",
]

log = logging.getLogger(__name__)
# What cannot be read is kept for whoever wants to look, but not for ever.
ASIDE = ".bad"
MOST_ASIDE = 4


class SegmentHead(msgspec.Struct, frozen=True):
    """What all records of a segment share.

    ``ran_s`` is for how long this spool had been running when the segment began, over all its
    runs: by it a segment's age is told, and a wall clock that jumps makes nothing old.
    """

    boot: str  # Names the run that wrote it.
    catalogue: str  # Name of the channel list; the hub knows a list by it.
    addresses: list[str]  # The channel list itself: a later run sends samples by it.
    ran_s: float = 0.0


@dataclass(slots=True)
class Segment:
    """A file and the range it holds. ``turn`` counts how often it was emptied and used again."""

    number: int  # Of the file's name; rises, and orders segments over all runs.
    path: Path
    head: SegmentHead
    size: int  # Bytes of whole records; a reader never goes beyond.
    start: int  # Where records begin: behind the head.
    first: int = -1  # Sequence number of the oldest sample; -1: there is none.
    end: int = 0  # One past the newest.
    from_us: int = 0  # Earliest and latest time in it (wall, µs).
    to_us: int = 0
    turn: int = 0

    def count_record(self, record: SampleRecord) -> None:
        """Count a record in."""
        if self.first < 0:
            self.first, self.from_us, self.to_us = record.first, record.from_us, record.to_us
        self.end = max(self.end, record.end)
        # By `min` and `max`: the wall clock may have been set back between two records.
        self.from_us = min(self.from_us, record.from_us)
        self.to_us = max(self.to_us, record.to_us)


def scan_segment(
    path: Path, data: bytes
) -> tuple[Segment, list[tuple[int, int, int, int]], int] | None:
    """Read a segment from an earlier run: its range, its holes, and where whole data end."""
    segment: Segment | None = None
    holes: list[tuple[int, int, int, int]] = []
    whole = 0
    # Another file that ends in `.seg`: not ours, so it is set aside and not guessed at.
    try:
        number = int(path.stem)
    except ValueError:
        return None
    for end, record in read_records(data):
        if record.kind == RecordKind.SEGMENT:
            try:
                head = msgspec.msgpack.decode(record.body, type=SegmentHead)
            except msgspec.DecodeError:
                return None
            segment = Segment(number, path, head, end, end)
        elif segment is not None:
            # Sequence numbers go on without a break in a segment, so a jump is damage.
            if segment.first >= 0 and record.first > segment.end:
                holes.append((segment.end, record.first - 1, segment.to_us, record.from_us))
            segment.count_record(record)
        # Also after a hole: what is whole behind it is kept.
        whole = end
    if segment is None:
        return None
    segment.size = whole
    return segment, holes, whole


def ranges_of(data: bytes) -> list[SampleRecord]:
    """Give the records of samples in a segment whose head is gone."""
    return [record for _, record in read_records(data) if record.kind != RecordKind.SEGMENT]


def boot_of(record: SampleRecord) -> str:
    """Tell whose samples a record holds, from the record itself; empty when it does not say."""
    # The first frame will do: all frames of a record are of one boot.
    try:
        batches = unpack_record(record)
        frame = LINK_FROM_GATEWAY.decode(batches[0].body)
    except PeerError:
        return ""
    return frame.boot if isinstance(frame, SampleBatch) else ""


def set_aside(path: Path) -> None:
    """Keep a file that cannot be used under another name; of more than a few the oldest go.

    Raises:
        OSError: it cannot even be renamed.

    """
    # Renamed, not copied: that works on a full disk, too.
    path.replace(path.with_suffix(ASIDE))
    # Names are of one width, so the first are the oldest.
    for old in sorted(path.parent.glob(f"*{ASIDE}"))[:-MOST_ASIDE]:
        old.unlink(missing_ok=True)


def remove_file(path: Path) -> bool:
    """Remove a file if it is there; tell whether the disk let go of it."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        log.debug("%s cannot be removed: %s", path, error)
        return False
    return True


def write_all(file: int, data: bytes) -> None:
    """Write all of it, however often the system takes only a part."""
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]
