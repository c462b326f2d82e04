"""A batch as one row of the hot journal: bytes that are quick to write and to read back.

The body is: version (u8), bytes of a time offset (u8: 4 or 8), count (u32), base time (i64, µs),
then the columns channel (u16, index into the catalogue), offset and value (f64), and then, if
there are any, the texts as MessagePack. All numbers are little-endian.
"""

from __future__ import annotations

import struct

import msgspec
import numpy as np

from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import MAX_SPAN_US, Columns

__all__ = ["part_of", "read_row", "write_row"]

VERSION = 1
_HEAD = struct.Struct("<BBIq")
_TEXTS = msgspec.msgpack.Decoder(dict[int, str])


def write_row(columns: Columns) -> bytes:
    """Pack a batch that has at least one sample."""
    base = int(columns.time_us[0])
    # Samples with a wrong clock stand decades apart: take eight bytes for all, and lose none.
    far = max(int(columns.time_us.max()) - base, base - int(columns.time_us.min()))
    wide = far > MAX_SPAN_US
    offset = columns.time_us - base
    return b"".join(
        (
            _HEAD.pack(VERSION, 8 if wide else 4, len(columns), base),
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
        if version != VERSION or size not in (4, 8):
            raise HistoryError(
                f"a journal row has version {version}, this program reads version {VERSION}",
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
    except (struct.error, ValueError) as error:  # msgspec's errors are ValueErrors
        raise HistoryError(f"a journal row of {len(body)} bytes is damaged: {error}") from error
    return Columns(channel, offset.astype(np.int64) + base, value, texts)


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
