"""How likely the roof is open later in the night, and so what a visit then is worth now."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from talaia.planner.night_problem import Ints
    from talaia.planner.sky import Floats

__all__ = ["CERTAIN", "WeatherOutlook"]


class WeatherOutlook(NamedTuple):
    """The roof as a chain of two states; learn both times from a site's history or forecast.

    Attributes:
        open_s: how long it stays open, in the mean (s).
        floor: the share of the far future in which it counts as open (0 to 1).
        lost: how likely a block that a closing or a rapid request breaks off is not completed in
            this night any more (0 to 1): another night it begins from its first frame.

    """

    open_s: float = 10_000.0
    # A roof that closes opens again: with 0, allocations were spent on poor visits in the evening.
    floor: float = 0.7
    # What was lost of open shutters were long blocks that were never completed, and little else.
    lost: float = 0.5

    def weights(self, seconds: Floats) -> Floats:
        """Give the weight of a value that is reached so many seconds from now."""
        fading = np.exp(-np.maximum(seconds, 0.0) / self.open_s)
        return np.asarray(self.floor + (1.0 - self.floor) * fading)

    def completion(self, block_s: Ints) -> Floats:
        """Give how likely blocks of such lengths (s), once begun, are completed in this night."""
        return np.asarray(np.exp(-self.lost * block_s / self.open_s))


CERTAIN = WeatherOutlook(open_s=math.inf)
"""The roof stays open: for bounds and forecasts of clear nights."""
