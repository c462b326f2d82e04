"""How rare a magnitude is among those seen before.

A histogram in logarithmic steps that slowly forgets: a few hundred numbers stand for thousands of
samples. The rarity is the conformal p-value of the magnitude on a logarithmic scale: 0 for the
commonest, 1 for what is greater than all that came before. So a threshold means the same for
every signal, whatever its unit, range and noise.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import msgspec
import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - msgspec reads it at run time

# msgspec reads it at run time.
from talaia.hub.anomaly.base import Floats  # noqa: TC001

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Rarity", "rate_together"]

# Steps of 10 % from 1e-15 to 1e15.
_STEP = math.log(1.1)
_HALF, _BINS = 363, 727
_RESCALE = 1e100
# So many of each are rated at once. Of those in the same part of a block each is held against all
# others; the parts before it are counted by their steps.
_BLOCK, _PART = 512, 16
# Which of a part came before: those before in rows, their place in columns.
_BEFORE = np.tri(_PART, k=-1).T.astype(np.int8)[:, :, None]


class Rarity(msgspec.Struct, kw_only=True):
    """Gives the rarity of each magnitude among those before it.

    Attributes:
        memory: about so many of the newest samples count.
        least: it has no opinion before it has seen so many.

    """

    memory: float = 2000.0
    least: int = 40
    # How much came in each step; the newest weigh most.
    bins: Floats = msgspec.field(default_factory=lambda: np.zeros(_BINS))
    # What the next one weighs: it grows, which is forgetting without touching the others.
    weight: float = 1.0
    seen: int = 0

    def rate_magnitude(self, magnitude: float) -> float:
        """Take a magnitude (0 or more); give its rarity, 0 to 1."""
        at = _bin_index(magnitude)
        rarity = self._bin_rarity(at) if self.seen >= self.least else 0.0
        self.bins[at] += self.weight
        self.seen += 1
        self.weight *= math.exp(1.0 / self.memory)
        # Before the numbers become too large for a float.
        if self.weight > _RESCALE:
            self.bins /= self.weight
            self.weight = 1.0
        return rarity

    def rate_many(self, magnitudes: Floats) -> Floats:
        """Take magnitudes in their order (n,), as `rate_magnitude` takes them one by one.

        The state is the same to the last bit afterwards. The rarities differ by the rounding of
        sums that are added up in another order, some 1e-15.
        """
        rarities: Floats = rate_together([self], magnitudes[None])[0]
        return rarities

    def learn_magnitude(self, magnitude: float, times: float = 50.0) -> None:
        """Count a magnitude as if it had come so many times: it is not rare any more."""
        self.bins[_bin_index(magnitude)] += self.weight * times

    def _bin_rarity(self, at: int) -> float:
        same = float(self.bins[at])
        # Half of those in the same step: they count as neither greater nor less.
        above = float(self.bins[at + 1 :].sum()) + 0.5 * same
        total = float(self.bins.sum()) / self.weight
        return math.log((total + 1.0) / (above / self.weight + 1.0)) / math.log(total + 1.0)


def rate_together(rarities: Sequence[Rarity], magnitudes: Floats) -> Floats:
    """Take magnitudes in their order, as `Rarity.rate_many` does, for several at once.

    They know nothing of each other; but what it costs is mostly the number of steps, and those are
    the same for all.

    Args:
        rarities: which rate them.
        magnitudes: (rarities, n); below 0 where there is none.

    Returns:
        How rare each is (rarities, n), 0 where there is none.

    """
    rated = np.zeros(magnitudes.shape)
    if magnitudes.size and magnitudes.min() < 0.0:
        there = magnitudes >= 0.0
        whole = np.flatnonzero(there.all(axis=1))
        if len(whole):
            rated[whole] = rate_together([rarities[at] for at in whole.tolist()], magnitudes[whole])
        for at in np.flatnonzero(there.any(axis=1) & ~there.all(axis=1)).tolist():
            rated[at, there[at]] = rarities[at].rate_many(magnitudes[at, there[at]])
        return rated
    for first in range(0, magnitudes.shape[1], _BLOCK):
        part = slice(first, first + _BLOCK)
        rated[:, part] = _rate_block(rarities, magnitudes[:, part])
    return rated


def _rate_block(rarities: Sequence[Rarity], magnitudes: Floats) -> Floats:
    kinds, many = magnitudes.shape
    growth = np.empty((kinds, many + 1))
    for row, one in zip(growth, rarities, strict=True):
        row[0], row[1:] = one.weight, math.exp(1.0 / one.memory)
    # Multiplied one after the other, as one by one: the weights are the very same.
    weights = np.multiply.accumulate(growth, axis=1)
    if weights[:, -1].max() > _RESCALE:
        # Once in hundreds of thousands of samples.
        return np.array(
            [
                [one.rate_magnitude(magnitude) for magnitude in row]
                for one, row in zip(rarities, magnitudes.tolist(), strict=True)
            ]
        )
    at, own = _bin_indices(magnitudes), weights[:, :many]
    sums = np.zeros((kinds, many))
    np.cumsum(own[:, :-1], axis=1, out=sums[:, 1:])
    above = _weigh_above([one.bins for one in rarities], at, own)
    totals = (np.array([[one.bins.sum()] for one in rarities]) + sums) / own
    rated: Floats = np.log((totals + 1.0) / (above / own + 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        rated /= np.log(totals + 1.0)
    for place, one in enumerate(rarities):
        rated[place, : max(0, one.least - one.seen)] = 0.0
        np.add.at(one.bins, at[place], own[place])
        one.seen, one.weight = one.seen + many, float(weights[place, -1])
    return rated


def _weigh_above(bins: Sequence[Floats], at: NDArray[np.int64], own: Floats) -> Floats:
    """Sum up what was greater before each, and half of what was alike.

    Args:
        bins: what each had seen before the block.
        at: the steps of the block (bins, n).
        own: what they weigh (bins, n).

    """
    kinds, many = at.shape
    # Most steps are empty: only those between the least and the greatest are looked at.
    low, upto = int(at.min()), int(at.max()) + 1
    width, parts = upto - low, -(-many // _PART)
    # From the greatest on; the last part is filled up with what weighs nothing.
    steps = np.zeros((kinds, parts * _PART), np.int16)
    weights = np.zeros((kinds, parts * _PART))
    np.subtract(upto - 1, at, out=steps[:, :many], casting="unsafe")
    weights[:, :many] = own
    # Where each stands in a table of parts, kinds and steps.
    places = (np.arange(parts).repeat(_PART) * kinds + np.arange(kinds)[:, None]) * width + steps
    came = np.bincount(places.ravel(), weights.ravel(), parts * kinds * width)
    came = came.reshape(parts, kinds, width)
    # What each part finds: all that came before it.
    known = np.empty((parts, kinds, width))
    for place, one in enumerate(bins):
        known[0, place] = one[low:upto][::-1]
    known[1:] = came[:-1]
    np.cumsum(known, axis=0, out=known)
    alike = known.ravel().take(places)
    above = np.cumsum(known, axis=2, out=came).ravel().take(places)
    above -= 0.5 * alike
    above += np.array([[one[upto:].sum()] for one in bins])
    # And in its own part: 2 halves where it was greater, 1 where alike and 0 where less.
    short = np.ascontiguousarray(steps.reshape(-1, _PART).T)
    halves = (short[:, None] < short).view(np.int8)
    halves += (short[:, None] <= short).view(np.int8)
    halves *= _BEFORE
    within = (halves * weights.reshape(-1, _PART).T[:, None]).sum(axis=0)
    above += 0.5 * within.T.reshape(kinds, -1)
    found: Floats = above[:, :many]
    return found


def _bin_index(magnitude: float) -> int:
    if magnitude < 1e-15:
        return 0
    # A magnitude beyond all numbers is the greatest.
    if magnitude > 1e300:
        return _BINS - 1
    return min(_BINS - 1, max(1, int(math.log(magnitude) / _STEP) + _HALF))


def _bin_indices(magnitudes: Floats) -> NDArray[np.int64]:
    """Give the index of each, the same as `_bin_index` does."""
    # Least and greatest one by one: `clip` takes three times as long for so few.
    steps = np.log(np.minimum(np.maximum(magnitudes, 1e-15), 1e300)) / _STEP
    # Cut off towards 0, as `int` does.
    found = np.minimum(np.maximum(steps.astype(np.int64) + _HALF, 1), _BINS - 1)
    # Least and greatest tell in two passes that there is nothing special.
    if magnitudes.min() < 1e-15 or magnitudes.max() > 1e300:
        found[magnitudes < 1e-15] = 0
        found[magnitudes > 1e300] = _BINS - 1
    # At the edge of a step the last bit of the logarithm decides, and NumPy has another one.
    edges = np.abs(steps - np.rint(steps)) < 1e-9
    if edges.any():
        edges &= (magnitudes >= 1e-15) & (magnitudes <= 1e300)
        found[edges] = [_bin_index(magnitude) for magnitude in magnitudes[edges].tolist()]
    return found
