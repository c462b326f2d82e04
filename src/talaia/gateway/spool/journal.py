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
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.gateway.errors import SpoolError
from talaia.gateway.keep import write_whole
from talaia.gateway.spool.segment import Kind, Record, pack_record, records
from talaia.wire.frames import Gap

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Head", "Place", "Spool", "Stored"]

log = logging.getLogger(__name__)
SEGMENT_BYTES = 4 * 1024 * 1024
TRIM_BYTES = 512 * 1024
MEMORY_BYTES = 4 * 1024 * 1024
FULL = "the gateway's disk space for unsent samples was full"


class Head(msgspec.Struct, frozen=True):
    """What all records of a segment share."""

    boot: str
    catalogue: str
    addresses: list[str]


class Stored(NamedTuple):
    """A record with what its segment says of it."""

    head: Head
    record: Record


class Place(NamedTuple):
    """Where a reader stands; `Place()` is the oldest."""

    number: int = 0
    turn: int = 0
    offset: int = 0


@dataclass(slots=True)
class _Segment:
    """A file and the range it holds. ``turn`` counts how often it was emptied and used again."""

    number: int
    path: Path
    head: Head
    size: int
    start: int
    first: int = -1
    end: int = 0
    from_us: int = 0
    to_us: int = 0
    turn: int = 0

    def add(self, record: Record) -> None:
        if self.first < 0:
            self.first, self.from_us, self.to_us = record.first, record.from_us, record.to_us
        self.end = max(self.end, record.end)
        self.from_us = min(self.from_us, record.from_us)
        self.to_us = max(self.to_us, record.to_us)


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
        self._gaps: list[Gap] = []
        self._gaps_dirty = False
        self._memory: deque[Record] = deque()
        self._memory_bytes = 0
        self._segments: list[_Segment] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._load_gaps()
            self._load()
            self._next_number = 1 + max((each.number for each in self._segments), default=0)
            self._current = self._begin()
        except OSError as error:
            raise SpoolError(f"the data folder {folder} cannot be used: {error}") from error

    # ── opening ──

    def _load_gaps(self) -> None:
        path = self._folder / "gaps.json"
        try:
            self._gaps = msgspec.json.decode(path.read_bytes(), type=list[Gap])
        except FileNotFoundError:
            return
        except msgspec.DecodeError as error:
            log.warning("%s is damaged and is left aside: %s", path, error)

    def _load(self) -> None:
        ends: dict[str, tuple[int, int]] = {}
        for path in sorted(self._folder.glob("*.seg")):
            data = path.read_bytes()
            found = _scan(path, data)
            if found is None:
                log.warning("%s holds no whole record; removed", path)
                path.unlink()
                continue
            segment, holes, whole = found
            if whole < len(data):
                os.truncate(path, whole)
            for first, last, from_us, to_us in holes:
                self._lose(segment.head.boot, first, last, from_us, to_us, "damaged on disk")
            if segment.first < 0:
                path.unlink()
                continue
            # Segments of one boot follow each other; the oldest may be gone, none between.
            end, end_us = ends.get(segment.head.boot, (segment.first, 0))
            if segment.first > end:
                lost = (end, segment.first - 1, end_us, segment.from_us)
                self._lose(segment.head.boot, *lost, "damaged on disk")
            ends[segment.head.boot] = (segment.end, segment.to_us)
            self._segments.append(segment)

    def _begin(self) -> _Segment:
        number = self._next_number
        path = self._folder / f"{number:010d}.seg"
        head = pack_record(Record(0, 0, 0, 0, msgspec.msgpack.encode(self._head), Kind.SEGMENT))
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
        try:
            _write_all(self._file, head)
        except OSError:
            os.close(self._file)
            path.unlink(missing_ok=True)
            raise
        self._next_number += 1
        segment = _Segment(number, path, self._head, len(head), len(head))
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
            _write_all(self._file, data)
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
            self._lose(self._head.boot, lost.first, lost.end - 1, lost.from_us, lost.to_us, FULL)

    def _drop_oldest(self) -> bool:
        """Let the oldest segment give way; tell whether there was one besides the current."""
        if len(self._segments) < 2:
            return False
        oldest = self._segments[0]
        first = max(oldest.first, self._acked.get(oldest.head.boot, 0))
        if first < oldest.end:
            # The gap is on record before the file goes: a crash between leaves both, not neither.
            self._lose(oldest.head.boot, first, oldest.end - 1, oldest.from_us, oldest.to_us, FULL)
            self._write_gaps()
        self._remove(oldest)
        return True

    def _remove(self, segment: _Segment) -> None:
        self._segments.remove(segment)
        segment.path.unlink(missing_ok=True)

    # ── gaps ──

    def lose(self, record: Record, reason: str) -> None:
        """Record that a batch of this boot is gone."""
        self._lose(
            self._head.boot, record.first, record.end - 1, record.from_us, record.to_us, reason
        )

    def _lose(
        self, boot: str, first: int, last: int, from_us: int, to_us: int, reason: str
    ) -> None:
        log.warning("samples %d to %d of %s are lost: %s", first, last, boot, reason)
        self._gaps_dirty = True
        for index, gap in enumerate(self._gaps):
            if gap.boot == boot and gap.last + 1 == first and gap.reason == reason:
                first, from_us = gap.first, min(gap.from_us, from_us)
                del self._gaps[index]
                break
        self._gaps.append(
            Gap(boot=boot, first=first, last=last, from_us=from_us, to_us=to_us, reason=reason)
        )

    def gaps(self) -> list[Gap]:
        """Give the gaps that the hub has not acknowledged past."""
        return list(self._gaps)

    def _write_gaps(self) -> None:
        try:
            write_whole(self._folder / "gaps.json", msgspec.json.encode(self._gaps))
            self._gaps_dirty = False
        except OSError as error:
            log.debug("gaps.json: %s", error)

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
        kept = [gap for gap in self._gaps if gap.last >= self._acked.get(gap.boot, 0)]
        if len(kept) != len(self._gaps):
            self._gaps, self._gaps_dirty = kept, True

    def sync(self) -> None:
        """Force to disk what a power cut would take, unless the hub has it all."""
        self._trim()
        if self._gaps_dirty:
            self._write_gaps()
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

    def _read_segment(self, segment: _Segment, offset: int, most: int) -> tuple[list[Stored], int]:
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
        self._write_gaps()
        try:
            os.fdatasync(self._file)
        finally:
            os.close(self._file)
        if self._current.first < 0:
            self._current.path.unlink(missing_ok=True)


def _scan(path: Path, data: bytes) -> tuple[_Segment, list[tuple[int, int, int, int]], int] | None:
    """Read a segment from an earlier run: its range, its holes, and where whole data end."""
    segment: _Segment | None = None
    holes: list[tuple[int, int, int, int]] = []
    whole = 0
    try:
        number = int(path.stem)
    except ValueError:
        return None
    for end, record in records(data):
        if record.kind == Kind.SEGMENT:
            try:
                head = msgspec.msgpack.decode(record.body, type=Head)
            except msgspec.DecodeError:
                return None
            segment = _Segment(number, path, head, end, end)
        elif segment is not None:
            if segment.first >= 0 and record.first > segment.end:
                holes.append((segment.end, record.first - 1, segment.to_us, record.from_us))
            segment.add(record)
        whole = end
    if segment is None:
        return None
    segment.size = whole
    return segment, holes, whole


def _write_all(file: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]
