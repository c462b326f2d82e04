"""Stored samples of several signals as rows on a common step, a stretch after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from numpy.typing import NDArray

    from talaia.hub.ports import History

__all__ = ["PastRows", "read_past_rows"]

# Samples of a signal that are read at once, at the most.
_AT_ONCE = 20_000
# The shortest and the longest stretch that is read at once (µs).
_SHORTEST_US, _LONGEST_US = 1_000_000, 6 * 3_600_000_000


class PastRows(NamedTuple):
    """Rows of one stretch.

    Attributes:
        time_us: the beginnings of their steps (n,); steps in which nothing came have no row.
        values: the last one in each step of each signal, NaN where none came (n, signals).
        past_us: all up to here was read.

    """

    time_us: NDArray[np.int64]
    values: NDArray[np.float64]
    past_us: int


async def read_past_rows(
    history: History,
    site: str,
    addresses: Sequence[str],
    *,
    from_us: int,
    to_us: int,
    step_us: int,
) -> AsyncIterator[PastRows]:
    """Read a window, its end not included, a stretch after the other.

    As live, the last value in a step counts, and a step is a multiple of ``step_us`` since the
    epoch.

    Raises:
        HistoryError: the database cannot be read.

    """
    begin, end = from_us // step_us * step_us, to_us // step_us * step_us
    length = max(step_us, min(_LONGEST_US, _AT_ONCE // 2 * step_us) // step_us * step_us)
    while begin < end:
        until = min(end, begin + length)
        series = await history.read_series(site, addresses, begin, until - 1, width=_AT_ONCE // 2)
        shorter = max(step_us, length // 4 // step_us * step_us)
        if length > max(step_us, _SHORTEST_US) and not all(one.exact for one in series):
            # More came than is read at once: thinned samples would be others than those live.
            length = shorter
            continue
        yield _rows_of([(one.time_us, one.value) for one in series], begin, until, step_us)
        if max((one.time_us.size for one in series), default=0) < _AT_ONCE // 8:
            length = min(_LONGEST_US // step_us * step_us, length * 2)
        begin = until


def _rows_of(
    columns: Sequence[tuple[NDArray[np.int64], NDArray[np.float64]]],
    from_us: int,
    to_us: int,
    step_us: int,
) -> PastRows:
    steps = [(times - from_us) // step_us for times, _ in columns]
    found = np.unique(np.concatenate(steps)) if steps else np.empty(0, np.int64)
    values = np.full((found.size, len(columns)), np.nan)
    for at, (step, (_, value)) in enumerate(zip(steps, columns, strict=True)):
        # In order of time, so the last of a step is the one that stays; texts and NaN are none.
        there = np.isfinite(value)
        values[np.searchsorted(found, step[there]), at] = value[there]
    return PastRows(from_us + found * step_us, values, to_us)
