"""Samples from adapter threads become numbered batches, about one every 40 ms.

Long, because threads and the loop meet in one queue, and what is taken from it when is one thing:
what somebody at the hub looks at goes out sooner, in batches of its own; the rest keeps its pace.
When which batch is made is `FlushPace`'s to say.

Threads hand over columns, not samples: the event loop sees a few arrays for each flush, however
fast the robot speaks, and nothing at all while it is silent.
"""

from __future__ import annotations

import math
import time
from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from talaia.gateway.samples.absence_gaps import FirstHeard
from talaia.gateway.samples.flush_pace import FlushPace
from talaia.gateway.samples.monotonic_times import MonotonicTimes
from talaia.gateway.samples.newest_samples import RunNewest
from talaia.gateway.spool.segment import SampleRecord
from talaia.wire.columns import (
    MAX_SAMPLES,
    Columns,
    join_columns,
    pack_columns,
    pick_samples,
    renumber_channels,
    slice_columns,
)
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from numpy.typing import NDArray

    from talaia.wire.newest import NewestSamples

__all__ = ["Batcher", "records_of"]

# Samples; beyond this the event loop has stood still for seconds, and memory is not to pay for it.
MAX_WAITING = 1_000_000
# As many as fit the samples' column of channels.
_CHANNELS = 65_536
# Below this many samples Python's own functions cost less than NumPy's.
_FEW = 64
OVERRUN = "the gateway could not keep up"


def records_of(columns: Columns, boot: str, catalogue: str, first: int) -> list[SampleRecord]:
    """Encode columns as `SampleBatch` frames; several if one cannot hold them.

    A batch is halved until it fits: more samples than a batch may hold, or a wall clock that
    jumped further than offsets can tell.
    """
    count = len(columns)
    if count == 0:
        return []
    if count <= MAX_SAMPLES:
        try:
            packed = pack_columns(columns)
        except ValueError:
            if count == 1:
                raise
        else:
            frame = SampleBatch(
                boot=boot,
                first=first,
                catalogue=catalogue,
                base_us=packed.base_us,
                channel=packed.channel,
                offset=packed.offset,
                value=packed.value,
                texts=packed.texts,
            )
            low, high = _span_us(columns)
            return [SampleRecord(first, count, low, high, LINK_FROM_GATEWAY.encode(frame))]
    middle = count // 2
    return [
        *records_of(slice_columns(columns, 0, middle), boot, catalogue, first),
        *records_of(slice_columns(columns, middle, count), boot, catalogue, first + middle),
    ]


def _span_us(columns: Columns) -> tuple[int, int]:
    """Give the earliest and the latest time of samples, of which there is one at least."""
    if len(columns) > _FEW:
        return int(columns.time_us.min()), int(columns.time_us.max())
    times = columns.time_us.tolist()
    return min(times), max(times)


