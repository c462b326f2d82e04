"""Common units of signals and arguments: their names, and sensible decimals. Pure.

A unit is shown as it is written, whatever it is. The table is of those that are common: what a
screen reader says, and how many decimals are sensible when the description does not say.
"""

from __future__ import annotations

from typing import NamedTuple

from talaia.model.units.unit_measures import MEASURES, OTHER_NAMES

__all__ = ["UNITS", "Unit", "unit_of"]

# Of a unit that is not in the table.
_DECIMALS = 2


class Unit(NamedTuple):
    """A unit's symbol, its name, and the decimals that are sensible on screen."""

    symbol: str
    name: str
    decimals: int


_ROWS = (
    Unit("", "without unit", 2),
    Unit("%", "percent", 1),
    Unit("‰", "per mille", 1),
    Unit("ppm", "parts per million", 0),
    Unit("ppb", "parts per billion", 0),
    Unit("m", "metre", 2),
    Unit("cm", "centimetre", 1),
    Unit("mm", "millimetre", 0),
    Unit("µm", "micrometre", 0),
    Unit("nm", "nanometre", 0),
    Unit("km", "kilometre", 2),
    Unit("in", "inch", 2),
    Unit("ft", "foot", 1),
    Unit("mi", "mile", 2),
    Unit("nmi", "nautical mile", 2),
    Unit("m²", "square metre", 2),
    Unit("m³", "cubic metre", 2),
    Unit("L", "litre", 1),
    Unit("L/min", "litre per minute", 1),
    Unit("L/s", "litre per second", 2),
    Unit("m³/h", "cubic metre per hour", 1),
    Unit("m/s", "metre per second", 2),
    Unit("cm/s", "centimetre per second", 1),
    Unit("mm/s", "millimetre per second", 0),
    Unit("km/h", "kilometre per hour", 1),
    Unit("mph", "mile per hour", 1),
    Unit("kn", "knot", 1),
    Unit("m/s²", "metre per second squared", 2),
    Unit("mm/h", "millimetre per hour", 1),
    Unit("rad", "radian", 3),
    Unit("rad/s", "radian per second", 3),
    Unit("rad/s²", "radian per second squared", 3),
    Unit("°", "degree", 2),
    Unit("°/s", "degree per second", 2),
    Unit("°/s²", "degree per second squared", 2),
    Unit("arcmin", "arcminute", 2),
    Unit("arcsec", "arcsecond", 2),
    Unit("arcsec/s", "arcsecond per second", 2),
    Unit("rpm", "revolutions per minute", 0),
    Unit("d", "day", 2),
    Unit("h", "hour", 3),
    Unit("min", "minute", 1),
    Unit("s", "second", 2),
    Unit("ms", "millisecond", 1),
    Unit("µs", "microsecond", 0),
    Unit("Hz", "hertz", 1),
    Unit("kHz", "kilohertz", 2),
    Unit("MHz", "megahertz", 3),
    Unit("V", "volt", 2),
    Unit("mV", "millivolt", 0),
    Unit("kV", "kilovolt", 2),
    Unit("A", "ampere", 2),
    Unit("mA", "milliampere", 0),
    Unit("Ah", "ampere hour", 2),
    Unit("mAh", "milliampere hour", 0),
    Unit("W", "watt", 1),
    Unit("mW", "milliwatt", 0),
    Unit("kW", "kilowatt", 2),
    Unit("Wh", "watt hour", 1),
    Unit("kWh", "kilowatt hour", 2),
    Unit("J", "joule", 1),
    Unit("kJ", "kilojoule", 1),
    Unit("Ω", "ohm", 1),
    Unit("°C", "degree Celsius", 1),
    Unit("°F", "degree Fahrenheit", 1),
    Unit("K", "kelvin", 1),
    Unit("Pa", "pascal", 0),
    Unit("hPa", "hectopascal", 1),
    Unit("kPa", "kilopascal", 2),
    Unit("MPa", "megapascal", 3),
    Unit("mbar", "millibar", 1),
    Unit("bar", "bar", 3),
    Unit("psi", "pound per square inch", 1),
    Unit("inHg", "inch of mercury", 2),
    Unit("mmHg", "millimetre of mercury", 1),
    Unit("N", "newton", 2),
    Unit("kN", "kilonewton", 3),
    Unit("N·m", "newton metre", 2),
    Unit("kg", "kilogram", 2),
    Unit("g", "gram", 0),
    Unit("t", "tonne", 3),
    Unit("lb", "pound", 1),
    Unit("µg/m³", "microgram per cubic metre", 1),
    Unit("mg/m³", "milligram per cubic metre", 2),
    Unit("T", "tesla", 6),
    Unit("µT", "microtesla", 1),
    Unit("lx", "lux", 0),
    Unit("W/m²", "watt per square metre", 0),
    Unit("mag/arcsec²", "magnitude per square arcsecond", 2),
    Unit("dBm", "decibel milliwatt", 0),
    Unit("dB", "decibel", 1),
    Unit("bit", "bit", 0),
    Unit("B", "byte", 0),
    Unit("kB", "kilobyte", 1),
    Unit("MB", "megabyte", 1),
    Unit("GB", "gigabyte", 2),
    Unit("kB/s", "kilobyte per second", 1),
    Unit("MB/s", "megabyte per second", 2),
    Unit("Mbit/s", "megabit per second", 2),
    Unit("counts", "counts", 0),
    Unit("ADU", "analogue-to-digital units", 0),
    Unit("px", "pixels", 1),
)
UNITS: dict[str, Unit] = {row.symbol: row for row in _ROWS}
# Whoever adds a unit here says there what it measures.
assert UNITS.keys() - {""} == MEASURES.keys()  # noqa: S101 - of two tables in the source


def unit_of(symbol: str) -> Unit:
    """Give the unit for a symbol, or for another name of one; any other text is a unit itself."""
    known = UNITS.get(OTHER_NAMES.get(symbol, symbol))
    # As written: the table's own name for it may be another than the person's.
    return Unit(symbol, symbol, _DECIMALS) if known is None else known
