"""Samples as columns: the cheapest form to send, to store and to draw.

A batch holds for each sample a channel index (u16), a time as microseconds from the batch's base
(i32, so a batch spans at most 35 minutes either way), and a value (f64), each column as
little-endian bytes. Texts are few: they stand aside by position, with NaN in the value column.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time

from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "MAX_SAMPLES",
    "Columns",
    "PackedColumns",
    "join_columns",
    "pack_columns",
    "pick_samples",
    "renumber_channels",
    "slice_columns",
    "unpack_columns",
]

# A sample is 14 bytes without its text, so that the columns of a full batch stay below 1 MiB.
MAX_SAMPLES = 65_536
# What an i32 holds: 35 minutes and 47 seconds.
MAX_SPAN_US = 2**31 - 1


class Columns(NamedTuple):
    """Samples side by side; all arrays have the shape (n,).

    Attributes:
        channel: index into a list of channels both sides know.
        time_us: microseconds since the epoch, UTC.
        value: the reading; NaN where it is a text (or where the robot said NaN).
        texts: position in the batch to text.

    """

    channel: NDArray[np.uint16]
    time_us: NDArray[np.int64]
    value: NDArray[np.float64]
    texts: dict[int, str]

    def __len__(self) -> int:
        """Count the samples, not the columns."""
        return int(self.channel.size)


class PackedColumns(NamedTuple):
    """Samples as bytes, as a message carries them.

    Attributes:
        base_us: microseconds since the epoch (UTC) that the offsets count from.
        channel: u16 each, little-endian.
        offset: i32 each (µs), little-endian.
        value: f64 each, little-endian.
        texts: see `Columns`.

    """

    base_us: int
    channel: bytes
    offset: bytes
    value: bytes
    texts: dict[int, str]


class _PackedMessage(Protocol):
    """Any message with packed columns in it, and `PackedColumns` itself."""

    @property
    def base_us(self) -> int: ...
    @property
    def channel(self) -> bytes: ...
    @property
    def offset(self) -> bytes: ...
    @property
    def value(self) -> bytes: ...
    @property
    def texts(self) -> dict[int, str]: ...


def join_columns(pieces: Sequence[Columns]) -> Columns:
    """Put columns one after the other; a single one is given as it is."""
    if len(pieces) == 1:
        return pieces[0]
    if not pieces:
        return Columns(np.empty(0, np.uint16), np.empty(0, np.int64), np.empty(0, np.float64), {})
    texts: dict[int, str] = {}
    begin = 0
    for piece in pieces:
        if piece.texts:
            texts.update({begin + at: text for at, text in piece.texts.items()})
        begin += len(piece)
    return Columns(
        np.concatenate([piece.channel for piece in pieces]),
        np.concatenate([piece.time_us for piece in pieces]),
        np.concatenate([piece.value for piece in pieces]),
        texts,
    )


def slice_columns(columns: Columns, begin: int, end: int) -> Columns:
    """Give the samples from position ``begin`` to, not including, ``end``."""
    return Columns(
        columns.channel[begin:end],
        columns.time_us[begin:end],
        columns.value[begin:end],
        # A text's key is its position, which is another one in the piece.
        {at - begin: text for at, text in columns.texts.items() if begin <= at < end},
    )


def pick_samples(columns: Columns, keep: NDArray[np.bool_]) -> Columns:
    """Give the samples where ``keep`` is true; texts move to their new places."""
    texts = columns.texts
    if texts:
        # For each sample that stays its new place.
        place = np.cumsum(keep) - 1
        texts = {int(place[at]): text for at, text in texts.items() if keep[at]}
    return Columns(columns.channel[keep], columns.time_us[keep], columns.value[keep], texts)


def renumber_channels(columns: Columns, order: NDArray[np.int64]) -> Columns:
    """Give the samples with the channels numbered by another list.

    Args:
        columns: the samples.
        order: by the channel's number: its new one, or -1 for what the other list does not have.

    """
    channel = order[columns.channel]
    # The usual case: nothing is left out, so texts stay where they are.
    kept = np.flatnonzero(channel >= 0)
    if kept.size == channel.size:
        return Columns(channel.astype(np.uint16), columns.time_us, columns.value, columns.texts)
    # Only texts have to know where their sample went.
    place = {int(old): new for new, old in enumerate(kept)} if columns.texts else {}
    return Columns(
        channel[kept].astype(np.uint16),
        columns.time_us[kept],
        columns.value[kept],
        {place[at]: text for at, text in columns.texts.items() if at in place},
    )


def pack_columns(columns: Columns) -> PackedColumns:
    """Turn columns into the bytes of a message.

    Raises:
        ValueError: more samples than `MAX_SAMPLES`, or times further apart than the offset holds;
            the caller cuts the batch.

    """
    count = len(columns)
    if count > MAX_SAMPLES:
        raise ValueError(f"{count} samples do not fit a batch of {MAX_SAMPLES}")
    # The first sample's own time: samples come nearly in order, so that offsets are small.
    base = int(columns.time_us[0]) if count else 0
    offset = columns.time_us - base
    narrow = offset.astype("<i4")
    # NumPy's cast wraps round without a word. To compare is quicker than to find the extremes of a
    # few samples, of which hundreds of batches a second are made.
    if np.count_nonzero(narrow != offset):
        raise ValueError("the batch spans more time than its offsets hold")
    return PackedColumns(
        base,
        columns.channel.astype("<u2", copy=False).tobytes(),
        narrow.tobytes(),
        columns.value.astype("<f8", copy=False).tobytes(),
        columns.texts,
    )


def unpack_columns(packed: _PackedMessage) -> Columns:
    """Turn a message's bytes back into columns. The arrays are read-only views where possible.

    Raises:
        PeerError: the columns are not of one length, or are too long.

    """
    channel, offset, value, texts = packed.channel, packed.offset, packed.value, packed.texts
    # From the shortest type's column; all three must tell the same number of samples. `frombuffer`
    # would raise an error of its own for half a sample, which is no reason to close a link with.
    count = len(channel) // 2
    if len(channel) != 2 * count or len(offset) != 4 * count or len(value) != 8 * count:
        raise PeerError(
            f"columns of unequal length: {len(channel)}, {len(offset)} and {len(value)} bytes"
        )
    if count > MAX_SAMPLES:
        raise PeerError(f"{count} samples in one batch; at most {MAX_SAMPLES}", 1009)
    # A peer's positions: a negative one would count from the end.
    if texts and any(not 0 <= position < count for position in texts):
        raise PeerError("a text stands outside its batch")
    # With an offset added it must still be an i64.
    if not -(2**62) < packed.base_us < 2**62:
        raise PeerError("the batch's base time is out of range")
    return Columns(
        np.frombuffer(channel, "<u2"),
        # Widened before the base is added: an i32 would overflow.
        np.frombuffer(offset, "<i4").astype(np.int64) + packed.base_us,
        np.frombuffer(value, "<f8"),
        texts,
    )
