"""A batch as one row of the hot journal: few bytes, quick to write and to read back.

Long, because all ways in which a batch may stand there are read together.

All numbers are little-endian. A small batch's body is: version 1 (u8), bytes of a time offset
(u8: 4 or 8), count (u32), base time (i64, µs), then the columns channel (u16, index into the
catalogue), offset and value (f64), and then, if there are any, the texts as MessagePack.

A large batch is compressed, since what a commit writes is what it waits for, and what wears an SD
card out. Its samples are put in order of channels; within a channel they stay in the order in
which they came. Its body is: version 2 (u8), zero (u8), count (u32), number of channels (i64),
each channel (u16), each channel's count (u32), the length of the times (u32), the times, the
length of the values (u32), the values (both `pcodec`), and the texts as before.

With many channels of few samples each, the channels and their counts would be most of it. Then the
body is of version 3, whose channels and counts are compressed like the times, with their lengths.

Rows of version 3 that follow each other are made one of version 5: the head as in version 2, with
the number of rows in place of that of channels, and the bodies of the rows, each behind its length
(u32). Before, they were made one of version 4, which is still read: the head as in version 2 with
zero channels, each sample's channel, the times and the values, each compressed and with its length,
and the texts.
"""

from __future__ import annotations

import struct
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time
from pcodec import ChunkConfig, DeltaSpec, standalone

from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import MAX_SPAN_US, Columns, join_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "MANY_CHANNELS",
    "JournalSamples",
    "merge_bodies",
    "part_of",
    "read_row",
    "read_rows",
    "write_row",
]

PLAIN, PACKED, MANY_CHANNELS, MERGED, JOINED = 1, 2, 3, 4, 5
# Below this, compressing takes longer than it saves.
_WORTH = 128
# From so many channels on, compressing their numbers saves more bytes than its two calls add.
_MANY = 64
# What a row takes is written twice and deleted soon, so a little larger in a third of the time is
# better: values as they are, times by their steps, nothing else tried.
_VALUES = ChunkConfig(compression_level=0, delta_spec=DeltaSpec.no_op())
_TIMES = ChunkConfig(compression_level=0, delta_spec=DeltaSpec.try_consecutive(1))
# Rows of many channels stay for long, until each has a block's worth of samples.
_KEPT_VALUES = ChunkConfig(compression_level=4, delta_spec=DeltaSpec.no_op())
_KEPT_TIMES = ChunkConfig(compression_level=4, delta_spec=DeltaSpec.try_consecutive(1))
# Of fewer samples of each channel, steps are mostly those from one channel to the next: the times
# themselves, which lie close together, take fewer bits.
_STEPS_OF = 3
_KEPT_MOMENTS = ChunkConfig(compression_level=4, delta_spec=DeltaSpec.no_op())
_LENGTH = struct.Struct("<I")
_HEAD = struct.Struct("<BBIq")
_TEXTS = msgspec.msgpack.Decoder(dict[int, str])


def write_row(columns: Columns) -> bytes:
    """Pack a batch that has at least one sample."""
    if len(columns) >= _WORTH:
        return _pack_columns(columns)
    base = int(columns.time_us[0])
    # Samples with a wrong clock stand decades apart: take eight bytes for all, and lose none.
    far = max(int(columns.time_us.max()) - base, base - int(columns.time_us.min()))
    wide = far > MAX_SPAN_US
    offset = columns.time_us - base
    return b"".join(
        (
            _HEAD.pack(PLAIN, 8 if wide else 4, len(columns), base),
            columns.channel.astype("<u2", copy=False).tobytes(),
            offset.astype("<i8" if wide else "<i4").tobytes(),
            columns.value.astype("<f8", copy=False).tobytes(),
            msgspec.msgpack.encode(columns.texts) if columns.texts else b"",
        )
    )


