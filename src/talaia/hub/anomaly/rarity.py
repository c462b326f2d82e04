"""How rare a magnitude is among those seen before.

A histogram in logarithmic steps that slowly forgets: a few hundred numbers stand for thousands of
samples. The rarity is the conformal p-value of the magnitude on a logarithmic scale: 0 for the
commonest, 1 for what is greater than all that came before. So a threshold means the same for
every signal, whatever its unit, range and noise.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - msgspec reads it at run time

# msgspec reads it at run time.
from talaia.hub.anomaly.base import Floats  # noqa: TC001

__all__ = ["Rarity"]

# Steps of 10 % from 1e-15 to 1e15.
_STEP = math.log(1.1)
_HALF, _BINS = 363, 727
_RESCALE = 1e100
# So many are rated at once: each is held against all before it in its block.
_BLOCK = 128
# Small numbers: a comparison of all with all is what this costs most.
_BEFORE = np.tri(_BLOCK, k=-1).astype(np.int16)


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
        rarities = np.empty(len(magnitudes))
        for first in range(0, len(magnitudes), _BLOCK):
            block = magnitudes[first : first + _BLOCK]
            rarities[first : first + _BLOCK] = self._rate_block(block)
        return rarities

    def _rate_block(self, magnitudes: Floats) -> Floats:
        many = len(magnitudes)
        growth = np.full(many + 1, math.exp(1.0 / self.memory))
        growth[0] = self.weight
        # Multiplied one after the other, as one by one: the weights are the very same.
        weights = np.multiply.accumulate(growth)
        if weights[-1] > _RESCALE:
            # Once in hundreds of thousands of samples.
            return np.array([self.rate_magnitude(float(one)) for one in magnitudes])
        at, own = _bin_indices(magnitudes), weights[:many]
        from_here = np.zeros(_BINS + 1)
        np.cumsum(self.bins[::-1], out=from_here[_BINS - 1 :: -1])
        sums = np.zeros(many)
        np.cumsum(own[:-1], out=sums[1:])
        short = at.astype(np.int16)
        # What came before in this block, one row for each and those before it in the columns: 1
        # where it was greater, 0 where alike and -1 where less; of alike ones the half counts.
        signs = np.sign(short[None, :] - short[:, None]) * _BEFORE[:many, :many]
        above = from_here[at + 1] + 0.5 * (self.bins[at] + sums + signs @ own)
        total = (from_here[0] + sums) / own
        rarities: Floats = np.log((total + 1.0) / (above / own + 1.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            rarities /= np.log(total + 1.0)
        rarities[: max(0, self.least - self.seen)] = 0.0
        np.add.at(self.bins, at, own)
        self.seen, self.weight = self.seen + many, float(weights[-1])
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
        for near in np.flatnonzero(edges & (magnitudes >= 1e-15) & (magnitudes <= 1e300)):
            found[near] = _bin_index(float(magnitudes[near]))
    return found
