"""The greatest magnitudes that a detector has seen, in blocks of ten minutes, bounded."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.hub.anomaly.base import Floats

__all__ = ["BLOCK_US", "MOST_PEAKS", "WEEK_BLOCKS", "Peak", "ScoreTail", "block_of"]

# What happens in ten minutes has one cause.
BLOCK_US = 600_000_000
WEEK_BLOCKS = 7 * 86_400_000_000 // BLOCK_US
_DAY_BLOCKS = 86_400_000_000 // BLOCK_US
# So much of the past counts: a machine of last year is another one.
_DAYS = 56
MOST_PEAKS = 48
# A stretch has at most so many blocks: of a detector that always says something, hours are told
# apart.
_LONGEST = 6


def block_of(time_us: int) -> int:
    """Number the block of ten minutes that a moment (µs since the epoch) is in."""
    return time_us // BLOCK_US


class Peak(msgspec.Struct, array_like=True):
    """Up to an hour of blocks without a pause, and the greatest magnitude in it."""

    first: int
    last: int
    greatest: float


class ScoreTail(msgspec.Struct, kw_only=True):
    """What is left of everything that a detector said of up to eight weeks.

    Attributes:
        peaks: of each magnitude that the detector rates, the greatest ones, in order of time.
        days: so many blocks of each day were looked at.
        block: the newest one; -1: none yet.
        filled: the stored history before its first block was looked at, too.

    """

    peaks: list[list[Peak]] = msgspec.field(default_factory=list)
    days: dict[int, int] = msgspec.field(default_factory=dict)
    block: int = -1
    filled: bool = False

    @property
    def blocks(self) -> int:
        """So many blocks were looked at."""
        return sum(self.days.values())

    def see_time(self, time_us: int) -> None:
        """Count the block of a sample that was judged."""
        block = time_us // BLOCK_US
        if block <= self.block:
            return
        self.block = block
        day = block // _DAY_BLOCKS
        self.days[day] = self.days.get(day, 0) + 1
        if len(self.days) > _DAYS:
            self._forget_before((day - _DAYS + 1) * _DAY_BLOCKS)

    def record_magnitudes(self, time_us: int, magnitudes: Sequence[float]) -> None:
        """Take the magnitudes of a sample that could begin an anomaly."""
        self.see_time(time_us)
        # Of a version before it may have had fewer.
        self.peaks = self.peaks[: len(magnitudes)]
        self.peaks += [[] for _ in range(len(magnitudes) - len(self.peaks))]
        block = time_us // BLOCK_US
        for peaks, magnitude in zip(self.peaks, magnitudes, strict=True):
            newest = peaks[-1] if peaks else None
            near = newest is not None and newest.first <= block <= newest.last + 1
            if newest is not None and near and block - newest.first < _LONGEST:
                # Next to each other: one stretch.
                newest.last = max(newest.last, block)
                newest.greatest = max(newest.greatest, magnitude)
            elif newest is None or block > newest.last:
                self._add_peak(peaks, Peak(block, block, magnitude))

    def record_many(
        self, times: NDArray[np.int64], eligible: NDArray[np.bool_], magnitudes: Floats
    ) -> None:
        """Take many samples in, as one by one: times (n,), magnitudes (n, m)."""
        if not len(times):
            return
        blocks = times // BLOCK_US
        edges = np.flatnonzero(np.diff(blocks, prepend=blocks[0] - 1))
        for first, upto in zip(edges.tolist(), [*edges[1:].tolist(), len(times)], strict=True):
            self.see_time(int(times[first]))
            inside = eligible[first:upto]
            if inside.any():
                greatest = magnitudes[first:upto][inside].max(axis=0)
                self.record_magnitudes(int(times[first]), greatest.tolist())

    def forget_stretch(self, from_us: int, to_us: int) -> None:
        """Leave out what was in a stretch (µs): it was no false alarm."""
        first, last = block_of(from_us) - 1, block_of(to_us) + 1
        self.peaks = [
            [peak for peak in peaks if peak.last < first or peak.first > last]
            for peaks in self.peaks
        ]

    def add_past(self, past: ScoreTail) -> None:
        """Put what was found in stored history before what was seen live."""
        begin = min(self.days, default=None)
        for day, count in past.days.items():
            # A day that was seen live was seen in part: the fuller count is nearer to the truth.
            self.days[day] = max(self.days.get(day, 0), count)
        edge = None if begin is None else begin * _DAY_BLOCKS
        if len(self.peaks) != len(past.peaks):
            self.peaks = [[] for _ in past.peaks] if past.peaks else self.peaks
        for peaks, older in zip(self.peaks, past.peaks, strict=False):
            before = [peak for peak in older if edge is None or peak.last < edge]
            peaks[:] = sorted(
                sorted([*before, *peaks], key=lambda peak: -peak.greatest)[:MOST_PEAKS],
                key=lambda peak: peak.first,
            )
        self.block, self.filled = max(self.block, past.block), True

    def _add_peak(self, peaks: list[Peak], peak: Peak) -> None:
        peaks.append(peak)
        if len(peaks) > MOST_PEAKS:
            # The newest stays: it may grow yet.
            least = min(range(len(peaks) - 1), key=lambda at: peaks[at].greatest)
            del peaks[least]

    def _forget_before(self, block: int) -> None:
        self.days = {day: many for day, many in self.days.items() if day * _DAY_BLOCKS >= block}
        self.peaks = [[peak for peak in peaks if peak.last >= block] for peaks in self.peaks]
