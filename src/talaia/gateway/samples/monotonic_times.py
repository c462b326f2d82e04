"""Times of samples that tell their order. Pure.

What a channel said first has the earlier time, and no two of its samples have the same: so the
order in which the robot said them is the order of their times, whichever way they reach the hub.
A clock that is set back by less than `STEP_BACK_US`, or two readings of it that were mixed up on
the way through threads and queues, are mended by microseconds. A clock that is set back by more
is another time, which is taken as it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["STEP_BACK_US", "MonotonicTimes"]

STEP_BACK_US = 1_000_000
# As many as fit the samples' column of channels.
_CHANNELS = 65_536
_NEVER = -(2**62)
# Below this many samples a loop costs less than NumPy's calls.
_FEW = 64


class MonotonicTimes:
    """Knows the last time of each channel."""

    def __init__(self) -> None:
        """Begin with none."""
        self._last = np.full(_CHANNELS, _NEVER, np.int64)
        # The same ones, read and written one by one at a third of the cost.
        self._singly = memoryview(self._last.data)

    def make_monotonic(self, columns: Columns) -> Columns:
        """Give the samples with times that rise for each channel; the same ones if they do."""
        if len(columns) < _FEW:
            return self._make_few_monotonic(columns)
        order = np.argsort(columns.channel, kind="stable")
        channel, time_us = columns.channel[order], columns.time_us[order]
        starts = np.concatenate(([True], channel[1:] != channel[:-1]))
        before = np.empty_like(time_us)
        before[1:] = time_us[:-1]
        before[starts] = self._last[channel[starts]]
        wrong = time_us <= before
        if not wrong.any():
            self._last[channel] = time_us
            return columns
        mended = columns.time_us.copy()
        bad = np.isin(channel, channel[wrong])
        self._last[channel[~bad]] = time_us[~bad]
        for at in order[bad].tolist():
            number, told = int(columns.channel[at]), int(mended[at])
            last = int(self._last[number])
            if told <= last < told + STEP_BACK_US:
                told = last + 1
            mended[at] = self._last[number] = told
        return _with_times(columns, mended)

    def _make_few_monotonic(self, columns: Columns) -> Columns:
        last, mended = self._singly, None
        numbers, times = columns.channel.tolist(), columns.time_us.tolist()
        for at, (number, told) in enumerate(zip(numbers, times, strict=True)):
            before = last[number]
            if told > before or before >= told + STEP_BACK_US:
                last[number] = told
                continue
            if mended is None:
                mended = columns.time_us.copy()
            mended[at] = last[number] = before + 1
        return columns if mended is None else _with_times(columns, mended)


def _with_times(columns: Columns, time_us: NDArray[np.int64]) -> Columns:
    return Columns(columns.channel, time_us, columns.value, columns.texts)