def read_row(body: bytes) -> Columns:
    """Unpack a batch.

    Raises:
        HistoryError: the bytes are not a batch, or of a version this program does not know.

    """
    try:
        version, size, count, base = _HEAD.unpack_from(body)
        if version == JOINED and size == 0:
            return _split_joined(body, count, base)
        if version == MERGED and size == 0:
            return _unpack_merged(body, count)
        if version in (PACKED, MANY_CHANNELS) and size == 0:
            return _unpack_columns(body, count, base, packed=version == MANY_CHANNELS)
        if version != PLAIN or size not in (4, 8):
            raise HistoryError(
                f"a journal row has version {version}, this program reads {PLAIN}, {PACKED}, "
                f"{MANY_CHANNELS}, {MERGED} and {JOINED}",
                "open the database with the program that wrote it, or a newer one",
            )
        at = _HEAD.size
        channel = np.frombuffer(body, "<u2", count, at)
        at += 2 * count
        offset = np.frombuffer(body, f"<i{size}", count, at)
        at += size * count
        value = np.frombuffer(body, "<f8", count, at)
        at += 8 * count
        texts = _TEXTS.decode(body[at:]) if len(body) > at else {}
    # pcodec's are RuntimeErrors.
    except (struct.error, ValueError, RuntimeError) as error:  # msgspec's errors are ValueErrors
        raise HistoryError(f"a journal row of {len(body)} bytes is damaged: {error}") from error
    return Columns(channel, offset.astype(np.int64) + base, value, texts)


def merge_bodies(bodies: Sequence[bytes], count: int) -> bytes:
    """Put packed batches one after the other, as one row of ``count`` samples in all."""
    head = _HEAD.pack(JOINED, 0, count, len(bodies))
    return b"".join((head, *map(_with_length, bodies)))


def _split_joined(body: bytes, count: int, rows: int) -> Columns:
    at = _HEAD.size
    parts = []
    for _ in range(rows):
        (length,) = _LENGTH.unpack_from(body, at)
        at += _LENGTH.size
        part = body[at : at + length]
        if len(part) != length or part[:1] != bytes((MANY_CHANNELS,)):
            raise ValueError("a part of it is cut off, or no row of many channels")
        parts.append(read_row(part))
        at += length
    whole = join_columns(parts)
    if len(whole) != count or at != len(body):
        raise ValueError(f"its parts have {len(whole)} samples and {at} bytes")
    return whole


def _unpack_merged(body: bytes, count: int) -> Columns:
    at = _HEAD.size
    channels, at = _read_compressed(body, at)
    times, at = _read_compressed(body, at)
    values, at = _read_compressed(body, at)
    if (channels.size, times.size, values.size) != (count, count, count):
        raise ValueError(f"its columns have not {count} rows")
    return Columns(
        channels.astype(np.uint16, copy=False),
        times.astype(np.int64, copy=False),
        values.astype(np.float64, copy=False),
        _TEXTS.decode(body[at:]) if len(body) > at else {},
    )


class JournalSamples(NamedTuple):
    """The samples of many rows, one row after the other.

    Attributes:
        columns: of all rows; n samples.
        sizes: how many each row has, of shape (rows,); 0 for a damaged one.
        damaged: what is wrong with a row, by its place among the rows.

    """

    columns: Columns
    sizes: NDArray[np.int64]
    damaged: dict[int, HistoryError]


def read_rows(bodies: Sequence[bytes]) -> JournalSamples:
    """Unpack many batches: small ones together, for each alone takes longer than its samples."""
    sizes = np.zeros(len(bodies), np.int64)
    damaged: dict[int, HistoryError] = {}
    parts: list[Columns] = []
    plain = _PlainRows()
    for at, body in enumerate(bodies):
        count = plain.add_row(body)
        if not count:
            # It is read by itself, and stands behind those before it.
            parts.append(plain.read_columns())
            plain = _PlainRows()
            try:
                part = read_row(body)
            except HistoryError as error:
                damaged[at] = error
                continue
            parts.append(part)
            count = len(part)
        sizes[at] = count
    return JournalSamples(join_columns([*parts, plain.read_columns()]), sizes, damaged)


class _PlainRows:
    """Rows of the commonest kind: a few numbers with times that are near to each other."""

    def __init__(self) -> None:
        self._counts: list[int] = []
        self._bases: list[int] = []
        # The three columns of each.
        self._channels: list[bytes] = []
        self._offsets: list[bytes] = []
        self._values: list[bytes] = []

    def add_row(self, body: bytes) -> int:
        """Take a row and give its number of samples; 0 if it is of another kind, or damaged."""
        if len(body) <= _HEAD.size:
            return 0
        version, size, count, base = _HEAD.unpack_from(body)
        offsets = _HEAD.size + 2 * count
        values = offsets + 4 * count
        if version != PLAIN or size != 4 or len(body) != values + 8 * count:
            return 0
        self._counts.append(count)
        self._bases.append(base)
        self._channels.append(body[_HEAD.size : offsets])
        self._offsets.append(body[offsets:values])
        self._values.append(body[values:])
        return int(count)

    def read_columns(self) -> Columns:
        """Give the samples of all."""
        base = np.repeat(np.array(self._bases, np.int64), self._counts)
        return Columns(
            np.frombuffer(b"".join(self._channels), "<u2"),
            np.frombuffer(b"".join(self._offsets), "<i4") + base,
            np.frombuffer(b"".join(self._values), "<f8"),
            {},
        )


