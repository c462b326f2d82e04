"""What the hub has not stored yet: segments on disk, bounded in bytes and age, trimmed by acks.

Guarantees: records come back in the order they went in; a record is gone only when it was
acknowledged or when a recorded gap tells of it; after a crash at any point what was written
before is there, less what the last seconds' power cut took. All calls block on the disk and
come from one thread.

Forcing every batch to disk (50 a second) would cost more than all the rest of the gateway and
wear out the SD cards robots run on. What the process has written survives its own death without
that; only a power cut needs it. So `sync` is called once a second, and does nothing while the
hub keeps up: then there is nothing here that is not stored elsewhere. A segment that is full
while the hub is away is packed.

Long, because all that touches the files stands in one place.
"""

from __future__ import annotations

import contextlib
import logging
import os
from collections import deque
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from talaia.gateway.spool.disk_room import DiskRoom
from talaia.gateway.spool.files import Segment, SegmentHead, set_aside, unlinked, write_all
from talaia.gateway.spool.former_runs import newest_in
from talaia.gateway.spool.gaps import DroppedSamples, SpoolGaps
from talaia.gateway.spool.opening import DAMAGED, take_up, tell_torn
from talaia.gateway.spool.progress_mark import MarkFile, ProgressMark
from talaia.gateway.spool.segment import RecordKind, SampleRecord, pack_record
from talaia.gateway.spool.segment_packer import pack_segment
from talaia.gateway.spool.segment_reader import (
    SegmentReader,
    SpoolPosition,
    StoredRecord,
    gap_in,
)
from talaia.gateway.spool.sizes import USUAL
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch, SampleGap

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.gateway.spool.former_runs import FormerNewest
    from talaia.gateway.spool.sizes import SpoolSizes

__all__ = ["SegmentHead", "Spool", "SpoolPosition", "StoredRecord"]

log = logging.getLogger(__name__)
FULL = "the gateway's disk space for unsent samples was full"
UNLEARNED = "the hub lost what it had stored, and the gateway had it no more"
OLD = "it waited in the gateway for longer than it is kept"
# A wall clock that is that far off was set (µs).
_JUMP_US = 5_000_000
# A segment is closed at the latest after this part of the age at which it would be dropped.
TURNS = 24


