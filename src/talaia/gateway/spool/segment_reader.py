"""Reads segments of the spool, and tells of what is damaged in them as gaps."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from talaia.gateway.spool.opening import DAMAGED
from talaia.gateway.spool.packing import unpacked
from talaia.gateway.spool.segment import RecordKind, SampleRecord, records
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

    number: int = 0
    turn: int = 0
    offset: int = 0
    end: int = -1


class SegmentReader:
    """Gives what the hub has not acknowledged yet."""

    def __init__(self, acked: Mapping[str, int], gaps: SpoolGaps) -> None:
        """Read nothing yet.

        Args:
            acked: by boot: below which sample all is stored for good; kept up to date by others.
            gaps: take what is lost.

        """
        self._acked = acked
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
        file = os.open(segment.path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            while not found and offset < segment.size:
                # Room for the longest batch, so that one that is cut off is read whole next time.
                data = os.pread(file, min(most * 2, segment.size - offset), offset)
                end = 0
                for end, record in records(data):
                    if record.kind == RecordKind.SEGMENT:
                        continue
                    self._see_hole(segment, expected, record)
                    expected = record.end
                    found += self._batches(segment, record)
                    if end >= most:
                        break
                if end == 0:
                    most = segment.size - offset if len(data) < segment.size - offset else 0
                    if most == 0:
                        # Nothing whole up to the end: what should be there has been damaged.
                        self._see_hole(segment, expected, None)
                        offset = segment.size
                        break
                offset += end
        finally:
            os.close(file)
        return found, SpoolPosition(segment.number, segment.turn, offset, expected)

    def _batches(self, segment: Segment, record: SampleRecord) -> list[StoredRecord]:
        acked = self._acked.get(segment.head.boot, 0)
        if record.end <= acked:
            return []
        try:
            return [
                StoredRecord(segment.head, record)
                for record in unpacked(record)
                if record.end > acked
            ]
        except PeerError as error:
            self._gaps.add(
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
        first = max(segment.first if expected < 0 else expected, 0)
        past = segment.end if record is None else record.first
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