class Batcher:
    """A `SampleSink`: numbers samples and gives each batch to the spool and to the link."""

    def __init__(
        self,
        *,
        loop: asyncio.AbstractEventLoop,
        boot: str,
        catalogue: str,
        flush: float,
        keep: Callable[[SampleRecord], None],
        lose: Callable[[SampleRecord, str], None],
        now_s: Callable[[], float] = time.monotonic,
        spent_s: Callable[[], float] = time.thread_time,
    ) -> None:
        """Start at sequence 0.

        Args:
            loop: where batches are made.
            boot: this run's name.
            catalogue: the channel list's name.
            flush: a batch is made about so often (s).
            keep: takes each batch, in order.
            lose: takes the range (a record without body) of samples that had to be dropped.
            now_s: the clock by which batches are paced (monotonic, s).
            spent_s: tells what the loop's thread has used of the processor (s).

        """
        self._loop = loop  # Every method but `put_samples` is called on it.
        self._boot = boot  # Names this run in each batch.
        self._catalogue = catalogue  # Name of the channel list; replaced by `redescribe`.
        self._keep = keep  # The spool and the link; each batch in order.
        self._lose = lose  # The spool's gaps.
        self._now_s, self._spent_s = now_s, spent_s
        self._pace = FlushPace(flush)
        # By channel number: somebody looks at it. None: nobody at any. Replaced whole, so that any
        # thread may read it.
        self._watched: NDArray[np.bool_] | None = None
        # Not numbered yet; appended by any thread (a deque's append is atomic), emptied by the
        # loop.
        self._chunks: deque[Columns] = deque()
        # Taken from there, and left for the next batch of all: nobody looks at it.
        self._rest: list[Columns] = []
        # Samples in `_chunks`, about: threads add without a lock, and the bound need not be exact.
        self._waiting = 0
        # Some of what waits is watched, perhaps.
        self._soon = False
        # The loop has been woken, and has not come to it yet.
        self._called = False
        # Makes the batch when no further hand-over comes, at this time (monotonic s).
        self._timer: asyncio.TimerHandle | None = None
        self._armed_s = math.inf
        # Samples dropped since the last flush, and the time they span (µs).
        self._dropped = 0
        self._dropped_us = (0, 0)
        self._times = MonotonicTimes()  # Mends times that do not rise.
        self._newest = RunNewest()  # The newest sample of each channel.
        # When each channel was first heard in this run.
        self.first_heard = FirstHeard(time.monotonic_ns())
        # From numbers to places in the list that counts; None while they are the same.
        self._order: NDArray[np.int64] | None = None
        self.next = 0  # The next sequence number; samples and gaps share the row.

    def put_samples(self, columns: Columns) -> None:
        """Take samples; any thread."""
        if self._waiting > MAX_WAITING:
            # Dropped whole, with their time, so that the history shows the gap.
            from_us, to_us = int(columns.time_us.min()), int(columns.time_us.max())
            if self._dropped:
                from_us, to_us = (
                    min(from_us, self._dropped_us[0]),
                    max(to_us, self._dropped_us[1]),
                )
            self._dropped_us = from_us, to_us
            self._dropped += len(columns)
            return
        self._chunks.append(columns)
        self._waiting += len(columns)
        watched, pace = self._watched, self._pace
        ripe_s, late_s = pace.ripe_s, pace.late_s
        if watched is not None and np.count_nonzero(watched[columns.channel]):
            self._soon = True
            ripe_s, late_s = min(ripe_s, pace.soon_ripe_s), min(late_s, pace.soon_late_s)
        # Only the one that makes a batch ripe wakes the loop, and one that has no timer yet.
        if not self._called and (self._now_s() >= ripe_s or late_s < self._armed_s):
            self._called = True
            self._loop.call_soon_threadsafe(self._make_ripe)

    def watch_channels(
        self, catalogue: str, places: NDArray[np.uint16], every_s: float = 0.0
    ) -> bool:
        """Have these channels go out soon from here on, and no others; event loop only.

        Args:
            catalogue: names the list that they are places in.
            places: of the channels that somebody looks at.
            every_s: they are wanted so often (s); 0: as soon as can be.

        Returns:
            False where that is not the list that counts; nothing is changed then.

        """
        if catalogue != self._catalogue:
            return False
        watched = np.zeros(_CHANNELS, bool)
        watched[places] = True
        order = self._order
        if order is not None:
            by_place, watched = watched, np.zeros(_CHANNELS, bool)
            watched[: order.size] = by_place[order] & (order >= 0)
        # What waits is looked at by the new ones, oldest first: no channel overtakes itself.
        self._pace.wanted_s = every_s
        self._watched = watched if watched.any() else None
        return True

    def redescribe(self, catalogue: str, order: NDArray[np.int64]) -> None:
        """Number by another channel list from here on; event loop only.

        What was put before goes out by the old one.

        Args:
            catalogue: the new list's name.
            order: see `ChannelNumbering.order_of`.

        """
        # Whatever waits was numbered by the old list.
        self.flush_batches()
        self._catalogue, self._order = catalogue, order

    def _make_ripe(self) -> None:
        """Make the batch that is ripe, or wait for it."""
        self._called = False
        now_s, pace = self._now_s(), self._pace
        if now_s >= pace.ripe_s:
            self.flush_batches()
        elif self._soon and now_s >= pace.soon_ripe_s:
            self._flush_watched(now_s)
        else:
            self._arm_timer(min(pace.late_s, pace.soon_late_s) if self._soon else pace.late_s)

    def _arm_timer(self, due_s: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._armed_s = due_s
        self._timer = self._loop.call_later(due_s - self._now_s(), self._make_ripe)

    def _take_waiting(self) -> list[Columns]:
        """Take what waits, the oldest first."""
        # Before the chunks: what is put from here on wakes the loop anew.
        self._called = self._soon = False
        chunks, self._rest = self._rest, []
        while self._chunks:
            chunks.append(self._chunks.popleft())
        self._waiting = 0
        return chunks

    def flush_batches(self) -> None:
        """Make batches of what waits; event loop only."""
        self._pace.begin_batch(self._now_s(), whole=True)
        if self._timer is not None:
            self._timer.cancel()
            self._timer, self._armed_s = None, math.inf
        chunks = self._take_waiting()
        if chunks:
            # While a robot speaks no hand-over but the ripe one wakes the loop: it wakes itself.
            self._arm_timer(self._pace.late_s)
            self._number_samples(join_columns(chunks))
        if self._dropped:
            dropped, self._dropped = self._dropped, 0
            # After the batches: the gap's numbers follow what was heard before it.
            self._lose(SampleRecord(self.next, dropped, *self._dropped_us, b""), OVERRUN)
            self.next += dropped

    def _flush_watched(self, now_s: float) -> None:
        """Make a batch of what is watched, and leave the rest for its turn."""
        began_s = self._spent_s()
        self._pace.begin_batch(now_s, whole=False)
        chunks = self._take_waiting()
        if self._armed_s != self._pace.late_s:
            self._arm_timer(self._pace.late_s)
        # Marked as watched a moment before it was taken, or before nobody looked any more.
        if not chunks or self._watched is None:
            self._rest = chunks
            return
        columns = join_columns(chunks)
        watched = self._watched[columns.channel]
        if np.count_nonzero(watched) < len(columns):
            self._rest = [pick_samples(columns, ~watched)]
            columns = pick_samples(columns, watched)
        if len(columns):
            self._number_samples(columns)
        self._pace.add_cost(self._spent_s() - began_s)

    def _number_samples(self, columns: Columns) -> None:
        """Make batches of samples, and give each to the spool and the link."""
        columns = self._times.make_monotonic(columns)
        numbers = columns.channel
        if self._order is not None:
            # -1: a channel that the new description has no more.
            numbers = numbers[self._order[numbers] >= 0]
            columns = renumber_channels(columns, self._order)
        now_ns = time.monotonic_ns()
        self._newest.update_newest(numbers, columns, self.next, now_ns)
        self.first_heard.add_batch(numbers, now_ns)
        made = records_of(columns, self._boot, self._catalogue, self.next)
        self.next = made[-1].end if made else self.next
        for record in made:
            self._keep(record)

    def newest_samples(self) -> NewestSamples:
        """Give the newest sample of each channel of this run; event loop only.

        What waits to be numbered is newer, and follows as live samples do.
        """
        return self._newest.newest_samples(self._order, time.monotonic_ns())

    def record_gap(self, from_us: int, to_us: int, reason: str) -> None:
        """Record that samples of this time may never have been heard; event loop only.

        The gap has a number of its own, for nobody knows how many there were.
        """
        self._lose(SampleRecord(self.next, 1, from_us, to_us, b""), reason)
        self.next += 1
