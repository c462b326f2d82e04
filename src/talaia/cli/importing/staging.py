"""Samples in the order of a file, gathered by channel into a parcel, and what is told of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.hub.history.import_file import ImportChunk
from talaia.wire.columns import Columns, slice_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.history.import_file import ParcelWriter

__all__ = ["Staging", "Tally"]

# A channel's samples are written when there are so many; all of them when that many wait.
_ENOUGH = 8_192
_MOST = 1_000_000


class Tally(NamedTuple):
    """What a file holds of one channel; times in microseconds since the epoch."""

    address: str
    samples: int
    first_us: int
    last_us: int


class Staging:
    """Takes a file's samples, and writes them by channel."""

    def __init__(self, addresses: Sequence[str], writer: ParcelWriter | None) -> None:
        """Number the channels as in ``addresses``; without a writer they are only counted."""
        # By the site's number of a channel.
        self._addresses = addresses
        # None in a dry run, which must read and count all the same.
        self._writer = writer
        # Columns that are not written yet, and how many samples they hold, by channel.
        self._parts: dict[int, list[Columns]] = {}
        self._waiting: dict[int, int] = {}
        # Samples written so far; the next batch of a channel goes on from there.
        self._written = dict.fromkeys(range(len(addresses)), 0)
        # Samples, first and last time (µs) of each channel, for the summary.
        self._spans: dict[int, tuple[int, int, int]] = {}

    @property
    def samples(self) -> int:
        """How many came until now."""
        return sum(count for count, _, _ in self._spans.values())

    def add_samples(self, columns: Columns) -> None:
        """Take samples in the order of the file."""
        # Stable: within a channel the file's order decides, and numbers its samples.
        order = np.argsort(columns.channel, kind="stable")
        # Texts are keyed by their place, so they move with it; most columns have none.
        place = {int(old): new for new, old in enumerate(order)} if columns.texts else {}
        sorted_columns = Columns(
            columns.channel[order],
            columns.time_us[order],
            columns.value[order],
            {place[at]: text for at, text in columns.texts.items()},
        )
        numbers, starts = np.unique(sorted_columns.channel, return_index=True)
        bounds = [*starts.tolist(), len(columns)]
        for at, number in enumerate(numbers.tolist()):
            self._keep_columns(number, slice_columns(sorted_columns, bounds[at], bounds[at + 1]))
        # Many channels of a few samples each never get to `_ENOUGH`, and would fill the memory.
        if sum(self._waiting.values()) > _MOST:
            self.finish_files()

    def finish_files(self) -> None:
        """Write what waits."""
        for number in list(self._parts):
            self._write_batch(number)

    def channel_tallies(self) -> list[Tally]:
        """Tell what came, by channel, in the order of the description."""
        return [
            Tally(self._addresses[number], *self._spans[number]) for number in sorted(self._spans)
        ]

    def _keep_columns(self, number: int, columns: Columns) -> None:
        # Limits to begin with, so that the first sample is both the earliest and the latest.
        count, first_us, last_us = self._spans.get(number, (0, 2**63 - 1, -(2**63)))
        first_us = min(first_us, int(columns.time_us.min()))
        last_us = max(last_us, int(columns.time_us.max()))
        self._spans[number] = (count + len(columns), first_us, last_us)
        if self._writer is None:
            return
        self._parts.setdefault(number, []).append(columns)
        self._waiting[number] = self._waiting.get(number, 0) + len(columns)
        if self._waiting[number] >= _ENOUGH:
            self._write_batch(number)

    def _write_batch(self, number: int) -> None:
        parts, count = self._parts.pop(number), self._waiting.pop(number)
        texts, at = {}, 0
        for columns in parts:
            texts.update({at + position: text for position, text in columns.texts.items()})
            at += len(columns)
        whole = Columns(
            # A batch is of one channel, which its chunk names.
            np.zeros(count, np.uint16),
            np.concatenate([columns.time_us for columns in parts]),
            np.concatenate([columns.value for columns in parts]),
            texts,
        )
        if self._writer is not None:
            first = self._written[number]
            self._writer.add_chunk(ImportChunk(self._addresses[number], first, whole))
            # After the write, which numbers the batch's first sample by it.
            self._written[number] = first + count
