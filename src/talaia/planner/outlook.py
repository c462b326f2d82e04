"""How likely the roof is open later in the night, and so what a visit then is worth now."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from talaia.planner.sky import Floats

__all__ = ["CERTAIN", "WeatherOutlook"]


class WeatherOutlook(NamedTuple):
    """The roof as a chain of two states; learn both times from a site's history or forecast.

    Attributes:
        open_s: how long it stays open, in the mean (s).
        floor: the share of the far future in which it counts as open (0 to 1).

    """

    open_s: float = 10_000.0
    # A roof that closes opens again: with 0, allocations were spent on poor visits in the evening.
    floor: float = 0.7

    def weights(self, seconds: Floats) -> Floats:
        """Give the weight of a value that is reached so many seconds from now."""
        fading = np.exp(-np.maximum(seconds, 0.0) / self.open_s)
        return np.asarray(self.floor + (1.0 - self.floor) * fading)


CERTAIN = WeatherOutlook(open_s=math.inf)
"""The roof stays open: for bounds and forecasts of clear nights."""
