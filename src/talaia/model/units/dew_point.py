"""The dew point of air, from its temperature and relative humidity. Pure.

The Magnus form with the coefficients of O. A. Alduchov and R. E. Eskridge, *Improved Magnus form
approximation of saturation vapor pressure*, Journal of Applied Meteorology 35 (1996), 601 to 609,
equation 21: over water, within 0.4 % in pressure from -40 to 50 °C, some hundredths of a degree in
the dew point.
"""

from __future__ import annotations

import math

__all__ = ["dew_point"]

_B = 17.625
_C = 243.04  # °C


def dew_point(temperature: float, humidity: float) -> float:
    """Give the dew point (°C); NaN where there is none.

    Args:
        temperature: of the air (°C).
        humidity: relative, over water (%); over 100 counts as 100.

    """
    # Less is no humidity of air, and the logarithm of the least numbers is none.
    if not humidity >= 1e-6 or not temperature > -_C:
        return math.nan
    gamma = math.log(min(humidity, 100.0) / 100.0) + _B * temperature / (_C + temperature)
    # Beyond every temperature of air: rounding, or infinity.
    return _C * gamma / (_B - gamma) if gamma < _B else math.nan
