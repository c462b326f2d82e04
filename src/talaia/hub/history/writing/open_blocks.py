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
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time

from talaia.hub.history.blocks.block import BlockSamples, concatenate_samples

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

__all__ = ["Chunk", "Snapshot", "Tail", "Tails"]

# More pieces of a tail are joined to one, and so many batches that wait.
_PARTS = 64
# Taking batches apart costs by the channel, so it waits for so many samples of each. A reader looks
# through all that wait, so it is not more than so many in all.
_OF_EACH = 16
# The same of each where they are very many.
_OF_MANY, _VERY_MANY = 32, 1_000
_MOST_WAITING = 524_288
# Fewer channels that are not known yet are dealt out at once: it costs next to nothing.
_FEW = 64
# So many channels or more are looked for together in what waits.
_MANY = 4


class Chunk(NamedTuple):
    """Samples of one journal row or several; the arrays have the shape (n,).

    Attributes:
        row: the journal row's id; the first one's, if several were joined.
        channel: channel ids, not catalogue indexes.

    """

    row: int
    channel: NDArray[np.int64]
    time_us: NDArray[np.int64]
    value: NDArray[np.float64]
    texts: dict[int, str]


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
        # Between which times the first ``_bounded`` parts lie: found when a reader asks.
        self._first_us, self._last_us = 2**63 - 1, -(2**63)
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
        for part in self.parts[self._bounded :]:
            if part.time_us.size:
                self._first_us = min(self._first_us, int(part.time_us.min()))
                self._last_us = max(self._last_us, int(part.time_us.max()))
        self._bounded = len(self.parts)
        return self._first_us <= to_us and self._last_us >= from_us


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
        # Committed batches, as they came, not yet dealt out; the last so many are not joined yet.
        self._recent: list[Chunk] = []
        self._single = 0
        # The row of the newest of them.
        self._recent_row = row
        # Samples in ``_recent``.
        self._waiting = 0
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
                self._single += 1
                # A reader looks through ten thousand small arrays slowly.
                if self._single == _PARTS:
                    self._recent[-_PARTS:] = [_join_chunks(self._recent[-_PARTS:])]
                    self._single = 0
            self._waiting += sum(chunk.time_us.size for chunk in chunks)

    def waiting_channels(self) -> set[int]:
        """Give the channels of batches that are not dealt out; for the writing thread only."""
        ids = [chunk.channel for chunk in self._recent]
        return set(np.unique(np.concatenate(ids)).tolist()) if ids else set()

    def is_due(self) -> bool:
        """Tell whether enough batches wait to be dealt out; for the writing thread only."""
        enough = _enough_of(len(self._tails))
        if self._waiting < max(self._enough, self._enough_waiting, enough):
            return False
        # Seldom: of ten thousand channels that are all new, none has a tail yet.
        ids = np.concatenate([chunk.channel for chunk in self._recent])
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
        chunks = self._recent
        if not chunks:
            return False
        # Outside the lock: it is the long part, and only this thread changes what it reads.
        dealt = _deal_by_channel(chunks)
        with self._lock:
            tails = self._tails
            for channel, row, samples in dealt:
                tail = tails.get(channel)
                if tail is None:
                    tail = tails[channel] = Tail()
                tail.add_samples(samples)
                if tail.oldest_row is None:
                    tail.oldest_row = row
            self._recent, self._waiting, self._single = [], 0, 0
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
            recent = list(self._recent)
            block = self.block
        for channel, samples in _find_waiting(recent, found):
            found[channel].append(samples)
        return {
            channel: Snapshot(concatenate_samples(parts), block) for channel, parts in found.items()
        }


def _enough_of(channels: int) -> int:
    """Give how many samples wait at least before they are dealt out to so many channels."""
    of_each = _OF_EACH if channels < _VERY_MANY else _OF_MANY
    return min(of_each * channels, _MOST_WAITING)


def _find_waiting(
    chunks: list[Chunk], channels: Collection[int]
) -> Iterator[tuple[int, BlockSamples]]:
    """Find the samples of channels in batches, of each in the order in which they came."""
    if len(channels) >= _MANY and chunks:
        # All that wait would be looked through for each of them.
        whole = _join_chunks(chunks)
        ids = whole.channel
        wanted = np.zeros(1 + max(int(ids.max(initial=0)), *channels), np.bool_)
        wanted[list(channels)] = True
        positions = np.flatnonzero(wanted[ids])
        samples = BlockSamples(whole.time_us, whole.value, whole.texts)
        mine = Chunk(whole.row, ids[positions], *samples.select_positions(positions))
        for channel, _, of_channel in _deal_by_channel([mine]):
            yield channel, of_channel
        return
    for channel in channels:
        for chunk in chunks:
            positions = np.flatnonzero(chunk.channel == channel)
            if positions.size:
                samples = BlockSamples(chunk.time_us, chunk.value, chunk.texts)
                yield channel, samples.select_positions(positions)


def _deal_by_channel(chunks: list[Chunk]) -> list[tuple[int, int, BlockSamples]]:
    """Give channel, first row and samples of each channel, in the order in which they came."""
    ids = np.concatenate([chunk.channel for chunk in chunks])
    if not ids.size:  # after a start, all of it may have been in blocks already
        return []
    together = concatenate_samples([BlockSamples(c.time_us, c.value, c.texts) for c in chunks])
    if bool((ids == ids[0]).all()):
        first = next(chunk.row for chunk in chunks if chunk.time_us.size)
        return [(int(ids[0]), first, together if len(chunks) > 1 else _own_copy(together))]
    sizes = [chunk.time_us.size for chunk in chunks]
    rows = np.repeat(np.array([chunk.row for chunk in chunks], np.int64), sizes)
    order = np.argsort(ids, kind="stable")
    in_turn = together.select_positions(order)
    ids = ids[order]
    starts = np.flatnonzero(np.concatenate(([True], ids[1:] != ids[:-1])))
    texts: dict[int, dict[int, str]] = {}
    for position, text in in_turn.texts.items():
        number = int(np.searchsorted(starts, position, "right")) - 1
        texts.setdefault(number, {})[position - int(starts[number])] = text
    # With ten thousand channels each call for each of them counts: all that can be is done at once.
    bounds = zip(starts.tolist(), [*starts[1:].tolist(), ids.size], strict=True)
    owners = zip(ids[starts].tolist(), rows[order[starts]].tolist(), bounds, strict=True)
    time_us, value = in_turn.time_us, in_turn.value
    # A view would keep the batch of all channels in memory for as long as this one.
    return [
        (
            channel,
            row,
            BlockSamples(time_us[first:past].copy(), value[first:past].copy(), texts.get(at, {})),
        )
        for at, (channel, row, (first, past)) in enumerate(owners)
    ]


def _join_chunks(chunks: list[Chunk]) -> Chunk:
    """Make one of several; its row is the first one's, so that none is deleted too early."""
    parts = [BlockSamples(chunk.time_us, chunk.value, chunk.texts) for chunk in chunks]
    samples = concatenate_samples(parts)
    ids = np.concatenate([chunk.channel for chunk in chunks])
    return Chunk(chunks[0].row, ids, samples.time_us, samples.value, samples.texts)


def _own_copy(samples: BlockSamples) -> BlockSamples:
    # A view would keep the whole batch of all channels in memory for as long as this channel.
    return BlockSamples(samples.time_us.copy(), samples.value.copy(), samples.texts)
