"""A batch as one row of the hot journal: few bytes, quick to write and to read back.

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

Rows of version 3 that follow each other are made one of version 4, in the order in which samples
came: the head as in version 2 with zero channels, each sample's channel, the times and the values,
each compressed and with its length, and the texts.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from pcodec import ChunkConfig, DeltaSpec, standalone

from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import MAX_SPAN_US, Columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["MANY_CHANNELS", "merge_columns", "part_of", "read_row", "write_row"]

PLAIN, PACKED, MANY_CHANNELS, MERGED = 1, 2, 3, 4
# Below this, compressing takes longer than it saves.
_WORTH = 128
# From so many channels on, compressing their numbers saves more bytes than its two calls add.
_MANY = 64
# What a row takes is written twice and deleted soon, so a little larger in a third of the time is
# better: values as they are, times by their steps, nothing else tried.
_VALUES = ChunkConfig(compression_level=0, delta_spec=DeltaSpec.no_op())
_TIMES = ChunkConfig(compression_level=0, delta_spec=DeltaSpec.try_consecutive(1))
# A merged row stays for long, and nobody waits for it.
_MERGED = ChunkConfig(compression_level=4)
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
        if version == MERGED and size == 0:
            return _unpack_merged(body, count)
        if version in (PACKED, MANY_CHANNELS) and size == 0:
            return _unpack_columns(body, count, base, packed=version == MANY_CHANNELS)
        if version != PLAIN or size not in (4, 8):
            raise HistoryError(
                f"a journal row has version {version}, this program reads {PLAIN}, {PACKED}, "
                f"{MANY_CHANNELS} and {MERGED}",
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


def merge_columns(parts: Sequence[Columns]) -> bytes:
    """Pack batches one after the other, as one; each has at least one sample."""
    columns = (
        np.concatenate([part.channel.astype(np.uint16, copy=False) for part in parts]),
        np.concatenate([part.time_us for part in parts]),
        np.concatenate([part.value for part in parts]),
    )
    texts, at = {}, 0
    for part in parts:
        texts.update({at + position: text for position, text in part.texts.items()})
        at += len(part)
    head = _HEAD.pack(MERGED, 0, at, 0)
    packed = [_with_length(standalone.simple_compress(column, _MERGED)) for column in columns]
    return b"".join((head, *packed, msgspec.msgpack.encode(texts) if texts else b""))


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


def _pack_columns(columns: Columns) -> bytes:
    channel, time_us, value = columns.channel, columns.time_us, columns.value
    texts = b""
    if (channel[1:] < channel[:-1]).any():
        order = np.argsort(channel, kind="stable")
        channel, time_us, value = channel[order], time_us[order], value[order]
        if columns.texts:
            place = np.empty(order.size, np.int64)
            place[order] = np.arange(order.size)
            moved = {int(place[at]): text for at, text in columns.texts.items()}
            texts = msgspec.msgpack.encode(moved)
    elif columns.texts:
        texts = msgspec.msgpack.encode(columns.texts)
    starts = np.flatnonzero(np.concatenate(([True], channel[1:] != channel[:-1])))
    channels, counts = channel[starts], np.diff(starts, append=channel.size)
    times = _with_length(standalone.simple_compress(np.ascontiguousarray(time_us), _TIMES))
    values = _with_length(standalone.simple_compress(np.ascontiguousarray(value), _VALUES))
    if channels.size < _MANY:
        version = PACKED
        runs = channels.astype("<u2", copy=False).tobytes() + counts.astype("<u4").tobytes()
    else:
        version = MANY_CHANNELS
        runs = b"".join(
            _with_length(standalone.simple_compress(column, _TIMES))
            for column in (channels.astype(np.uint16, copy=False), counts.astype(np.uint32))
        )
    head = _HEAD.pack(version, 0, len(columns), channels.size)
    return b"".join((head, runs, times, values, texts))


def _with_length(compressed: bytes) -> bytes:
    return _LENGTH.pack(len(compressed)) + compressed


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
