"""The newest sample of every channel of a site, with the moment it arrived."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.clock import SECOND
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.wire.newest import NewestSamples

__all__ = ["Latest"]

# Before every moment of the monotonic clock: nothing was heard.
_NEVER = np.iinfo(np.int64).min
# What is under way is a little older when it comes.
_SLACK_NS = 5 * SECOND


class Latest:
    """One place for each channel; arrays have the shape (channels,)."""

    def __init__(self, channels: int) -> None:
        """Start with nothing known."""
        # NaN may be a sample too: whether there is one is told by `arrived_ns`.
        self.value = np.full(channels, np.nan)
        # When it was measured (µs, UTC), by the gateway's clock.
        self.time_us = np.zeros(channels, np.int64)
        # When it came here (monotonic ns), by which it ages.
        self.arrived_ns = np.full(channels, _NEVER, np.int64)
        # By channel, of channels that say texts.
        self.texts: dict[int, str] = {}
        # Of which run the sample is, and one past a number of that run which it does not exceed;
        # 0 where that is not known.
        self._run = np.zeros(channels, np.int64)
        self._end = np.zeros(channels, np.int64)
        # Numbers of runs by their names, from 1 on, for arrays hold no names; 0: no run.
        self._runs: dict[str, int] = {}

    def update_values(self, columns: Columns, now_ns: int, boot: str = "", end: int = 0) -> None:
        """Take a live batch; of several samples of a channel the last in the batch counts.

        Args:
            columns: the batch.
            now_ns: when it came (monotonic).
            boot: its run, where it has one.
            end: one past its last number there.

        """
        channel = columns.channel
        # Of a channel that comes twice numpy keeps the last value that is assigned.
        self._run[channel] = self._run_number(boot)
        self._end[channel] = end
        self.value[channel] = columns.value
        self.time_us[channel] = columns.time_us
        self.arrived_ns[channel] = now_ns
        for at, text in columns.texts.items():
            self.texts[int(channel[at])] = text

    def newer_samples(
        self, told: NewestSamples, boot: str, now_ns: int, *, current: bool
    ) -> NDArray[np.bool_]:
        """Tell which samples that a gateway says are its newest are newer than what is known.

        Within a run the numbers decide. Between runs the present one has the word, unless what it
        says was heard clearly before what came from elsewhere; of a former one the times decide.

        Args:
            told: by the same channels.
            boot: their run.
            now_ns: now (monotonic).
            current: it is the run that is linked.

        Returns:
            True for each that is newer (n,).

        """
        channel = told.columns.channel
        run, arrived = self._run[channel], self.arrived_ns[channel]
        # Without a run there are no numbers to compare.
        same = (run == self._run_number(boot)) & (run != 0)
        if current:
            heard = now_ns - told.age_ms * 1e6
            other = (run == 0) | (heard >= arrived - _SLACK_NS)
        else:
            other = told.columns.time_us > self.time_us[channel]
        newer: NDArray[np.bool_] = np.where(same, told.sequence >= self._end[channel], other)
        newer |= arrived == _NEVER
        return newer

    def correct_values(self, told: NewestSamples, boot: str, now_ns: int) -> None:
        """Take samples that are newer than what is known, each with its age."""
        columns, channel = told.columns, told.columns.channel
        self.update_values(columns, now_ns, boot)
        self._end[channel] = told.sequence + 1
        self.arrived_ns[channel] = (now_ns - told.age_ms * 1e6).astype(np.int64)

    def moved_to(self, other: Latest, here: int, there: int) -> None:
        """Carry what is known of the channel ``here`` over to ``there`` in another list."""
        other.value[there], other.time_us[there] = self.value[here], self.time_us[here]
        other.arrived_ns[there] = self.arrived_ns[here]
        other._run[there], other._end[there] = self._run[here], self._end[here]
        # The same dict, so that numbers of runs mean the same in both.
        other._runs = self._runs
        if here in self.texts:
            other.texts[there] = self.texts[here]

    def _run_number(self, boot: str) -> int:
        return self._runs.setdefault(boot, len(self._runs) + 1) if boot else 0

    def remember_value(
        self, channel: int, *, time_us: int, value: float, text: str, arrived_ns: int
    ) -> None:
        """Take a sample from the history, unless one is there."""
        if self.arrived_ns[channel] == _NEVER:
            self.value[channel] = value
            self.time_us[channel] = time_us
            self.arrived_ns[channel] = arrived_ns
            if text:
                self.texts[channel] = text

    def values_of(self, channels: NDArray[np.int64], now_ns: int) -> tuple[Columns, list[float]]:
        """Give what is known of ``channels``, numbered by their place in it, and its age (ms)."""
        known = np.flatnonzero(self.arrived_ns[channels] != _NEVER)
        at = channels[known]
        texts = {
            place: self.texts[int(channel)]
            for place, channel in enumerate(at)
            if int(channel) in self.texts
        }
        age_ms = np.maximum(0, now_ns - self.arrived_ns[at]) / 1e6
        columns = Columns(known.astype(np.uint16), self.time_us[at], self.value[at], texts)
        return columns, [round(age, 1) for age in age_ms.tolist()]