class Spool:
    """See the module."""

    def __init__(
        self,
        *,
        folder: Path,
        head: SegmentHead,
        bound: int,
        age_s: float = float("inf"),
        spare: int = 0,
        now: Callable[[], float] = lambda: 0.0,
        wall_us: Callable[[], int] = lambda: 0,
        machine: str = "",
        sizes: SpoolSizes = USUAL,
    ) -> None:
        """Take up what an earlier run left and begin a segment of this boot.

        Args:
            folder: where the segments are.
            head: of this boot.
            bound: bytes that may wait; the oldest gives way.
            age_s: a segment that has waited for longer gives way too. Time in which no gateway
                runs does not count.
            spare: so much of the disk stays free for what matters more (STOP, commands).
            now: a clock that never jumps (s).
            wall_us: the wall clock (µs, UTC).
            machine: see `ProgressMark.machine`.
            sizes: of its files.

        """
        self._folder = folder
        self._bound = bound
        self._sizes = sizes
        self._age_s, self._now = age_s, now
        # By boot: every sample below is stored at the hub for good.
        self._acked: dict[str, int] = {}
        # What of this boot was acknowledged and is no longer here, should the hub lose it.
        self._gone = DroppedSamples()
        # Up to which sample of this boot the last `sync` came.
        self._synced_end = 0
        # Something was written since then.
        self._dirty = False
        # What the disk does not take now, in order, and its bytes.
        self._memory: deque[SampleRecord] = deque()
        self._memory_bytes = 0
        # The file of the current segment; negative while the disk has no room for it.
        self._file = -1
        self._room = DiskRoom(folder, spare)
        # What is lost, until the hub has acknowledged past it.
        self._gaps = SpoolGaps(folder / "gaps.json")
        self._reader = SegmentReader(self._acked, self._gaps)
        # How far this run came, for the one that follows it.
        self._mark_file = MarkFile(folder / "mark.json")
        # What the run before this one left of itself; none where there was none.
        self.former = self._mark_file.former
        began_us = wall_us()
        deaf_us = began_us if self.former is not None else 0
        self._mark = ProgressMark(head.boot, began_us=began_us, deaf_us=deaf_us, machine=machine)
        # On disk, oldest first; the last is the current one.
        self._segments: list[Segment] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._segments = take_up(folder, self._gaps, self.former)
        except OSError as error:
            # What a robot says waits in memory then; nothing that guards it waits for a disk.
            log.warning("the spool %s cannot be used now: %s", folder, error)
        if self.former is not None:
            tell_torn(self.former, self._segments, self._gaps)
        self._next_number = 1 + max((segment.number for segment in self._segments), default=0)
        # For how long gateways ran before this one (s): the age of what waits counts only that.
        self._ran_s = max((segment.head.ran_s for segment in self._segments), default=0.0) - now()
        self._head = head
        self._current = self._begin()

    # ── writing ──

    def _begin(self) -> Segment:
        """Begin a segment; while the disk has no room for it, the file is not there yet."""
        number = self._next_number
        self._next_number += 1
        head = replace(self._head, ran_s=self._ran_s + self._now())
        segment = Segment(number, self._folder / f"{number:010d}.seg", head, 0, 0)
        self._segments.append(segment)
        self._current, self._file = segment, -1
        while not self._open(segment) and self._room.full and self._drop_oldest(FULL):
            pass
        return segment

    def _open(self, segment: Segment) -> bool:
        data = pack_record(
            SampleRecord(0, 0, 0, 0, msgspec.msgpack.encode(segment.head), RecordKind.SEGMENT)
        )
        file = -1
        try:
            # Made here: a disk that takes something again may have come up without the folder.
            self._folder.mkdir(parents=True, exist_ok=True)
            file = os.open(segment.path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
            write_all(file, data)
        except OSError as error:
            self._room.see_failure(error)
            if file >= 0:
                os.close(file)
                unlinked(segment.path)
            return False
        self._file = file
        segment.size = segment.start = len(data)
        return True

    def redescribe(self, head: SegmentHead) -> None:
        """Keep what comes from here on by another channel list, in a segment of its own."""
        # What waits in memory goes to disk behind the new head: each says its addresses itself.
        self._memory = deque(_alone(record, self._head.addresses) for record in self._memory)
        self._memory_bytes = sum(len(record.body) for record in self._memory)
        old, closed = self._file, self._current
        self._head = head
        self._begin()
        if old >= 0:
            os.close(old)
        if closed not in self._segments:
            return
        if closed.first < 0:
            self._segments.remove(closed)
            unlinked(closed.path)
        else:
            self._pack(closed)

    @property
    def kept(self) -> int:
        """How much is kept, on disk and (while the disk is full) in memory."""
        return sum(segment.size for segment in self._segments) + self._memory_bytes

    def append(self, record: SampleRecord) -> None:
        """Keep a record of this boot. Never raises for a full disk: the oldest gives way."""
        self._trim()
        data = pack_record(record)
        while self.kept + len(data) > self._bound and self._drop_oldest(FULL):
            pass
        # In order: what waits in memory comes first.
        while self._memory and self._place(pack_record(self._memory[0]), self._memory[0]):
            self._memory_bytes -= len(self._memory.popleft().body)
        if self._memory or not self._place(data, record):
            self._keep_in_memory(record)
        self._write_mark(record.end, record.to_us)

    def _write_mark(self, end: int, heard_us: int) -> None:
        """Leave word of how far this run came; first of all, what the run before lost is kept."""
        if self._gaps.dirty and self._mark_file.former is not None:
            self._gaps.write()
            if self._gaps.dirty:
                return
        self._mark_file.former = None
        mark, acked = self._mark, self._acked.get(self._mark.boot, 0)
        if abs(mark.heard_us - heard_us) < _JUMP_US:
            heard_us = max(mark.heard_us, heard_us)
        self._mark = replace(
            mark, end=max(mark.end, end), acked=acked, heard_us=heard_us, mono_s=self._now()
        )
        self._mark_file.write(self._mark)

    def _place(self, data: bytes, record: SampleRecord) -> bool:
        while not (self._room.has_room(len(data)) and self._write(data, record)):
            if not self._room.full or not self._drop_oldest(FULL):
                return False
        return True

    def _write(self, data: bytes, record: SampleRecord) -> bool:
        segment = self._current
        # Quarter of the bound: dropping the oldest must not mean dropping nearly all.
        largest = min(self._sizes.segment, max(self._bound // 4, len(data)))
        waited_s = self._ran_s + self._now() - segment.head.ran_s
        if segment.first >= 0 and (
            segment.size + len(data) > largest or waited_s > self._age_s / TURNS
        ):
            old, closed = self._file, segment
            segment = self._begin()
            if old >= 0:
                os.close(old)
            self._pack(closed)
        if self._file < 0 and not self._open(segment):
            return False
        try:
            write_all(self._file, data)
        except OSError as error:
            self._room.see_failure(error)
            # Where even that fails, a later record is written over what is half there.
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, segment.size)
            os.lseek(self._file, segment.size, os.SEEK_SET)
            return False
        segment.size += len(data)
        segment.add(record)
        self._dirty = True
        return True

    def _pack(self, segment: Segment) -> None:
        """Write a closed segment anew, smaller, unless the hub has it anyway."""
        if segment.end > self._acked.get(segment.head.boot, 0) and segment in self._segments:
            pack_segment(segment)

    def _keep_in_memory(self, record: SampleRecord) -> None:
        self._memory.append(record)
        self._memory_bytes += len(record.body)
        while self._memory_bytes > self._sizes.memory:
            lost = self._memory.popleft()
            self._memory_bytes -= len(lost.body)
            self.lose(lost, FULL)

    def _drop_oldest(self, why: str) -> bool:
        """Let the oldest segment give way; tell whether there was one besides the current."""
        if len(self._segments) < 2:
            return False
        self._drop(self._segments[0], why)
        return True

    def _drop(self, segment: Segment, why: str) -> None:
        first = max(segment.first, self._acked.get(segment.head.boot, 0))
        if first < segment.end:
            # The gap is on record before the file goes: a crash between leaves both, not neither.
            self._gaps.add(gap_in(segment, first, why))
            self._gaps.write()
        self._remove(segment)
        # Where the disk was too full for the gap, there is room now.
        self._gaps.write()

    def _remove(self, segment: Segment) -> None:
        if segment.head.boot == self._head.boot:
            self._gone.add(segment.first, segment.end, segment.from_us, segment.to_us)
        self._segments.remove(segment)
        # A file that the disk does not give up is given out again by a later run: no harm.
        unlinked(segment.path)

    def lose(self, record: SampleRecord, reason: str, boot: str = "") -> None:
        """Record that a batch is gone; of this boot when none is named."""
        self._gaps.add(
            SampleGap(
                boot=boot or self._head.boot,
                first=record.first,
                last=record.end - 1,
                from_us=record.from_us,
                to_us=record.to_us,
                reason=reason,
            )
        )
        if not boot:
            self._mark = replace(self._mark, end=max(self._mark.end, record.end))

    def gaps(self) -> list[SampleGap]:
        """Give the gaps that the hub has not acknowledged past."""
        return self._gaps.all()

    # ── acknowledging ──

    def ack(self, boot: str, below: int) -> None:
        """Note that every sample of ``boot`` below ``below`` is stored for good."""
        if below > self._acked.get(boot, 0):
            self._acked[boot] = below

    def unlearn(self, below: int) -> None:
        """Take back what of this boot was acknowledged from ``below`` on: the hub has lost it.

        Its database was begun anew or is an older one. What is still here is given out again; the
        rest is a gap.
        """
        boot, acked = self._head.boot, self._acked.get(self._head.boot, 0)
        if below >= acked:
            return
        log.warning("the hub has lost samples %d to %d, which it had stored", below, acked - 1)
        self._acked[boot] = below
        for first, end, from_us, to_us in self._gone.since(below):
            span = {"first": first, "last": end - 1, "from_us": from_us, "to_us": to_us}
            self._gaps.add(SampleGap(boot=boot, reason=UNLEARNED, **span))

    def _trim(self) -> None:
        for segment in [
            segment
            for segment in self._segments
            if segment.end <= self._acked.get(segment.head.boot, 0) and segment is not self._current
        ]:
            self._remember_acked()
            self._remove(segment)
        while (
            len(self._segments) > 1
            and self._ran_s + self._now() - self._segments[0].head.ran_s > self._age_s
        ):
            self._drop_oldest(OLD)
        current, acked = self._current, self._acked.get(self._head.boot, 0)
        if current.end <= acked and current.size > self._sizes.trim:
            # Emptied in place: with a hub that keeps up, the pages never reach the disk at all.
            self._empty(current)
        while self._memory and self._memory[0].end <= acked:
            stored = self._memory.popleft()
            self._memory_bytes -= len(stored.body)
            self._gone.add(stored.first, stored.end, stored.from_us, stored.to_us)
        self._gaps.forget(self._acked)

    def all_heard(self) -> None:
        """Note that every channel that speaks has been heard, or is told as a gap."""
        self._mark = replace(self._mark, deaf_us=0)

    def _remember_acked(self) -> None:
        """Leave word that the hub has it, before it goes from here."""
        if self._acked.get(self._mark.boot, 0) > self._mark.acked:
            self._write_mark(self._mark.end, self._mark.heard_us)

    def _empty(self, current: Segment) -> None:
        self._remember_acked()
        try:
            os.ftruncate(self._file, current.start)
        except OSError as error:
            log.debug("%s is not emptied: %s", current.path, error)
            return
        os.lseek(self._file, current.start, os.SEEK_SET)
        self._gone.add(current.first, current.end, current.from_us, current.to_us)
        current.size, current.first = current.start, -1
        current.turn += 1

    def sync(self, heard_us: int = 0) -> None:
        """Force to disk what a power cut would take, unless the hub has it all.

        Args:
            heard_us: up to when all that was heard has been given here (µs, UTC); 0: not known.

        """
        self._trim()
        self._gaps.write()
        if heard_us:
            self._write_mark(0, heard_us)
        settled = self._acked.get(self._head.boot, 0) >= self._synced_end
        self._synced_end = self._current.end
        if not self._dirty or settled or self._file < 0:
            return
        self._dirty = False
        try:
            os.fdatasync(self._file)
        except OSError as error:
            log.warning("the spool cannot be forced to disk: %s", error)

    # ── reading ──

    def read(self, place: SpoolPosition, most: int) -> tuple[list[StoredRecord], SpoolPosition]:
        """Give the next records not yet acknowledged, about ``most`` bytes; none at the end."""
        self._trim()
        for segment in [*self._segments]:
            if segment.number < place.number or segment.first < 0:
                continue
            same = segment.number == place.number and segment.turn == place.turn
            if not same:
                place = SpoolPosition(segment.number, segment.turn, segment.start)
            try:
                found, place = self._reader.read_segment(segment, place, most)
            except OSError as error:
                self._give_up(segment, error)
                continue
            if found:
                return found, place
        last = self._segments[-1].number + 1
        if self._memory and place.number < last:
            return [StoredRecord(self._head, record) for record in self._memory], SpoolPosition(
                last, 0, 0
            )
        return [], place

    def former_segments(self) -> list[int]:
        """Give the numbers of the segments that former runs left, the newest first."""
        boot = self._head.boot
        return [segment.number for segment in reversed(self._segments) if segment.head.boot != boot]

    def newest_in(self, number: int, known: set[str], now_us: int) -> FormerNewest | None:
        """Give the newest samples of a segment (`former_runs`), or none when it is gone."""
        for segment in self._segments:
            if segment.number == number:
                head = segment.head
                try:
                    data = segment.path.read_bytes()
                except OSError as error:
                    log.debug("%s: %s", segment.path, error)
                    return None
                return newest_in(
                    data=data,
                    boot=head.boot,
                    catalogue=head.catalogue,
                    addresses=head.addresses,
                    known=known,
                    now_us=now_us,
                )
        return None

    def seek(self, boot: str, first: int) -> SpoolPosition:
        """Give where to read from to be given sample ``first`` of ``boot`` early on."""
        for segment in self._segments:
            if segment.head.boot == boot and segment.end > first:
                return SpoolPosition(segment.number, -1)
        return SpoolPosition()

    def _give_up(self, segment: Segment, error: OSError) -> None:
        """Set a segment aside that the disk no longer gives back; the link goes on without it."""
        log.warning("%s cannot be read and is set aside: %s", segment.path, error)
        if segment is self._current:
            if self._file >= 0:
                os.close(self._file)
            self._begin()
        try:
            set_aside(segment.path)
        except OSError as failure:
            log.warning("%s cannot be set aside: %s", segment.path, failure)
        first = max(segment.first, self._acked.get(segment.head.boot, 0))
        if first < segment.end:
            self._gaps.add(gap_in(segment, first, DAMAGED))
        self._segments.remove(segment)

    def close(self) -> None:
        """Force to disk and close; an empty current segment is removed."""
        self._trim()
        self._gaps.write()
        self._remember_acked()
        self._mark_file.close()
        if self._file >= 0:
            try:
                os.fdatasync(self._file)
            finally:
                os.close(self._file)
        if self._current.first < 0:
            unlinked(self._current.path)


def _alone(record: SampleRecord, addresses: list[str]) -> SampleRecord:
    """Give a batch that says itself what its channels are."""
    frame = LINK_FROM_GATEWAY.decode(record.body)
    if not isinstance(frame, SampleBatch) or frame.addresses:
        return record
    whole = replace(frame, addresses=addresses)
    return record._replace(body=LINK_FROM_GATEWAY.encode(whole))
