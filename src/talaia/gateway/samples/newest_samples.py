"""The newest sample of each channel of this run: what counts when a link comes up. Pure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - kept with the other columns

from talaia.wire.columns import Columns
from talaia.wire.newest import NewestSamples

__all__ = ["RunNewest"]

# As many as fit the samples' column of channels.
_CHANNELS = 65_536
# Batches that wait to be entered together: it costs as much for one as for all of them.
_MOST_WAITING = 32


class _WaitingBatch(NamedTuple):
    numbers: NDArray[np.uint16]
    columns: Columns
    first: int
    heard_ns: int


class RunNewest:
    """One place for each channel, by its number in the `ChannelNumbering`."""

    def __init__(self) -> None:
        """Begin with nothing known."""
        # By channel number. Sequence of its newest sample; -1: never heard.
        self._sequence = np.full(_CHANNELS, -1, np.int64)
        self._time_us = np.zeros(_CHANNELS, np.int64)  # Its time (µs UTC, as the robot had it).
        self._heard_ns = np.zeros(_CHANNELS, np.int64)  # When we heard it (monotonic), for its age.
        # Number, or for a text channel what stands in its place; the texts are beside it.
        self._value = np.zeros(_CHANNELS, np.float64)
        self._texts: dict[int, str] = {}
        # Not entered yet, the oldest first.
        self._waiting: list[_WaitingBatch] = []

    def update_newest(
        self, numbers: NDArray[np.uint16], columns: Columns, first: int, now_ns: int
    ) -> None:
        """Take a batch; of several samples of a channel the last counts.

        Args:
            numbers: of the samples' channels, in the roster.
            columns: the samples; their own channels are not looked at.
            first: sequence number of the first.
            now_ns: when they were heard (monotonic).

        """
        self._waiting.append(_WaitingBatch(numbers, columns, first, now_ns))
        if len(self._waiting) >= _MOST_WAITING:
            self._enter_waiting()

    def _enter_waiting(self) -> None:
        waiting, self._waiting = self._waiting, []
        if not waiting:
            return
        numbers = np.concatenate([one.numbers for one in waiting])
        counts = [len(one.columns) for one in waiting]
        sequence = [one.first + np.arange(len(one.columns)) for one in waiting]
        # Of repeated numbers NumPy keeps the last that is assigned: the newest.
        self._sequence[numbers] = np.concatenate(sequence)
        self._time_us[numbers] = np.concatenate([one.columns.time_us for one in waiting])
        self._heard_ns[numbers] = np.repeat([one.heard_ns for one in waiting], counts)
        self._value[numbers] = np.concatenate([one.columns.value for one in waiting])
        for one in waiting:
            for at, text in one.columns.texts.items():
                self._texts[int(one.numbers[at])] = text

    def newest_samples(self, order: NDArray[np.int64] | None, now_ns: int) -> NewestSamples:
        """Give all that is known, by the channel list that counts now, in order of sequence.

        Args:
            order: see `ChannelNumbering.order_of`; none where numbers are places.
            now_ns: now (monotonic).

        """
        self._enter_waiting()
        numbers = np.flatnonzero(self._sequence >= 0)
        if order is not None:
            numbers = numbers[numbers < order.size]
            numbers = numbers[order[numbers] >= 0]
        numbers = numbers[np.argsort(self._sequence[numbers])]
        places = numbers if order is None else order[numbers]
        texts = {
            at: self._texts[number]
            for at, number in enumerate(numbers.tolist())
            if number in self._texts
        }
        return NewestSamples(
            Columns(places.astype(np.uint16), self._time_us[numbers], self._value[numbers], texts),
            self._sequence[numbers],
            (now_ns - self._heard_ns[numbers]) / 1e6,
        )
