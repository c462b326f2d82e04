"""The newest sample of every channel of a site, with the moment it arrived."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.clock import SECOND
from talaia.wire.columns import Columns, join_columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.wire.newest import NewestSamples

__all__ = ["Latest"]

# Before every moment of the monotonic clock: nothing was heard.
_NEVER = np.iinfo(np.int64).min
# What is under way is a little older when it comes.
_SLACK_NS = 5 * SECOND
# So many batches, or samples, wait to be put in their places.
_MOST_BATCHES, _MOST_SAMPLES = 8, 2_048


class _Came(NamedTuple):
    """A batch that is not in its places yet; see `Latest.update_values`."""

    columns: Columns
    now_ns: int
    run: int
    end: int


class Latest:
    """One place for each channel; arrays have the shape (channels,).

    Batches are put in their places when somebody asks, or some together: nobody asks for most of
    what thousands of gateways say, and a few samples take as long as a few hundred.
    """

    def __init__(self, channels: int) -> None:
        """Start with nothing known."""
        self._value = np.full(channels, np.nan)
        self._time_us = np.zeros(channels, np.int64)
        self._arrived_ns = np.full(channels, _NEVER, np.int64)
        self._texts: dict[int, str] = {}
        # In the order in which they came, and how many samples they hold.
        self._came: list[_Came] = []
        self._waiting = 0
        # Of which run the sample is, and one past a number of that run which it does not exceed;
        # 0 where that is not known.
        self._run = np.zeros(channels, np.int64)
        self._end = np.zeros(channels, np.int64)
        # Numbers of runs by their names, from 1 on, for arrays hold no names; 0: no run.
        self._runs: dict[str, int] = {}

    @property
    def value(self) -> NDArray[np.float64]:
        """The samples; NaN may be one too: whether there is one is told by `arrived_ns`."""
        self._put_in_places()
        return self._value

    @property
    def time_us(self) -> NDArray[np.int64]:
        """When each was measured (µs, UTC), by the gateway's clock."""
        self._put_in_places()
        return self._time_us

    @property
    def arrived_ns(self) -> NDArray[np.int64]:
        """When each came here (monotonic ns), by which it ages."""
        self._put_in_places()
        return self._arrived_ns

    @property
    def texts(self) -> dict[int, str]:
        """By channel, of channels that say texts."""
        self._put_in_places()
        return self._texts

    def update_values(self, columns: Columns, now_ns: int, boot: str = "", end: int = 0) -> None:
        """Take a live batch; of several samples of a channel the last in the batch counts.

        Args:
            columns: the batch.
            now_ns: when it came (monotonic).
            boot: its run, where it has one.
            end: one past its last number there.

        """
        self._came.append(_Came(columns, now_ns, self._run_number(boot), end))
        self._waiting += len(columns)
        if len(self._came) >= _MOST_BATCHES or self._waiting >= _MOST_SAMPLES:
            self._put_in_places()

    def _put_in_places(self) -> None:
        if not self._came:
            return
        came, self._came, self._waiting = self._came, [], 0
        columns = join_columns([batch.columns for batch in came])
        channel, sizes = columns.channel, [len(batch.columns) for batch in came]
        # Of a channel that comes twice numpy keeps the last value that is assigned.
        self._run[channel] = np.repeat([batch.run for batch in came], sizes)
        self._end[channel] = np.repeat([batch.end for batch in came], sizes)
        self._value[channel] = columns.value
        self._time_us[channel] = columns.time_us
        self._arrived_ns[channel] = np.repeat([batch.now_ns for batch in came], sizes)
        for at, text in columns.texts.items():
            self._texts[int(channel[at])] = text

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
        self._put_in_places()
        run, arrived = self._run[channel], self._arrived_ns[channel]
        # Without a run there are no numbers to compare.
        same = (run == self._run_number(boot)) & (run != 0)
        if current:
            heard = now_ns - told.age_ms * 1e6
            other = (run == 0) | (heard >= arrived - _SLACK_NS)
        else:
            other = told.columns.time_us > self._time_us[channel]
        newer: NDArray[np.bool_] = np.where(same, told.sequence >= self._end[channel], other)
        newer |= arrived == _NEVER
        return newer

    def correct_values(self, told: NewestSamples, boot: str, now_ns: int) -> None:
        """Take samples that are newer than what is known, each with its age."""
        columns, channel = told.columns, told.columns.channel
        self.update_values(columns, now_ns, boot)
        self._put_in_places()
        self._end[channel] = told.sequence + 1
        self._arrived_ns[channel] = (now_ns - told.age_ms * 1e6).astype(np.int64)

    def moved_to(self, other: Latest, here: int, there: int) -> None:
        """Carry what is known of the channel ``here`` over to ``there`` in another list."""
        # Before runs are read, which have no property of their own.
        self._put_in_places()
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
