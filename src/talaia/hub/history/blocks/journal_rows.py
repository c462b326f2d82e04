"""Which rows the journal has, oldest first, in few bytes each."""

from __future__ import annotations

from array import array
from bisect import bisect_left

__all__ = ["JournalRows"]

# What was forgotten is cut off when it is so much, and half of all: seldom, so it costs little.
_CUT = 1_024


class JournalRows:
    """The numbers of the journal's rows, and how many samples each holds.

    There may be a hundred thousand of them for hours, while a slow signal fills its block: 12
    bytes each, where a list of pairs takes a hundred.

    Attributes:
        samples: how many all rows hold together.

    """

    def __init__(self) -> None:
        """Start empty."""
        # Rising. An array: as Python's own numbers they would take several times the memory.
        self._ids = array("q")
        # Samples of each row, in the same order.
        self._sizes = array("I")
        # So many at the beginning are forgotten, and not cut off yet.
        self._gone = 0
        self.samples = 0

    def __len__(self) -> int:
        return len(self._ids) - self._gone

    @property
    def bytes(self) -> int:
        """Memory that is taken, without what the arrays hold ready."""
        return len(self._ids) * (self._ids.itemsize + self._sizes.itemsize)

    def append_row(self, row: int, samples: int) -> None:
        """Add a row; its number is higher than all before."""
        self._ids.append(row)
        self._sizes.append(samples)
        self.samples += samples

    def count_below(self, row: int) -> int:
        """Count those with a lower number than ``row``."""
        return bisect_left(self._ids, row, self._gone) - self._gone

    def last_of_oldest(self, count: int) -> int:
        """Give the highest number of the ``count`` oldest, which must be there."""
        return self._ids[self._gone + count - 1]

    def merge_rows(self, first: int, last: int) -> None:
        """Put one row in the place of those from ``first`` to ``last``, under the last number."""
        begin = bisect_left(self._ids, first, self._gone)
        end = bisect_left(self._ids, last + 1, self._gone)
        together = sum(self._sizes[begin:end])
        self._ids[begin:end] = array("q", [last])
        self._sizes[begin:end] = array("I", [together])

    def forget_rows(self, last: int) -> None:
        """Forget those up to the number ``last``."""
        end = bisect_left(self._ids, last + 1, self._gone)
        self.samples -= sum(self._sizes[self._gone : end])
        self._gone = end
        if self._gone >= _CUT and 2 * self._gone >= len(self._ids):
            del self._ids[: self._gone], self._sizes[: self._gone]
            self._gone = 0
