"""Samples of one channel as one piece of bytes, and what goes into one.

A block's bytes are: version (u8), length of the times (u32), the times, length of the values
(u32), the values, and then, if there are any, the texts as MessagePack. Times and values are
`pcodec` files, which keep every bit, NaN payloads too. All numbers are little-endian.
"""

from __future__ import annotations

import struct
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time
from pcodec import ChunkConfig, DeltaSpec, standalone

from talaia.hub.history.errors import HistoryError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

__all__ = [
    "EMPTY",
    "BlockSamples",
    "LastTimes",
    "Reading",
    "concatenate_samples",
    "decode_block",
    "decode_run",
    "decode_values",
    "encode_block",
    "in_order",
    "split_blocks",
]

VERSION = 1
_HEAD = struct.Struct("<BI")
_LENGTH = struct.Struct("<I")
# Level 4 is the knee: above it, time grows and size hardly shrinks.
_CONFIG = ChunkConfig(compression_level=4)
# As a row of the journal is packed: nothing is tried.
_QUICK_CONFIG = ChunkConfig(compression_level=0, delta_spec=DeltaSpec.try_consecutive(1))
_TEXTS = msgspec.msgpack.Decoder(dict[int, str])
HOUR_US = 3_600_000_000
# A pause so many times the usual step (and over an hour) ends a block.
PAUSE = 64.0


# Time (µs), value and text of one sample.
Reading = tuple[int, float, str]


class BlockSamples(NamedTuple):
    """Samples of one channel; the arrays have the shape (n,), ``texts`` goes by position."""

    time_us: NDArray[np.int64]
    value: NDArray[np.float64]
    texts: dict[int, str]

    def between_times(self, from_us: int, to_us: int) -> BlockSamples:
        """Keep what lies in the window, both ends included; the times must be in order."""
        first = int(np.searchsorted(self.time_us, from_us, "left"))
        past = int(np.searchsorted(self.time_us, to_us, "right"))
        return self.slice_positions(first, past)

    def slice_positions(self, first: int, past: int) -> BlockSamples:
        """Keep the positions from ``first`` up to ``past``."""
        if first == 0 and past == self.time_us.size:
            return self
        texts = {p - first: text for p, text in self.texts.items() if first <= p < past}
        return BlockSamples(self.time_us[first:past], self.value[first:past], texts)

    def up_to(self, to_us: int) -> BlockSamples:
        """Keep what is not after a time; the times need not be in order."""
        if not self.time_us.size or int(self.time_us.max()) <= to_us:
            return self
        return self.select_positions(np.flatnonzero(self.time_us <= to_us))

    def newest_reading(self) -> Reading:
        """Give the newest of at least one sample; of equal times the one that came last."""
        at = self.time_us.size - 1
        if self.time_us[at] < self.time_us.max():
            at -= int(self.time_us[::-1].argmax())
        return int(self.time_us[at]), float(self.value[at]), self.texts.get(at, "")

    def select_positions(self, positions: NDArray[np.intp]) -> BlockSamples:
        """Keep these positions, in this order, each at most once."""
        texts: dict[int, str] = {}
        if self.texts:
            place = np.full(self.time_us.size, -1, np.intp)
            place[positions] = np.arange(positions.size)
            texts = {int(place[p]): text for p, text in self.texts.items() if place[p] >= 0}
        return BlockSamples(self.time_us[positions], self.value[positions], texts)


EMPTY = BlockSamples(np.empty(0, np.int64), np.empty(0, np.float64), {})


def concatenate_samples(parts: list[BlockSamples]) -> BlockSamples:
    """Put samples one after the other."""
    # Of a past window there is often nothing in memory, or nothing in blocks: no copy then.
    parts = [part for part in parts if part.time_us.size]
    if len(parts) < 2:
        return parts[0] if parts else EMPTY
    texts: dict[int, str] = {}
    at = 0
    for part in parts:
        texts.update({at + p: text for p, text in part.texts.items()})
        at += part.time_us.size
    return BlockSamples(
        np.concatenate([part.time_us for part in parts]),
        np.concatenate([part.value for part in parts]),
        texts,
    )


def in_order(samples: BlockSamples) -> BlockSamples:
    """Sort by time; samples with one time stamp stay in the order in which they came."""
    time_us = samples.time_us
    if time_us.size < 2 or bool((time_us[1:] >= time_us[:-1]).all()):
        return samples
    return samples.select_positions(np.argsort(time_us, kind="stable"))