def _pack_columns(columns: Columns) -> bytes:
    channel, time_us, value = columns.channel, columns.time_us, columns.value
    texts = b""
    # Each has one sample, as in most batches of many slow channels: there is nothing to count.
    is_single = bool((channel[1:] > channel[:-1]).all())
    if not is_single and (channel[1:] < channel[:-1]).any():
        order = np.argsort(channel, kind="stable")
        channel, time_us, value = channel[order], time_us[order], value[order]
        if columns.texts:
            place = np.empty(order.size, np.int64)
            place[order] = np.arange(order.size)
            moved = {int(place[at]): text for at, text in columns.texts.items()}
            texts = msgspec.msgpack.encode(moved)
    elif columns.texts:
        texts = msgspec.msgpack.encode(columns.texts)
    if is_single:
        channels, counts = channel, np.ones(channel.size, np.int64)
    else:
        ends = np.append(np.flatnonzero(channel[1:] != channel[:-1]) + 1, channel.size)
        channels, counts = channel[ends - 1], ends.copy()
        counts[1:] -= ends[:-1]
    if channels.size < _MANY:
        version, configs = PACKED, (_TIMES, _VALUES)
        runs = channels.astype("<u2", copy=False).tobytes() + counts.astype("<u4").tobytes()
    else:
        has_steps = channel.size >= _STEPS_OF * channels.size
        version = MANY_CHANNELS
        configs = (_KEPT_TIMES if has_steps else _KEPT_MOMENTS, _KEPT_VALUES)
        runs = _pack_runs(
            channels.astype(np.uint16, copy=False).tobytes(), counts.astype(np.uint32).tobytes()
        )
    head = _HEAD.pack(version, 0, len(columns), channels.size)
    times, values = _compress(time_us, configs[0]), _compress(value, configs[1])
    return b"".join((head, runs, times, values, texts))


@lru_cache(16)
def _pack_runs(channels: bytes, counts: bytes) -> bytes:
    """Pack the channels of a row and their counts: of a gateway they are often those of before."""
    columns = np.frombuffer(channels, np.uint16), np.frombuffer(counts, np.uint32)
    return b"".join(_compress(column, _TIMES) for column in columns)


def _compress(column: NDArray[Any], config: ChunkConfig) -> bytes:
    return _with_length(standalone.simple_compress(np.ascontiguousarray(column), config))


def _with_length(packed: bytes) -> bytes:
    return _LENGTH.pack(len(packed)) + packed


def _unpack_columns(body: bytes, count: int, runs: int, *, packed: bool) -> Columns:
    at = _HEAD.size
    if packed:
        channels, at = _read_compressed(body, at)
        counts, at = _read_compressed(body, at)
    else:
        channels = np.frombuffer(body, "<u2", runs, at)
        counts = np.frombuffer(body, "<u4", runs, at + 2 * runs)
        at += 6 * runs
    times, at = _read_compressed(body, at)
    values, at = _read_compressed(body, at)
    texts = _TEXTS.decode(body[at:]) if len(body) > at else {}
    sizes = (channels.size, counts.size, times.size, values.size)
    if sizes != (runs, runs, count, count) or int(counts.sum()) != count:
        raise ValueError(f"its columns have not {count} rows")
    channels = channels.astype(np.uint16, copy=False)
    return Columns(
        np.repeat(channels, counts), times.astype(np.int64), values.astype(np.float64), texts
    )


def _read_compressed(body: bytes, at: int) -> tuple[NDArray[Any], int]:
    """Give a compressed column, of any type, and where what follows it begins."""
    (length,) = _LENGTH.unpack_from(body, at)
    at += _LENGTH.size
    column = standalone.simple_decompress(body[at : at + length])
    return np.asarray(column), at + length


def part_of(columns: Columns, first: int, past: int) -> Columns:
    """Keep the positions from ``first`` up to ``past``."""
    if first == 0 and past == len(columns):
        return columns
    return Columns(
        columns.channel[first:past],
        columns.time_us[first:past],
        columns.value[first:past],
        {p - first: text for p, text in columns.texts.items() if first <= p < past},
    )
