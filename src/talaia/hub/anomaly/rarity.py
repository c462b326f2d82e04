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

# msgspec reads it at run time.
from talaia.hub.anomaly.base import Floats  # noqa: TC001

__all__ = ["Rarity"]

# Steps of 10 % from 1e-15 to 1e15.
_STEP = math.log(1.1)
_HALF, _BINS = 363, 727
_RESCALE = 1e100


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
