"""One file of the spool: records one after another, each with its own checksum.

A record is a fixed head (magic, kind, length, checksum, sequence range, time span) and a body.
A crash leaves at most a torn tail, which is cut off; damage in the middle costs the records it
touches and no others, since reading finds the next magic.
"""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["HEAD", "RecordKind", "SampleRecord", "pack_record", "read_records"]

# Not valid UTF-8, so no text in a body looks like it; bytes that do fail by the checksum.
MAGIC = b"\xf7TLR"
# magic, kind, body length, CRC-32 of all that follows it, first, count, from_us, to_us
_HEAD = struct.Struct("<4sBIIQIqq")
_CHECKED = struct.Struct("<QIqq")
HEAD = _HEAD.size
# More than any record has: a damaged length is found without reading that far.
_MAX_BODY = 16 * 1024 * 1024


class RecordKind:
    """What a record holds: the segment's own head, a batch of samples, or several, deflated."""

    # Written to disk: a number keeps its meaning for ever.
    SEGMENT = 0
    SAMPLES = 1
    PACKED = 2


class SampleRecord(NamedTuple):
    """A batch as it is kept.

    Attributes:
        first: sequence number of the first sample.
        samples: how many.
        from_us: earliest time (wall).
        to_us: latest time.
        body: the encoded frame.
        kind: see `RecordKind`.

    """

    first: int
    samples: int
    from_us: int
    to_us: int
    body: bytes
    kind: int = RecordKind.SAMPLES

    @property
    def end(self) -> int:
        """One past the last sequence number."""
        return self.first + self.samples


def pack_record(record: SampleRecord) -> bytes:
    """Give a record's bytes."""
    checked = _CHECKED.pack(record.first, record.samples, record.from_us, record.to_us)
    # The kind is the checksum's start value: so it is covered without another copy.
    crc = zlib.crc32(record.body, zlib.crc32(checked, record.kind))
    head = _HEAD.pack(
        MAGIC,
        record.kind,
        len(record.body),
        crc,
        record.first,
        record.samples,
        record.from_us,
        record.to_us,
    )
    return head + record.body


def read_records(data: bytes, at: int = 0) -> Iterator[tuple[int, SampleRecord]]:
    """Give the whole records of ``data`` from ``at`` on, each with the offset where it ends."""
    while True:
        # Damage is skipped up to the next magic, wherever that is.
        at = data.find(MAGIC, at)
        if at < 0:
            return
        record = _read_record(data, at)
        if record is None:
            # By one byte, not by the head: a magic within a damaged record may be a true one.
            at += 1
            continue
        at += HEAD + len(record.body)
        yield at, record


def _read_record(data: bytes, at: int) -> SampleRecord | None:
    # A torn head at the end of the file.
    if len(data) - at < HEAD:
        return None
    _, kind, length, crc, first, count, from_us, to_us = _HEAD.unpack_from(data, at)
    # A torn body, or a damaged length; either way it is no whole record.
    if length > _MAX_BODY or len(data) - at - HEAD < length:
        return None
    body = data[at + HEAD : at + HEAD + length]
    # Over the decoded numbers and the body; a wrong length gives another body and so fails, too.
    checked = _CHECKED.pack(first, count, from_us, to_us)
    if zlib.crc32(body, zlib.crc32(checked, kind)) != crc:
        return None
    return SampleRecord(first, count, from_us, to_us, body, kind)
