"""Several channels as one table: a row for each time stamp, a column for each channel. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time

from talaia.hub.history.blocks.block import EMPTY, BlockSamples, concatenate_samples

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.hub.history.queries.sample_stream import SampleChunk

__all__ = ["Rows", "join_channels"]

_NEVER = 2**63 - 1


class Rows(NamedTuple):
    """Rows of a table, in order of time.

    Attributes:
        time_us: shape (n,), microseconds since the epoch.
        places: for each channel, in which rows it has a sample; shape (k,), ascending.
        parts: for each channel, its samples; as many as it has places.

    """

    time_us: NDArray[np.int64]
    places: list[NDArray[np.intp]]
    parts: list[BlockSamples]


def join_channels(flows: Sequence[Iterator[SampleChunk]]) -> Iterator[Rows]:
    """Join channels by time, a piece at a time.

    Samples of several channels with one time stamp share a row. Where a channel has several
    samples with one time stamp, that time has as many rows.
    """
    held = [EMPTY for _ in flows]
    past = [-_NEVER for _ in flows]
    while min(past, default=_NEVER) < _NEVER:
        until = min(past)
        for at, stretches in enumerate(flows):
            if past[at] == until:
                stretch = next(stretches, None)
                past[at] = stretch.past_us if stretch is not None else _NEVER
                if stretch is not None:
                    held[at] = concatenate_samples([held[at], stretch.samples])
        until = min(past)
        ready = [samples.between_times(-_NEVER, until - 1) for samples in held]
        held = [samples.between_times(until, _NEVER) for samples in held]
        if any(samples.time_us.size for samples in ready):
            yield _join_parts(ready)


def _join_parts(parts: list[BlockSamples]) -> Rows:
    times = [part.time_us for part in parts]
    turns = [_repeat_counts(own_times) for own_times in times]
    most = max(int(turn.max(initial=0)) for turn in turns)
    if most == 0:
        time_us = np.unique(np.concatenate(times))
        return Rows(time_us, [np.searchsorted(time_us, own_times) for own_times in times], parts)
    # The n-th sample of a channel at a time goes into the n-th row of that time.
    rank = np.unique(np.concatenate(times))
    keys = [
        np.searchsorted(rank, own_times) * (most + 1) + turn
        for own_times, turn in zip(times, turns, strict=True)
    ]
    rows = np.unique(np.concatenate(keys))
    return Rows(rank[rows // (most + 1)], [np.searchsorted(rows, key) for key in keys], parts)


def _repeat_counts(time_us: NDArray[np.int64]) -> NDArray[np.int64]:
    """Count for each sample how many before it have the same time stamp."""
    index = np.arange(time_us.size)
    if not time_us.size:
        return index
    first = np.concatenate(([True], time_us[1:] != time_us[:-1]))
    return index - np.maximum.accumulate(np.where(first, index, 0))
