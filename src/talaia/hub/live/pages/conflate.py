"""Make samples fewer without losing what a chart must show. Pure, and whole columns at a time."""

from __future__ import annotations

import numpy as np

from talaia.wire.columns import Columns, PackedColumns, pack_columns, pick_samples

__all__ = ["conflate", "frames_of", "newest", "weight"]

# uint16, int64 and float64.
_BYTES_A_SAMPLE = 18
# A `str`, its place in the dict and the key, about.
_BYTES_A_TEXT = 120


def weight(columns: Columns) -> int:
    """Give the bytes that columns take in memory, near enough for a bound."""
    texts = columns.texts
    if not texts:
        return _BYTES_A_SAMPLE * len(columns)
    # A character takes up to four bytes.
    return _BYTES_A_SAMPLE * len(columns) + sum(_BYTES_A_TEXT + 4 * len(t) for t in texts.values())


def conflate(columns: Columns) -> Columns:
    """Keep of each channel the first, the least, the greatest and the last sample, in order."""
    # Up to four of each channel are not worth the work.
    if not len(columns) or np.bincount(columns.channel).max() <= 4:
        return columns
    channel, value = columns.channel, columns.value
    keep = np.zeros(len(columns), bool)
    # Stable: the order within a channel is that of time of arrival.
    by_channel = np.argsort(channel, kind="stable")
    ordered = channel[by_channel]
    starts = np.flatnonzero(np.r_[True, ordered[1:] != ordered[:-1]])
    ends = np.r_[starts[1:], ordered.size]
    keep[by_channel[starts]] = True
    keep[by_channel[ends - 1]] = True
    # Sorted by value within each channel NaN comes last, so the greatest stands before them.
    by_value = np.lexsort((value, channel))
    numbers = np.add.reduceat(~np.isnan(value[by_value]), starts, dtype=np.int64)
    keep[by_value[starts]] = True
    # With NaN only, the first stands for all.
    keep[by_value[starts + np.maximum(numbers, 1) - 1]] = True
    return pick_samples(columns, keep)


def newest(columns: Columns) -> Columns:
    """Keep only the last sample of each channel, in order."""
    if not len(columns):
        return columns
    keep = np.zeros(len(columns), bool)
    # The first of the reversed column is the last.
    _, at = np.unique(columns.channel[::-1], return_index=True)
    keep[len(columns) - 1 - at] = True
    return pick_samples(columns, keep)


def frames_of(columns: Columns) -> list[PackedColumns]:
    """Pack columns, cut in pieces that a batch can hold."""
    if not len(columns):
        return []
    try:
        return [pack_columns(columns)]
    except ValueError:
        # One sample always fits.
        if len(columns) == 1:
            raise
    # Halved, for neither count nor span can be told in advance; each half is packed by itself.
    half = len(columns) // 2
    first = np.zeros(len(columns), bool)
    first[:half] = True
    return [*frames_of(pick_samples(columns, first)), *frames_of(pick_samples(columns, ~first))]
