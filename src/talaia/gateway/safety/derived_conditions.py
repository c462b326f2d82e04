"""Conditions on what no sensor says by itself: a difference of two signals, the Sun. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.safety.interlock_state import InterlockVerdict
from talaia.model.units import astronomy
from talaia.model.units.dew_point import dew_point

if TYPE_CHECKING:
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.interlocks.interlock import Condition

__all__ = ["judge_dew_point", "judge_difference", "judge_sun"]


def judge_difference(
    condition: Condition, names: tuple[str, str], values: tuple[float, float], unit: str
) -> InterlockVerdict:
    """Say whether the first of two signals is too far from, or too near to, the second."""
    return _judge_limits(condition, f"{names[0]} minus {names[1]}", values[0] - values[1], unit)


def judge_dew_point(
    *, condition: Condition, name: str, temperature: float, humidity: float, unit: str
) -> InterlockVerdict:
    """Say whether a temperature (°C) is too near to the dew point at a humidity (%)."""
    away = temperature - dew_point(temperature, humidity)
    # Humidity of 0 % or less has no dew point; that is a broken sensor, not dry air.
    if math.isnan(away):
        air = f"{temperature:g} °C and {humidity:g} %"
        return InterlockVerdict(f"{name}: the air has no dew point at {air}", unknown=True)
    return _judge_limits(condition, f"{name} minus dew point", away, unit)


def judge_sun(condition: Condition, place: Place, wall_ns: int) -> InterlockVerdict:
    """Say whether the Sun is too high, or too low, at a place."""
    jd = astronomy.julian_day(wall_ns / SECOND)
    here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
    # Refraction is left out: near the horizon half a degree, far below what limits mean.
    altitude = astronomy.equatorial_to_horizontal(*astronomy.sun_position(jd), here, jd).alt
    return _judge_limits(condition, "The Sun's altitude", altitude, "°")


def _judge_limits(condition: Condition, name: str, value: float, unit: str) -> InterlockVerdict:
    if condition.above is not None and value > condition.above:
        return InterlockVerdict(f"{name} is above {condition.above:g} {unit}".rstrip())
    if condition.below is not None and value < condition.below:
        return InterlockVerdict(f"{name} is below {condition.below:g} {unit}".rstrip())
    return InterlockVerdict()
