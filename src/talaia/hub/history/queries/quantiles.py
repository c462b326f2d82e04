"""Exact quantiles of more numbers than memory should hold, in one look at each. Pure.

Numbers come in pieces, in an order in which every part of them is like the whole. Of each quantile
only what may still be it is held: a bracket, with its values and how often each came, and how many
lie below it. Now and then those of the bracket that are far from the quantile are let go; numbers
that come later are counted below it, kept in it, or passed over.

A bracket may turn out to have missed its quantile, where the first pieces were not like the whole.
That is known at the end, and then the numbers are looked at once more, with wider brackets.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["KEPT", "Ranks"]

# So many numbers around each quantile are kept: far more than the order of the pieces, and chance,
# put it off. Some 20 MB for each quantile while they are sorted in.
KEPT = 524_288


class Ranks:
    """Takes numbers and gives quantiles of them; one `Ranks` is one look at all numbers.

    Attributes:
        count: finite numbers taken so far.

    """

    def __init__(self, parts: tuple[float, ...], kept: int = KEPT) -> None:
        """Find the quantiles ``parts`` (0 to 1); about ``kept`` numbers around each are held."""
        self.count = 0
        # Which quantiles, 0 to 1.
        self._parts = parts
        # About so many numbers a bracket holds after it was folded.
        self._kept = kept
        # One for each part, in the same order.
        self._brackets = [_Bracket(kept) for _ in parts]

    def add_values(self, values: NDArray[np.float64]) -> None:
        """Take some numbers; those that are not finite are passed over."""
        numbers = values[np.isfinite(values)]
        self.count += numbers.size
        for part, bracket in zip(self._parts, self._brackets, strict=True):
            bracket.add_values(numbers)
            if bracket.waiting > 2 * self._kept:
                bracket.fold_pending(part * self.count)

    def quantiles(self) -> list[float] | None:
        """Give the quantiles, between neighbours by share; None if one was missed.

        Without numbers each is NaN.
        """
        if not self.count:
            return [math.nan for _ in self._parts]
        found = []
        for part, bracket in zip(self._parts, self._brackets, strict=True):
            place = (self.count - 1) * part
            low, high = bracket.value_at(math.floor(place)), bracket.value_at(math.ceil(place))
            if low is None or high is None:
                return None
            found.append(low + (high - low) * (place - math.floor(place)))
        return found


class _Bracket:
    """What may still be a quantile."""

    def __init__(self, kept: int) -> None:
        # Numbers in `_pieces`; whoever adds them folds when they are many.
        self.waiting = 0
        # Numbers that are held after folding.
        self._kept = kept
        # Numbers that lie under the bracket: only how many there are is known.
        self._below = 0
        # Both ends belong to it.
        self._low, self._high = -math.inf, math.inf
        # Came since it was folded, in no order: to sort each piece in would take longer.
        self._pieces: list[NDArray[np.float64]] = []
        # Sorted, each of them once.
        self._values = np.empty(0)
        # How often each of them came: a signal with few values needs little room.
        self._times = np.empty(0, np.int64)

    def add_values(self, numbers: NDArray[np.float64]) -> None:
        if self._low > -math.inf or self._high < math.inf:
            self._below += int(np.count_nonzero(numbers < self._low))
            numbers = numbers[(numbers >= self._low) & (numbers <= self._high)]
        if numbers.size:
            self._pieces.append(numbers)
            self.waiting += numbers.size

    def fold_pending(self, rank: float) -> None:
        """Sort in what waits, and let go what is far from ``rank``.

        Where later numbers lie elsewhere than the first ones, the rank may be outside of what is
        held. Then the nearest numbers are kept: still later ones may bring it back, and if not,
        `value_at` does not find it.
        """
        self._sort_in()
        if not self._values.size:
            return
        ranks = self._below + np.cumsum(self._times)
        half = self._kept // 2
        rank = min(max(rank, self._below + half), int(ranks[-1]) - half)
        first = int(np.searchsorted(ranks, rank - half, "left"))
        past = int(np.searchsorted(ranks, rank + half, "right")) + 1
        self._below += int(self._times[:first].sum())
        # An end at which nothing is let go stays where it was.
        if first > 0:
            self._low = float(self._values[first])
        if past < self._values.size:
            self._high = float(self._values[past - 1])
        self._values, self._times = self._values[first:past], self._times[first:past]

    def value_at(self, rank: int) -> float | None:
        """Give the number of a rank (0 is the least); None if it was let go."""
        self._sort_in()
        ranks = self._below + np.cumsum(self._times)
        if rank < self._below or not ranks.size or rank >= int(ranks[-1]):
            return None
        return float(self._values[np.searchsorted(ranks, rank, "right")])

    def _sort_in(self) -> None:
        if not self._pieces:
            return
        values, times = np.unique(np.concatenate(self._pieces), return_counts=True)
        self._pieces, self.waiting = [], 0
        self._values, at = np.unique(np.concatenate([self._values, values]), return_inverse=True)
        # Whole numbers up to 2**53 are whole as floats, too.
        weights = np.concatenate([self._times, times])
        self._times = np.bincount(at.ravel(), weights).astype(np.int64)
