"""Committed batches that are not dealt out to their channels yet, and what is found in them. Pure.

Up to half a million samples may wait. Somebody asks for a few channels of them all the time, so of
those that were joined it is remembered where each channel's are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time

from talaia.hub.history.blocks.block import BlockSamples, concatenate_samples

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from talaia.hub.history.blocks.block import Reading

__all__ = [
    "Chunk",
    "Stretch",
    "deal_by_channel",
    "join_chunks",
    "newest_by_channel",
    "pick_channels",
]

# To look a channel up takes about as long as to look through so many samples.
_LOOKED_UP = 1_000
# NumPy sorts numbers below it by their digits, in a fifth of the time.
_SHORT = 1 << 16
# So few channels are looked for one after the other.
_FEW = 3


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

    def select_positions(self, positions: NDArray[np.intp]) -> Chunk:
        """Keep these positions, in this order."""
        texts: dict[int, str] = {}
        if self.texts:
            own = self.texts
            texts = {at: own[p] for at, p in enumerate(positions.tolist()) if p in own}
        return Chunk(
            self.row,
            self.channel[positions],
            self.time_us[positions],
            self.value[positions],
            texts,
        )


class Stretch:
    """Several batches joined to one, which does not change any more; for any thread."""

    def __init__(self, chunk: Chunk) -> None:
        """Take what was joined."""
        self.chunk = chunk
        # Positions by channel, of each in the order in which they came, and the channels in that
        # order: found when somebody asks. Two readers that find it at once find the same.
        self._by_channel: tuple[NDArray[np.intp], NDArray[np.int64]] | None = None

    def positions_of(self, channels: NDArray[np.int64]) -> list[NDArray[np.intp]]:
        """Find where the samples of channels are; of each in the order in which they came."""
        found = self._by_channel
        if found is None:
            order = order_by_channel(self.chunk.channel)
            found = self._by_channel = order, self.chunk.channel[order]
        order, ids = found
        first = np.searchsorted(ids, channels, "left").tolist()
        past = np.searchsorted(ids, channels, "right").tolist()
        return [order[begin:end] for begin, end in zip(first, past, strict=True) if begin < end]


def order_by_channel(ids: NDArray[np.int64]) -> NDArray[np.intp]:
    """Give the positions of channels' samples, channel by channel, of each as they came."""
    short = bool(ids.size) and int(ids.min()) >= 0 and int(ids.max()) < _SHORT
    return np.argsort(ids.astype(np.uint16) if short else ids, kind="stable")


def join_chunks(chunks: Sequence[Chunk]) -> Chunk:
    """Make one of several; its row is the first one's, so that none is deleted too early."""
    if len(chunks) == 1:
        return chunks[0]
    parts = [BlockSamples(chunk.time_us, chunk.value, chunk.texts) for chunk in chunks]
    samples = concatenate_samples(parts)
    ids = np.concatenate([chunk.channel for chunk in chunks])
    return Chunk(chunks[0].row, ids, *samples)


def pick_channels(
    stretches: Sequence[Stretch], chunks: Sequence[Chunk], channels: Collection[int]
) -> Chunk | None:
    """Give all samples of some channels, of each in the order in which they came.

    Args:
        stretches: what came first.
        chunks: what came after it.
        channels: their numbers; at least one.

    """
    asked = np.array(list(channels), np.int64)
    wanted = _Wanted(asked)
    found: list[Chunk] = []
    for stretch in stretches:
        if asked.size * _LOOKED_UP < stretch.chunk.channel.size:
            if parts := stretch.positions_of(asked):
                found.append(stretch.chunk.select_positions(np.concatenate(parts)))
        else:
            found += _pick_wanted(stretch.chunk, wanted)
    for chunk in chunks:
        found += _pick_wanted(chunk, wanted)
    return join_chunks(found) if found else None


class _Wanted:
    """Channels that are sought."""

    def __init__(self, channels: NDArray[np.int64]) -> None:
        self._channels: list[int] = channels.tolist() if channels.size <= _FEW else []
        # One more: what is beyond it counts as not asked for.
        self._is_asked = np.zeros(int(channels.max()) + 2, np.bool_)
        self._is_asked[channels] = True

    def find(self, ids: NDArray[np.int64]) -> NDArray[np.intp]:
        """Give where they are; of each in the order in which they came."""
        if self._channels:
            # To compare is quicker than to look up.
            return np.concatenate([np.flatnonzero(ids == one) for one in self._channels])
        return np.flatnonzero(self._is_asked.take(ids, mode="clip"))


def _pick_wanted(chunk: Chunk, wanted: _Wanted) -> list[Chunk]:
    positions = wanted.find(chunk.channel)
    return [chunk.select_positions(positions)] if positions.size else []


def newest_by_channel(chunk: Chunk, to_us: int) -> Iterator[tuple[int, Reading]]:
    """Give each channel's newest sample up to a time; of equal times the one that came last."""
    time_us, positions = chunk.time_us, np.arange(chunk.time_us.size)
    if bool((time_us > to_us).any()):
        positions = np.flatnonzero(time_us <= to_us)
        time_us = time_us[positions]
    if not positions.size:
        return
    if bool((time_us[1:] < time_us[:-1]).any()):
        positions = positions[np.argsort(time_us, kind="stable")]
    ids = chunk.channel[positions]
    last = np.full(int(ids.max()) + 1, -1, np.intp)
    # Of equal indexes the last one counts: NumPy assigns in order.
    last[ids] = positions
    channels = np.flatnonzero(last >= 0)
    chosen = last[channels]
    times, values = chunk.time_us[chosen].tolist(), chunk.value[chosen].tolist()
    for channel, at, when, value in zip(
        channels.tolist(), chosen.tolist(), times, values, strict=True
    ):
        yield channel, (when, value, chunk.texts.get(at, ""))


def deal_by_channel(chunks: Sequence[Chunk]) -> list[tuple[int, int, BlockSamples]]:
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
    order = order_by_channel(ids)
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


def _own_copy(samples: BlockSamples) -> BlockSamples:
    # A view would keep the whole batch of all channels in memory for as long as this channel.
    return BlockSamples(samples.time_us.copy(), samples.value.copy(), samples.texts)
