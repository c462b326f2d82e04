"""Samples that are not in a block yet, held in memory for each channel.

Long, because the thread that writes and those that read must agree on each step.

Batches come many channels at a time and are committed every few milliseconds; taking each apart
at once would be most of the hub's work. So they wait as they came (*recent*) and are dealt out to
the channels' *tails* a few thousand samples at a time. One thread writes, any thread reads.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.hub.history.blocks.block import BlockSamples, Reading, concatenate_samples
from talaia.hub.history.writing.chunks import (
    Stretch,
    deal_by_channel,
    join_chunks,
    newest_by_channel,
    pick_channels,
)

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from talaia.hub.history.writing.chunks import Chunk

__all__ = ["NewestHeld", "Snapshot", "Tail", "Tails"]

# More pieces of a tail are joined to one, and so many batches that wait, or of so many samples.
_PARTS = 64
_MOST_SINGLE = 32_768
# Taking batches apart costs by the channel, so it waits for so many samples of each. A reader looks
# through all that wait, so it is not more than so many in all.
_OF_EACH = 16
# The same of each where they are very many.
_OF_MANY, _VERY_MANY = 32, 1_000
_MOST_WAITING = 524_288
# Fewer channels that are not known yet are dealt out at once: it costs next to nothing.
_FEW = 64


class Tail:
    """What of one channel is not in a block.

    Attributes:
        oldest_row: the first journal row whose samples are nowhere but in the journal; None if
            all of them are in the saved tail.
        saved: a saved tail of this channel is in the database.

    """

    def __init__(self) -> None:
        """Start empty."""
        # In the order in which they came; joined when somebody needs them in one piece.
        self.parts: list[BlockSamples] = []
        # Samples in all parts.
        self.size = 0
        self.oldest_row: int | None = None
        self.saved = False
        # Between which times the first ``_bounded`` parts lie, and the newest sample of them: found
        # when a reader asks.
        self._first_us, self._last_us = 2**63 - 1, -(2**63)
        self._newest: Reading | None = None
        self._bounded = 0

    def add_samples(self, samples: BlockSamples) -> None:
        """Put samples at the end."""
        if len(self.parts) >= _PARTS:
            # A slow channel gets its samples one by one; a thousand small arrays are slow to read.
            self.parts = [concatenate_samples(self.parts)]
            self._bounded = 0
        self.parts.append(samples)
        self.size += samples.time_us.size

    def touches(self, from_us: int, to_us: int) -> bool:
        """Whether any of it may lie in a window; most windows of the past are before all of it."""
        self._look_at_parts()
        return self._first_us <= to_us and self._last_us >= from_us

    def newest_reading(self) -> Reading | None:
        """Give the newest of its samples; of equal times the one that came last."""
        self._look_at_parts()
        return self._newest

    def _look_at_parts(self) -> None:
        for part in self.parts[self._bounded :]:
            if part.time_us.size:
                self._first_us = min(self._first_us, int(part.time_us.min()))
                newest = part.newest_reading()
                if newest[0] >= self._last_us:
                    self._last_us, self._newest = newest[0], newest
        self._bounded = len(self.parts)


class NewestHeld(NamedTuple):
    """The newest of what stood in memory of some channels at one moment; ``block``: see below."""

    readings: dict[int, Reading]
    block: int


class Snapshot(NamedTuple):
    """What of one channel stood in memory at one moment.

    Attributes:
        samples: in the order in which they came.
        block: blocks with this id or a higher one are not to be read, since their samples are
            still here.

    """

    samples: BlockSamples
    block: int


class Tails:
    """All tails, and the batches that are still to be dealt out to them."""

    def __init__(self, block: int, row: int, recent: int) -> None:
        """Start empty.

        Args:
            block: id that the next block will get.
            row: journal rows up to this one have been dealt out.
            recent: deal out when so many samples wait.

        """
        # Readers on other threads see either the recent batches or the tails made of them.
        self._lock = threading.Lock()
        # Committed batches that are not yet dealt out: those that were joined, and the last few.
        self._joined: list[Stretch] = []
        self._recent: list[Chunk] = []
        # The row of the newest of them.
        self._recent_row = row
        # Samples in all of them, and in the last few.
        self._waiting = self._single = 0
        # By channel id; a channel has one only while it has samples outside blocks.
        self._tails: dict[int, Tail] = {}
        # Taking batches apart pays only from so many samples on; more, if there are many channels.
        self._enough = recent
        # The same for the channels of those that wait now, once somebody has counted them.
        self._enough_waiting = 0
        # How often batches were dealt out.
        self.deals = 0
        # What `needed_row` found, until enough tails have changed, and how many have.
        self._needed: int | None = None
        self._changed = 0
        # What a reader finds in blocks below it is not here, and the other way round.
        self.block = block
        # The journal is needed from the row after it, whatever the tails say.
        self.dealt_row = row

    def all_tails(self) -> Mapping[int, Tail]:
        """Give the tails by channel id; for the writing thread only."""
        return self._tails

    def add_chunks(self, chunks: list[Chunk], last_row: int = 0) -> None:
        """Take batches that have been committed, in order of their rows.

        Args:
            chunks: each is one row's, unless ``last_row`` says more.
            last_row: the last row of the last one, where several rows are joined to one.

        """
        with self._lock:
            for chunk in chunks:
                self._recent.append(chunk)
                self._recent_row = last_row or chunk.row
                self._single += chunk.time_us.size
                # A reader looks through ten thousand small arrays slowly, and through large ones.
                if len(self._recent) == _PARTS or self._single >= _MOST_SINGLE:
                    self._joined.append(Stretch(join_chunks(self._recent)))
                    self._recent, self._single = [], 0
            self._waiting += sum(chunk.time_us.size for chunk in chunks)

    def waiting_channels(self) -> set[int]:
        """Give the channels of batches that are not dealt out; for the writing thread only."""
        ids = [chunk.channel for chunk in self._all_waiting()]
        return set(np.unique(np.concatenate(ids)).tolist()) if ids else set()

    def is_due(self) -> bool:
        """Tell whether enough batches wait to be dealt out; for the writing thread only."""
        enough = _enough_of(len(self._tails))
        if self._waiting < max(self._enough, self._enough_waiting, enough):
            return False
        # Seldom: of ten thousand channels that are all new, none has a tail yet.
        ids = np.concatenate([chunk.channel for chunk in self._all_waiting()])
        channels = np.count_nonzero(np.bincount(ids))
        if channels > _FEW:
            self._enough_waiting = _enough_of(int(channels))
        return self._waiting >= self._enough_waiting

    def restore_tail(self, channel: int, samples: BlockSamples) -> None:
        """Take a tail that was saved in the database."""
        tail = self._tails.setdefault(channel, Tail())
        tail.add_samples(samples)
        tail.saved = True

    def deal_chunks(self) -> bool:
        """Take the waiting batches apart, by channel; tell whether there were any."""
        chunks = self._all_waiting()
        if not chunks:
            return False
        # Outside the lock: it is the long part, and only this thread changes what it reads.
        dealt = deal_by_channel(chunks)
        with self._lock:
            tails = self._tails
            for channel, row, samples in dealt:
                tail = tails.get(channel)
                if tail is None:
                    tail = tails[channel] = Tail()
                tail.add_samples(samples)
                if tail.oldest_row is None:
                    tail.oldest_row = row
            self._joined, self._recent = [], []
            self._waiting = self._single = 0
            self._enough_waiting = 0
            self._needed = None
            self.deals += 1
            self.dealt_row = self._recent_row
        return True

    def forget_sealed(self, channels: list[int], block: int) -> None:
        """Forget the tails of these channels: they are in blocks below ``block`` now."""
        with self._lock:
            for channel in channels:
                del self._tails[channel]
            self.block = block
        self._count_changes(len(channels))

    def mark_saved(self, channels: list[int]) -> None:
        """Remember that the tails of these channels are in the database as they stand."""
        for channel in channels:
            tail = self._tails[channel]
            tail.saved, tail.oldest_row = True, None
        self._count_changes(len(channels))

    def _count_changes(self, count: int) -> None:
        # To look through ten thousand tails for a few that need no row any more takes longer than
        # all else of a commit; a row that stays a little longer harms nobody.
        self._changed += count
        if self._changed >= len(self._tails) // 64:
            self._needed = None

    def needed_row(self) -> int:
        """Give the first journal row that must not be deleted, or one a little before it."""
        if self._needed is None:
            self._changed = 0
            rows = [tail.oldest_row for tail in self._tails.values() if tail.oldest_row is not None]
            self._needed = min(rows, default=self.dealt_row + 1)
        return self._needed

    def channel_snapshot(
        self, channel: int, from_us: int = -(2**63), to_us: int = 2**63 - 1
    ) -> Snapshot:
        """Give what is held of a channel: all of a window, perhaps more; from any thread."""
        return self.channel_snapshots([channel], from_us, to_us)[channel]

    def channel_snapshots(
        self, channels: Collection[int], from_us: int = -(2**63), to_us: int = 2**63 - 1
    ) -> dict[int, Snapshot]:
        """Give what is held of each of several channels, as of one moment."""
        found: dict[int, list[BlockSamples]] = {channel: [] for channel in channels}
        with self._lock:
            for channel, parts in found.items():
                tail = self._tails.get(channel)
                if tail is not None and tail.touches(from_us, to_us):
                    parts += tail.parts
            joined, recent = list(self._joined), list(self._recent)
            block = self.block
        waiting = pick_channels(joined, recent, channels) if channels else None
        for channel, _, samples in deal_by_channel([waiting]) if waiting is not None else ():
            found[channel].append(samples)
        return {
            channel: Snapshot(concatenate_samples(parts), block) for channel, parts in found.items()
        }

    def newest_readings(self, channels: Collection[int], to_us: int) -> NewestHeld:
        """Give what is newest of channels up to a time, as of one moment; from any thread."""
        found: dict[int, Reading] = {}
        # Those of which more is held than up to the time.
        beyond: list[tuple[int, list[BlockSamples]]] = []
        with self._lock:
            for channel in channels:
                tail = self._tails.get(channel)
                if tail is None:
                    continue
                if (newest := tail.newest_reading()) is not None and newest[0] <= to_us:
                    found[channel] = newest
                elif tail.touches(-(2**63), to_us):
                    beyond.append((channel, list(tail.parts)))
            joined, recent = list(self._joined), list(self._recent)
            block = self.block
        for channel, parts in beyond:
            found[channel] = concatenate_samples(parts).up_to(to_us).newest_reading()
        waiting = pick_channels(joined, recent, channels) if channels else None
        if waiting is not None:
            for channel, reading in newest_by_channel(waiting, to_us):
                # What waits came later than what is in the tail.
                if channel not in found or reading[0] >= found[channel][0]:
                    found[channel] = reading
        return NewestHeld(found, block)

    def _all_waiting(self) -> list[Chunk]:
        return [*(stretch.chunk for stretch in self._joined), *self._recent]


def _enough_of(channels: int) -> int:
    """Give how many samples wait at least before they are dealt out to so many channels."""
    of_each = _OF_EACH if channels < _VERY_MANY else _OF_MANY
    return min(of_each * channels, _MOST_WAITING)
