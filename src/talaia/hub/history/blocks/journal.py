"""A batch as one row of the hot journal: few bytes, quick to write and to read back.

All numbers are little-endian. A small batch's body is: version 1 (u8), bytes of a time offset
(u8: 4 or 8), count (u32), base time (i64, µs), then the columns channel (u16, index into the
catalogue), offset and value (f64), and then, if there are any, the texts as MessagePack.

A large batch is compressed, since what a commit writes is what it waits for, and what wears an SD
card out. Its samples are put in order of channels; within a channel they stay in the order in
which they came. Its body is: version 2 (u8), zero (u8), count (u32), number of channels (i64),
each channel (u16), each channel's count (u32), the length of the times (u32), the times, the
length of the values (u32), the values (both `pcodec`), and the texts as before.
"""

from __future__ import annotations

import struct

import msgspec
import numpy as np
from pcodec import ChunkConfig, DeltaSpec, standalone

from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import MAX_SPAN_US, Columns

__all__ = ["part_of", "read_row", "write_row"]

PLAIN, PACKED = 1, 2
# Below this, compressing takes longer than it saves.
_WORTH = 128
# What a row takes is written twice and deleted soon, so a little larger in a third of the time is
# better: values as they are, times by their steps, nothing else tried.
_VALUES = ChunkConfig(compression_level=0, delta_spec=DeltaSpec.no_op())
_TIMES = ChunkConfig(compression_level=0, delta_spec=DeltaSpec.try_consecutive(1))
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
        if version == PACKED and size == 0:
            return _unpack_columns(body, count, base)
        if version != PLAIN or size not in (4, 8):
            raise HistoryError(
                f"a journal row has version {version}, this program reads {PLAIN} and {PACKED}",
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
    times: bytes = standalone.simple_compress(np.ascontiguousarray(time_us), _TIMES)
    values: bytes = standalone.simple_compress(np.ascontiguousarray(value), _VALUES)
    return b"".join(
        (
            _HEAD.pack(PACKED, 0, len(columns), channels.size),
            channels.astype("<u2", copy=False).tobytes(),
            counts.astype("<u4").tobytes(),
            _LENGTH.pack(len(times)),
            times,
            _LENGTH.pack(len(values)),
            values,
            texts,
        )
    )


def _unpack_columns(body: bytes, count: int, runs: int) -> Columns:
    at = _HEAD.size
    channels = np.frombuffer(body, "<u2", runs, at)
    counts = np.frombuffer(body, "<u4", runs, at + 2 * runs)
    at += 6 * runs
    columns = []
    for _ in range(2):
        (length,) = _LENGTH.unpack_from(body, at)
        at += _LENGTH.size
        columns.append(standalone.simple_decompress(body[at : at + length]))
        at += length
    texts = _TEXTS.decode(body[at:]) if len(body) > at else {}
    times, values = np.asarray(columns[0], np.int64), np.asarray(columns[1], np.float64)
    if int(counts.sum()) != count or times.size != count or values.size != count:
        raise ValueError(f"its columns have not {count} rows")
    return Columns(np.repeat(channels, counts), times, values, texts)


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
