"""The units a signal or an argument may be given in: SI and what the field uses besides.

A unit is written as its symbol (``m/s``). The table says how many decimals are sensible on
screen when the description does not say.
"""

from __future__ import annotations

from typing import NamedTuple

from talaia.model.errors import UnknownWord

__all__ = ["UNITS", "Unit", "unit_of"]


class Unit(NamedTuple):
    """A unit's symbol, its name, and the decimals that are sensible on screen."""

    symbol: str
    name: str
    decimals: int


_ROWS = (
    Unit("", "without unit", 2),
    Unit("%", "percent", 1),
    Unit("m", "metre", 2),
    Unit("cm", "centimetre", 1),
    Unit("mm", "millimetre", 0),
    Unit("km", "kilometre", 2),
    Unit("m/s", "metre per second", 2),
    Unit("km/h", "kilometre per hour", 1),
    Unit("m/s²", "metre per second squared", 2),
    Unit("rad", "radian", 3),
    Unit("rad/s", "radian per second", 3),
    Unit("°", "degree", 2),
    Unit("°/s", "degree per second", 2),
    Unit("arcsec", "arcsecond", 2),
    Unit("h", "hour", 3),
    Unit("min", "minute", 1),
    Unit("s", "second", 2),
    Unit("ms", "millisecond", 1),
    Unit("Hz", "hertz", 1),
    Unit("rpm", "revolutions per minute", 0),
    Unit("V", "volt", 2),
    Unit("mV", "millivolt", 0),
    Unit("A", "ampere", 2),
    Unit("Ah", "ampere hour", 2),
    Unit("W", "watt", 1),
    Unit("Wh", "watt hour", 1),
    Unit("°C", "degree Celsius", 1),
    Unit("K", "kelvin", 1),
    Unit("hPa", "hectopascal", 1),
    Unit("Pa", "pascal", 0),
    Unit("lx", "lux", 0),
    Unit("mm/h", "millimetre per hour", 1),
    Unit("mag/arcsec²", "magnitude per square arcsecond", 2),
    Unit("dBm", "decibel milliwatt", 0),
    Unit("dB", "decibel", 1),
    Unit("N", "newton", 2),
    Unit("N·m", "newton metre", 2),
    Unit("T", "tesla", 6),
    Unit("kg", "kilogram", 2),
    Unit("ppm", "parts per million", 0),
    Unit("B", "byte", 0),
)
UNITS: dict[str, Unit] = {row.symbol: row for row in _ROWS}
# What people type who do not find the sign on the keyboard.
_SPELLINGS = {
    "m/s^2": "m/s²",
    "m/s2": "m/s²",
    "deg": "°",
    "deg/s": "°/s",
    "degC": "°C",
    "celsius": "°C",
    "percent": "%",
    "Nm": "N·m",
    "mag/arcsec^2": "mag/arcsec²",
}


def unit_of(where: str, symbol: str) -> Unit:
    """Give the unit for a symbol or one of its plain-ASCII spellings.

    Raises:
        UnknownWord: the symbol is not in the table.

    """
    unit = UNITS.get(_SPELLINGS.get(symbol, symbol))
    if unit is None:
        raise UnknownWord(where, "unit", symbol, UNITS)
    return unit
