"""A segment that must wait for long takes less room: batches joined, columns deflated. Pure.

Bytes of equal weight are put side by side before they are deflated, since the high bytes of
neighbouring times and values are alike. A packed record holds several frames, each small enough
not to stand before a driving frame on a slow uplink.
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.gateway.spool.segment import RecordKind, SampleRecord
from talaia.wire.columns import Columns, pack_columns, slice_columns, unpack_columns
from talaia.wire.errors import PeerError
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

__all__ = ["FRAME_SAMPLES", "GROUP_SAMPLES", "pack_records", "unpack_record"]

# Samples of one frame when it is given out again; see the module.
FRAME_SAMPLES = 1024
# Samples of one packed record: what is damaged with it, and what is held in memory to read it.
GROUP_SAMPLES = 16 * FRAME_SAMPLES
# The fastest: the bytes that carry noise stay as they are at any level.
_LEVEL = 1
# Of an inflated record; a damaged one must not be able to fill the memory.
_MOST_BYTES = 16 * 1024 * 1024


class _Group(msgspec.Struct, frozen=True, array_like=True):
    """Columns of the samples from ``first`` on, each shuffled; ``delta`` are steps in time."""

    boot: str  # Of the run that heard them.
    catalogue: str
    first: int  # Sequence number of the first sample.
    base_us: int  # The first sample's time (µs, UTC); `delta` counts on from it.
    channel: bytes  # u16 each.
    delta: bytes  # i64 each: the wall clock may jump further than 32 bits hold.
    value: bytes  # f64 each; NaN where a text stands.
    texts: dict[int, str]  # By position in the group, not in a batch.


_encoder = msgspec.msgpack.Encoder()
_decoder = msgspec.msgpack.Decoder(_Group)


def pack_records(kept: Iterable[SampleRecord]) -> Iterator[SampleRecord]:
    """Pack batches of samples that follow each other; others start a new group.

    A batch that cannot be read is passed on as it is.
    """
    group: list[tuple[SampleBatch, Columns]] = []
    count = 0
    for record in kept:
        frame = _frame_of(record)
        if frame is None:
            # What it passes over ends the group: records must come out in the order they went in.
            yield from _close_group(group)
            group, count = [], 0
            yield record
            continue
        samples, columns = frame
        if group and (
            not _follows_batch(group[-1], samples) or count + len(columns) > GROUP_SAMPLES
        ):
            yield from _close_group(group)
            group, count = [], 0
        group.append((samples, columns))
        count += len(columns)
    yield from _close_group(group)


def _frame_of(record: SampleRecord) -> tuple[SampleBatch, Columns] | None:
    if record.kind != RecordKind.SAMPLES:
        return None
    try:
        frame = LINK_FROM_GATEWAY.decode(record.body)
        # Such a batch has a channel list of its own, and a group has room for one only.
        if not isinstance(frame, SampleBatch) or frame.addresses:
            return None
        columns = unpack_columns(frame)
    # Passed on as it is: if it cannot be read, its gap is told when it is sent.
    except PeerError:
        return None
    # A body that does not fit its head is not joined with others, or numbers would shift.
    return (frame, columns) if frame.first == record.first and len(columns) else None


def _follows_batch(last: tuple[SampleBatch, Columns], frame: SampleBatch) -> bool:
    before, columns = last
    # Run, channel list and number must go on: a group names each only once.
    return (before.boot, before.catalogue, before.first + len(columns)) == (
        frame.boot,
        frame.catalogue,
        frame.first,
    )


def _close_group(group: list[tuple[SampleBatch, Columns]]) -> Iterator[SampleRecord]:
    if not group:
        return
    first = group[0][0]
    time_us = np.concatenate([columns.time_us for _, columns in group])
    texts: dict[int, str] = {}
    at = 0
    for _, columns in group:
        # Positions of texts count from the group's begin.
        texts.update({at + position: text for position, text in columns.texts.items()})
        at += len(columns)
    body = _Group(
        first.boot,
        first.catalogue,
        first.first,
        int(time_us[0]),
        _shuffle_bytes(np.concatenate([columns.channel for _, columns in group]).astype("<u2")),
        # Steps from sample to sample are small and alike, and whole times are not.
        _shuffle_bytes(np.diff(time_us, prepend=time_us[0]).astype("<i8")),
        _shuffle_bytes(np.concatenate([columns.value for _, columns in group]).astype("<f8")),
        texts,
    )
    # Earliest and latest: the first sample need not be the earliest.
    yield SampleRecord(
        first.first,
        at,
        int(time_us.min()),
        int(time_us.max()),
        zlib.compress(_encoder.encode(body), _LEVEL),
        RecordKind.PACKED,
    )


def unpack_record(record: SampleRecord) -> list[SampleRecord]:
    """Give a packed record's batches, and any other as it is.

    Raises:
        PeerError: it cannot be read.

    """
    if record.kind != RecordKind.PACKED:
        return [record]
    # An object, not `zlib.decompress`: only it can stop at a bound.
    inflate = zlib.decompressobj()
    try:
        group = _decoder.decode(inflate.decompress(record.body, _MOST_BYTES))
        # Not at its end: either cut off, or larger than the bound.
        if not inflate.eof:
            raise PeerError("a packed record that ends too early, or is too large")
    except (zlib.error, msgspec.DecodeError) as error:
        raise PeerError(f"a packed record that cannot be read: {error}") from error
    count = record.samples
    channel = _in_order(group.channel, "<u2", count)
    # The first step is 0, so the sum begins at `base_us`.
    time_us = group.base_us + np.cumsum(_in_order(group.delta, "<i8", count))
    value = _in_order(group.value, "<f8", count)
    columns = Columns(channel, time_us, value, group.texts)
    return [
        batch
        for begin in range(0, count, FRAME_SAMPLES)
        for batch in _encode_batches(
            group,
            group.first + begin,
            slice_columns(columns, begin, begin + FRAME_SAMPLES),
        )
    ]


def _encode_batches(group: _Group, first: int, columns: Columns) -> list[SampleRecord]:
    """Encode columns as one frame, or as two where the wall clock jumped within them."""
    try:
        packed = pack_columns(columns)
    except ValueError:
        # Halved until it fits; a single sample always does, so this ends.
        middle = len(columns) // 2
        head, tail = slice_columns(columns, 0, middle), slice_columns(columns, middle, len(columns))
        return [*_encode_batches(group, first, head), *_encode_batches(group, first + middle, tail)]
    frame = SampleBatch(
        boot=group.boot,
        first=first,
        catalogue=group.catalogue,
        base_us=packed.base_us,
        channel=packed.channel,
        offset=packed.offset,
        value=packed.value,
        texts=packed.texts,
    )
    low, high = int(columns.time_us.min()), int(columns.time_us.max())
    return [SampleRecord(first, len(columns), low, high, LINK_FROM_GATEWAY.encode(frame))]


def _shuffle_bytes(column: np.ndarray) -> bytes:
    # One row for each byte of weight: all low bytes, then the next ones, up to the high bytes.
    return column.view(np.uint8).reshape(-1, column.itemsize).T.tobytes()


def _in_order(data: bytes, kind: str, count: int) -> np.ndarray:
    size = np.dtype(kind).itemsize
    # Checked before `reshape`, whose error would be no `PeerError`.
    if len(data) != count * size:
        raise PeerError(f"a packed column of {len(data)} bytes for {count} samples")
    # A copy, for `view` wants the bytes of each value side by side again.
    return np.frombuffer(data, np.uint8).reshape(size, count).T.copy().view(kind).ravel()
