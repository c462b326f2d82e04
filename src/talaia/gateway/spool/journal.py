"""What the hub has not stored yet: segments on disk, bounded in bytes, trimmed by acks.

Guarantees: records come back in the order they went in; a record is gone only when it was
acknowledged or when a recorded gap tells of it; after a crash at any point what was written
before is there, less what the last seconds' power cut took. All calls block on the disk and
come from one thread.

Forcing every batch to disk (50 a second) would cost more than all the rest of the gateway and
wear out the SD cards robots run on. What the process has written survives its own death without
that; only a power cut needs it. So `sync` is called once a second, and does nothing while the
hub keeps up: then there is nothing here that is not stored elsewhere.
"""

from __future__ import annotations

import logging
import os
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.gateway.errors import SpoolError
from talaia.gateway.spool.files import Head, Segment, scan, write_all
from talaia.gateway.spool.gaps import Gaps
from talaia.gateway.spool.segment import Kind, Record, pack_record, records

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.wire.frames import Gap

__all__ = ["Head", "Place", "Spool", "Stored"]

log = logging.getLogger(__name__)
SEGMENT_BYTES = 4 * 1024 * 1024
TRIM_BYTES = 512 * 1024
MEMORY_BYTES = 4 * 1024 * 1024
FULL = "the gateway's disk space for unsent samples was full"


class Stored(NamedTuple):
    """A record with what its segment says of it."""

    head: Head
    record: Record


class Place(NamedTuple):
    """Where a reader stands; `Place()` is the oldest."""

    number: int = 0
    turn: int = 0
    offset: int = 0


