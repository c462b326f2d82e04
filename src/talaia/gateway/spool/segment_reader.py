"""Reads segments of the spool, and tells of what is damaged in them as gaps."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from talaia.gateway.spool.opening import DAMAGED
from talaia.gateway.spool.packing import unpack_record
from talaia.gateway.spool.segment import RecordKind, SampleRecord, read_records
from talaia.wire.errors import PeerError
from talaia.wire.frames import SampleGap

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.spool.files import Segment, SegmentHead
    from talaia.gateway.spool.gaps import SpoolGaps

__all__ = ["SegmentReader", "SpoolPosition", "StoredRecord", "gap_in", "gap_of"]


class StoredRecord(NamedTuple):
    """A record with what its segment says of it."""

    head: SegmentHead
    record: SampleRecord


class SpoolPosition(NamedTuple):
    """Where a reader stands; by default at the oldest.

    ``end`` is one past the last sample that it was given.
    """

    number: int = 0  # Of the segment.
    turn: int = 0  # Of the segment, when it was read; see `Segment.turn`.
    offset: int = 0  # Bytes from the file's begin.
    end: int = -1


class SegmentReader:
    """Gives what the hub has not acknowledged yet."""

    def __init__(self, acked: Mapping[str, int], gaps: SpoolGaps) -> None:
        """Read nothing yet.

        Args:
            acked: by boot: below which sample all is stored for good; kept up to date by others.
            gaps: take what is lost.

        """
        self._acked = acked  # Shared with `Spool`, which writes to it.
        self._gaps = gaps

    def read_segment(
        self, segment: Segment, place: SpoolPosition, most: int
    ) -> tuple[list[StoredRecord], SpoolPosition]:
        """Give records of a segment from a place on, and the place behind them.

        Raises:
            OSError: the disk does not give it back.

        """
        found: list[StoredRecord] = []
        offset, expected = place.offset, place.end
        # Opened for each call: a segment may be packed or removed between two.
        file = os.open(segment.path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            # `size` and not the file's own length: behind it may be half of a record that the disk
            # did not take.
            while not found and offset < segment.size:
                # Room for the longest batch, so that one that is cut off is read whole next time.
                data = os.pread(file, min(most * 2, segment.size - offset), offset)
                end = 0
                for end, record in read_records(data):
                    if record.kind == RecordKind.SEGMENT:
                        continue
                    # In order: a number that is skipped was written and is gone now.
                    self._see_hole(segment, expected, record)
                    expected = record.end
                    found += self._stored_records(segment, record)
                    # Bytes of the file, not of what was found: the caller paces its reading of the
                    # disk.
                    if end >= most:
                        break
                # Nothing whole in this piece: the record is longer, or damaged; read once more to
                # the end.
                if end == 0:
                    most = segment.size - offset if len(data) < segment.size - offset else 0
                    if most == 0:
                        # Nothing whole up to the end: what should be there has been damaged.
                        self._see_hole(segment, expected, None)
                        offset = segment.size
                        break
                # Only past whole records, so that the next call begins at one.
                offset += end
        finally:
            os.close(file)
        return found, SpoolPosition(segment.number, segment.turn, offset, expected)

    def _stored_records(self, segment: Segment, record: SampleRecord) -> list[StoredRecord]:
        acked = self._acked.get(segment.head.boot, 0)
        # Before it is unpacked: what the hub has is not worth the time.
        if record.end <= acked:
            return []
        try:
            return [
                StoredRecord(segment.head, record)
                for record in unpack_record(record)
                if record.end > acked
            ]
        # Told as a gap and passed over: it would be as unreadable the next time.
        except PeerError as error:
            self._gaps.add_gap(
                SampleGap(
                    boot=segment.head.boot,
                    first=record.first,
                    last=record.end - 1,
                    from_us=record.from_us,
                    to_us=record.to_us,
                    reason=str(error),
                )
            )
            return []

    def _see_hole(self, segment: Segment, expected: int, record: SampleRecord | None) -> None:
        """Tell of records that were whole when they were written and are not there now."""
        # At the begin of a segment its own range says what should come first.
        first = max(segment.first if expected < 0 else expected, 0)
        past = segment.end if record is None else record.first
        # What is damaged and acknowledged is at the hub: no gap.
        first = max(first, self._acked.get(segment.head.boot, 0))
        if first < past:
            lost = gap_in(segment, first, DAMAGED)
            to_us = segment.to_us if record is None else record.from_us
            self._gaps.add_unknown(replace(lost, last=past - 1, to_us=to_us))


def gap_in(segment: Segment, first: int, reason: str) -> SampleGap:
    """Say that a segment is gone from a sample on."""
    return SampleGap(
        boot=segment.head.boot,
        first=first,
        last=segment.end - 1,
        from_us=segment.from_us,
        to_us=segment.to_us,
        reason=reason,
    )


def gap_of(record: SampleRecord, boot: str, reason: str) -> SampleGap:
    """Give the gap that a whole record of ``boot`` becomes."""
    return SampleGap(
        boot=boot,
        first=record.first,
        last=record.end - 1,
        from_us=record.from_us,
        to_us=record.to_us,
        reason=reason,
    )
