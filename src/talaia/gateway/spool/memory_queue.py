"""Records that the disk does not take now, in memory."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.gateway.spool.segment import SampleRecord

__all__ = ["MemoryQueue"]


class MemoryQueue:
    """In the order they came in, and never more bytes than it is told.

    What is here is newer than all that is on disk: as long as something waits here, nothing may
    be written past it.
    """

    def __init__(self) -> None:
        """Begin with none."""
        self._records: deque[SampleRecord] = deque()  # Oldest first.
        # Of their bodies; kept up to date with every record, as it is asked for with each batch.
        self.bytes = 0

    def __len__(self) -> int:
        """Count the records."""
        return len(self._records)

    def __iter__(self) -> Iterator[SampleRecord]:
        """Give the records, the oldest first."""
        return iter(self._records)

    def add_record(self, record: SampleRecord, most: int) -> list[SampleRecord]:
        """Keep a record behind the others; give the oldest, which no longer fit in ``most`` bytes.

        A record that is larger than that is given back as well.
        """
        self._records.append(record)
        self.bytes += len(record.body)
        dropped = []
        # The record that was just added goes as well when it alone is too large.
        while self.bytes > most:
            dropped.append(self.pop_oldest())
        return dropped

    @property
    def oldest(self) -> SampleRecord:
        """The record that came first; there must be one."""
        return self._records[0]

    def pop_oldest(self) -> SampleRecord:
        """Give the oldest, which goes from here; there must be one."""
        record = self._records.popleft()
        self.bytes -= len(record.body)
        return record

    def pop_below(self, end: int) -> list[SampleRecord]:
        """Give the records that end at sample ``end`` or before; they go from here."""
        stored = []
        # From the front only: records are in rising order, so the first newer one ends it.
        while self._records and self._records[0].end <= end:
            stored.append(self.pop_oldest())
        return stored

    def name_channels(self, addresses: list[str]) -> None:
        """Let each record say itself what its channels are: the list they share is another soon."""
        self._records = deque(_with_addresses(record, addresses) for record in self._records)
        # Names make them larger: counted anew, for the bound is on what is really there.
        self.bytes = sum(len(record.body) for record in self._records)


def _with_addresses(record: SampleRecord, addresses: list[str]) -> SampleRecord:
    """Give a batch that says itself what its channels are."""
    frame = LINK_FROM_GATEWAY.decode(record.body)
    # One that names its channels already was put here under an earlier list.
    if not isinstance(frame, SampleBatch) or frame.addresses:
        return record
    whole = replace(frame, addresses=addresses)
    return record._replace(body=LINK_FROM_GATEWAY.encode(whole))
