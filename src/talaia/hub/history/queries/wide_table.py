"""Several channels as one table: a row for each time stamp, a column for each channel. Pure."""

from __future__ import annotations

from functools import lru_cache
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
    shared = _shared_times(times)
    if shared is not None:
        whole, none = _all_places(shared.size), np.empty(0, np.intp)
        return Rows(shared, [whole if own_times.size else none for own_times in times], parts)
    moments, places = _merge_sorted(times)
    if not any(bool((own_times[1:] == own_times[:-1]).any()) for own_times in times):
        return Rows(moments, places, parts)
    turns = [_repeat_counts(own_times) for own_times in times]
    most = max(int(turn.max(initial=0)) for turn in turns)
    # The n-th sample of a channel at a time goes into the n-th row of that time.
    keys = [place * (most + 1) + turn for place, turn in zip(places, turns, strict=True)]
    rows, places = _merge_sorted(keys)
    return Rows(moments[rows // (most + 1)], places, parts)


def _all_places(size: int) -> NDArray[np.intp]:
    return _count_up(1 << size.bit_length())[:size]


@lru_cache(4)
def _count_up(size: int) -> NDArray[np.intp]:
    # Pieces of a file are of a few sizes.
    places = np.arange(size)
    places.flags.writeable = False
    return places


def _shared_times(times: Sequence[NDArray[np.int64]]) -> NDArray[np.int64] | None:
    """Give the times of all channels that have any; None where these differ.

    One signal has only its own, and those of one message have the same: there is nothing to merge.
    """
    first, *others = [own_times for own_times in times if own_times.size]
    # Of signals of one message they are often the same piece of memory: see `LastTimes`.
    known = {_place_of(first)}
    for own_times in others:
        if (place := _place_of(own_times)) in known:
            continue
        if not np.array_equal(own_times, first):
            return None
        known.add(place)
    return first


def _place_of(times: NDArray[np.int64]) -> tuple[int, int, tuple[int, ...]]:
    start, _ = times.__array_interface__["data"]
    return start, times.size, times.strides


def _merge_sorted(
    runs: Sequence[NDArray[np.int64]],
) -> tuple[NDArray[np.int64], list[NDArray[np.intp]]]:
    """Merge arrays that ascend; give the distinct values, and for each array where its own are.

    `numpy.unique` looks each value up in a table first, which takes thirty times as long; a stable
    sort finds the runs and merges them.
    """
    joined = np.concatenate(runs)
    order = np.argsort(joined, kind="stable")
    ordered = joined[order]
    first = np.ones(ordered.size, bool)
    np.not_equal(ordered[1:], ordered[:-1], out=first[1:])
    place = np.empty(ordered.size, np.intp)
    place[order] = np.cumsum(first) - 1
    return ordered[first], np.split(place, np.cumsum([run.size for run in runs])[:-1])


def _repeat_counts(time_us: NDArray[np.int64]) -> NDArray[np.int64]:
    """Count for each sample how many before it have the same time stamp."""
    index = np.arange(time_us.size)
    if not time_us.size:
        return index
    first = np.concatenate(([True], time_us[1:] != time_us[:-1]))
    return index - np.maximum.accumulate(np.where(first, index, 0))