class Spool:
    """See the module."""

    def __init__(self, folder: Path, head: Head, bound: int) -> None:
        """Take up what an earlier run left and begin a segment of this boot.

        Raises:
            SpoolError: the folder cannot be used.

        """
        self._folder = folder
        self._head = head
        self._bound = bound
        self._acked: dict[str, int] = {}
        self._synced_end = 0
        self._dirty = False
        self._memory: deque[Record] = deque()
        self._memory_bytes = 0
        self._segments: list[Segment] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._gaps = Gaps(folder / "gaps.json")
            self._load()
            self._next_number = 1 + max((each.number for each in self._segments), default=0)
            self._current = self._begin()
        except OSError as error:
            raise SpoolError(f"the data folder {folder} cannot be used: {error}") from error

    # ── opening ──

    def _load(self) -> None:
        ends: dict[str, tuple[int, int]] = {}
        for path in sorted(self._folder.glob("*.seg")):
            data = path.read_bytes()
            found = scan(path, data)
            if found is None:
                log.warning("%s holds no whole record; removed", path)
                path.unlink()
                continue
            segment, holes, whole = found
            if whole < len(data):
                os.truncate(path, whole)
            for first, last, from_us, to_us in holes:
                self._gaps.add(segment.head.boot, first, last, from_us, to_us, "damaged on disk")
            if segment.first < 0:
                path.unlink()
                continue
            # Segments of one boot follow each other; the oldest may be gone, none between.
            end, end_us = ends.get(segment.head.boot, (segment.first, 0))
            if segment.first > end:
                lost = (end, segment.first - 1, end_us, segment.from_us)
                self._gaps.add(segment.head.boot, *lost, "damaged on disk")
            ends[segment.head.boot] = (segment.end, segment.to_us)
            self._segments.append(segment)

    def _begin(self) -> Segment:
        number = self._next_number
        path = self._folder / f"{number:010d}.seg"
        head = pack_record(Record(0, 0, 0, 0, msgspec.msgpack.encode(self._head), Kind.SEGMENT))
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
        try:
            write_all(self._file, head)
        except OSError:
            os.close(self._file)
            path.unlink(missing_ok=True)
            raise
        self._next_number += 1
        segment = Segment(number, path, self._head, len(head), len(head))
        self._segments.append(segment)
        return segment

    # ── writing ──

    @property
    def kept(self) -> int:
        """How much is kept, on disk and (while the disk is full) in memory."""
        return sum(segment.size for segment in self._segments) + self._memory_bytes

    def append(self, record: Record) -> None:
        """Keep a record of this boot. Never raises for a full disk: the oldest gives way."""
        self._trim()
        data = pack_record(record)
        while self.kept + len(data) > self._bound and self._drop_oldest():
            pass
        while not self._write(data, record):
            if not self._drop_oldest():
                self._keep_in_memory(record)
                return

    def _write(self, data: bytes, record: Record) -> bool:
        segment = self._current
        # Quarter of the bound: dropping the oldest must not mean dropping nearly all.
        largest = min(SEGMENT_BYTES, max(self._bound // 4, len(data)))
        try:
            if segment.first >= 0 and segment.size + len(data) > largest:
                old = self._file
                segment = self._current = self._begin()
                os.close(old)
            write_all(self._file, data)
        except OSError as error:
            log.debug("spool: %s", error)
            os.ftruncate(self._file, segment.size)
            os.lseek(self._file, segment.size, os.SEEK_SET)
            return False
        segment.size += len(data)
        segment.add(record)
        self._dirty = True
        return True

    def _keep_in_memory(self, record: Record) -> None:
        self._memory.append(record)
        self._memory_bytes += len(record.body)
        while self._memory_bytes > MEMORY_BYTES:
            lost = self._memory.popleft()
            self._memory_bytes -= len(lost.body)
            self._gaps.add(
                self._head.boot, lost.first, lost.end - 1, lost.from_us, lost.to_us, FULL
            )

    def _drop_oldest(self) -> bool:
        """Let the oldest segment give way; tell whether there was one besides the current."""
        if len(self._segments) < 2:
            return False
        oldest = self._segments[0]
        first = max(oldest.first, self._acked.get(oldest.head.boot, 0))
        if first < oldest.end:
            # The gap is on record before the file goes: a crash between leaves both, not neither.
            self._gaps.add(
                oldest.head.boot, first, oldest.end - 1, oldest.from_us, oldest.to_us, FULL
            )
            self._gaps.write()
        self._remove(oldest)
        return True

    def _remove(self, segment: Segment) -> None:
        self._segments.remove(segment)
        segment.path.unlink(missing_ok=True)

    def lose(self, record: Record, reason: str, boot: str = "") -> None:
        """Record that a batch is gone; of this boot when none is named."""
        self._gaps.add(
            boot or self._head.boot,
            record.first,
            record.end - 1,
            record.from_us,
            record.to_us,
            reason,
        )

    def gaps(self) -> list[Gap]:
        """Give the gaps that the hub has not acknowledged past."""
        return self._gaps.all()

    # ── acknowledging ──

    def ack(self, boot: str, below: int) -> None:
        """Note that every sample of ``boot`` below ``below`` is stored for good."""
        if below > self._acked.get(boot, 0):
            self._acked[boot] = below

    def _trim(self) -> None:
        for segment in [
            each
            for each in self._segments
            if each.end <= self._acked.get(each.head.boot, 0) and each is not self._current
        ]:
            self._remove(segment)
        current, acked = self._current, self._acked.get(self._head.boot, 0)
        if current.end <= acked and current.size > TRIM_BYTES:
            # Emptied in place: with a hub that keeps up, the pages never reach the disk at all.
            os.ftruncate(self._file, current.start)
            os.lseek(self._file, current.start, os.SEEK_SET)
            current.size, current.first = current.start, -1
            current.turn += 1
        while self._memory and self._memory[0].end <= acked:
            self._memory_bytes -= len(self._memory.popleft().body)
        self._gaps.forget(self._acked)

    def sync(self) -> None:
        """Force to disk what a power cut would take, unless the hub has it all."""
        self._trim()
        self._gaps.write()
        settled = self._acked.get(self._head.boot, 0) >= self._synced_end
        self._synced_end = self._current.end
        if not self._dirty or settled:
            return
        self._dirty = False
        try:
            os.fdatasync(self._file)
        except OSError as error:
            log.warning("the spool cannot be forced to disk: %s", error)

    # ── reading ──

    def read(self, place: Place, most: int) -> tuple[list[Stored], Place]:
        """Give the next records not yet acknowledged, about ``most`` bytes; none at the end."""
        self._trim()
        for segment in self._segments:
            if segment.number < place.number:
                continue
            same = segment.number == place.number and segment.turn == place.turn
            offset = place.offset if same else segment.start
            found, offset = self._read_segment(segment, offset, most)
            place = Place(segment.number, segment.turn, offset)
            if found:
                return found, place
        last = self._segments[-1].number + 1
        if self._memory and place.number < last:
            return [Stored(self._head, each) for each in self._memory], Place(last, 0, 0)
        return [], place

    def _read_segment(self, segment: Segment, offset: int, most: int) -> tuple[list[Stored], int]:
        found: list[Stored] = []
        acked = self._acked.get(segment.head.boot, 0)
        file = os.open(segment.path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            while not found and offset < segment.size:
                # Room for the longest batch, so that one that is cut off is read whole next time.
                data = os.pread(file, min(most * 2, segment.size - offset), offset)
                end = 0
                for end, record in records(data):
                    if record.kind == Kind.SAMPLES and record.end > acked:
                        found.append(Stored(segment.head, record))
                    if end >= most:
                        break
                if end == 0:
                    most = segment.size - offset if len(data) < segment.size - offset else 0
                    if most == 0:
                        return found, segment.size
                offset += end
        finally:
            os.close(file)
        return found, offset

    def close(self) -> None:
        """Force to disk and close; an empty current segment is removed."""
        self._trim()
        self._gaps.write()
        try:
            os.fdatasync(self._file)
        finally:
            os.close(self._file)
        if self._current.first < 0:
            self._current.path.unlink(missing_ok=True)
