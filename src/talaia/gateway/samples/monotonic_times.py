"""Times of samples that tell their order. Pure.

What a channel said first has the earlier time, and no two of its samples have the same: so the
order in which the robot said them is the order of their times, whichever way they reach the hub.
A clock that is set back by less than `STEP_BACK_US`, or two readings of it that were mixed up on
the way through threads and queues, are mended by microseconds. A clock that is set back by more
is another time, which is taken as it is.
"""

from __future__ import annotations

import numpy as np

from talaia.wire.columns import Columns

__all__ = ["STEP_BACK_US", "MonotonicTimes"]

STEP_BACK_US = 1_000_000
# As many as fit the samples' column of channels.
_CHANNELS = 65_536
_NEVER = -(2**62)


class MonotonicTimes:
    """Knows the last time of each channel."""

    def __init__(self) -> None:
        """Begin with none."""
        self._last = np.full(_CHANNELS, _NEVER, np.int64)

    def make_monotonic(self, columns: Columns) -> Columns:
        """Give the samples with times that rise for each channel; the same ones if they do."""
        if not len(columns):
            return columns
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
        return Columns(columns.channel, mended, columns.value, columns.texts)