def split_blocks(samples: BlockSamples, block: int) -> Iterator[BlockSamples]:
    """Cut samples in order of time into blocks of about ``block``.

    A block also ends at a long pause. So one sample with a wrong clock, or old samples that came
    late among new ones, do not make a block that every window overlaps.
    """
    step = np.diff(samples.time_us.astype(np.float64))
    bounds = [0, samples.time_us.size]
    if step.size:
        pause = max(float(HOUR_US), PAUSE * float(np.median(step)))
        bounds[1:1] = [int(at) + 1 for at in np.flatnonzero(step > pause)]
    for first, past in pairwise(bounds):
        size = past - first
        pieces = max(1, round(size / block))
        for piece in range(pieces):
            yield samples.slice_positions(
                first + size * piece // pieces, first + size * (piece + 1) // pieces
            )


def encode_block(samples: BlockSamples, *, is_kept: bool = True) -> bytes:
    """Compress samples, in the order given; less, in less time, what is not kept for long."""
    config = _CONFIG if is_kept else _QUICK_CONFIG
    times: bytes = standalone.simple_compress(np.ascontiguousarray(samples.time_us), config)
    values: bytes = standalone.simple_compress(np.ascontiguousarray(samples.value), config)
    texts = msgspec.msgpack.encode(samples.texts) if samples.texts else b""
    return b"".join(
        (_HEAD.pack(VERSION, len(times)), times, _LENGTH.pack(len(values)), values, texts)
    )


def decode_block(body: bytes) -> BlockSamples:
    """Turn a block's bytes back into samples.

    Raises:
        HistoryError: the bytes are not a block, or of a version this program does not know.

    """
    try:
        times, values, texts = _split_sections(body)
        time_us = np.asarray(standalone.simple_decompress(times), np.int64)
        value = np.asarray(standalone.simple_decompress(values), np.float64)
        return BlockSamples(time_us, value, _TEXTS.decode(texts) if texts else {})
    except (struct.error, RuntimeError, msgspec.DecodeError) as error:
        raise _damaged_block(body, error) from error


class LastTimes:
    """The times that were read last: signals of one message have the same, in the same bytes."""

    def __init__(self) -> None:
        """Have none."""
        # Of blocks that follow each other, and what they are.
        self._sections: list[bytes] = []
        self._time_us: NDArray[np.int64] | None = None

    def find_times(self, sections: list[bytes]) -> NDArray[np.int64] | None:
        """Give the times of these bytes if they are those of before; nobody may change them."""
        return self._time_us if sections == self._sections else None

    def keep_times(self, sections: list[bytes], time_us: NDArray[np.int64]) -> None:
        """Remember times until others are read."""
        self._sections, self._time_us = sections, time_us


def decode_run(
    bodies: Sequence[bytes], sizes: Sequence[int], last: LastTimes
) -> BlockSamples | None:
    """Turn blocks that follow each other into samples in one piece of memory.

    Args:
        bodies: of the blocks.
        sizes: how many samples each holds.
        last: the times that were read last, of the same channel or another one.

    Returns:
        None where one of them is no block of so many numbers, or holds texts.

    """
    value = np.empty(sum(sizes), np.float64)
    try:
        sections = [_split_sections(body) for body in bodies]
        if any(texts for _, _, texts in sections):
            return None
        times = [section for section, _, _ in sections]
        time_us = last.find_times(times)
        if time_us is None or time_us.size != value.size:
            time_us = np.empty(value.size, np.int64)
            if not _fill_column(times, sizes, time_us):
                return None
            last.keep_times(times, time_us)
        if not _fill_column([section for _, section, _ in sections], sizes, value):
            return None
    except (struct.error, RuntimeError, HistoryError):
        return None
    return BlockSamples(time_us, value, {})


def _fill_column(
    sections: Sequence[bytes], sizes: Sequence[int], column: NDArray[np.int64] | NDArray[np.float64]
) -> bool:
    """Decompress sections one after the other; tell whether each has its size."""
    first = 0
    for section, size in zip(sections, sizes, strict=True):
        done = standalone.simple_decompress_into(section, column[first : first + size])
        if done.n_processed != size or not done.finished:
            return False
        first += size
    return True


def decode_values(body: bytes) -> NDArray[np.float64]:
    """Give a block's values without its times, which takes less than half as long.

    Raises:
        HistoryError: see `decode_block`.

    """
    try:
        return np.asarray(standalone.simple_decompress(_split_sections(body)[1]), np.float64)
    except (struct.error, RuntimeError) as error:
        raise _damaged_block(body, error) from error


def _split_sections(body: bytes) -> tuple[bytes, bytes, bytes]:
    """Give the bytes of times, values and texts."""
    version, length = _HEAD.unpack_from(body)
    if version != VERSION:
        raise HistoryError(
            f"a block has version {version}, this program reads version {VERSION}",
            "open the database with the program that wrote it, or a newer one",
        )
    at = _HEAD.size + length
    times = body[_HEAD.size : at]
    (length,) = _LENGTH.unpack_from(body, at)
    at += _LENGTH.size
    return times, body[at : at + length], body[at + length :]


def _damaged_block(body: bytes, error: Exception) -> HistoryError:
    return HistoryError(f"a block of {len(body)} bytes is damaged: {error}")
