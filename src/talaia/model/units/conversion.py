"""How a value in one unit is shown in another: by a factor and an offset. Pure.

What is stored, exported and judged stays in the unit that the description gives.
"""

from __future__ import annotations

import math
from difflib import get_close_matches
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.units.unit import UNITS, unit_of
from talaia.model.units.unit_measures import MEASURES, OTHER_NAMES
from talaia.model.units.unit_text import measure_of

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Conversion", "conversion_between", "likely_unit", "shown_units", "units_like"]

# As descriptions have them.
_MOST_DECIMALS = 9
# Digits of a factor: what floats add beyond them is no part of a unit's definition.
_DIGITS = 14
# Letters of a word, which may have a slip; symbols are too short for that.
_LONG = 5
_LIKENESS = 0.66
# What people call a unit, of those in the table.
_NAMES = {
    word.casefold(): symbol
    for word, symbol in (
        *((one.name, symbol) for symbol, one in UNITS.items()),
        *((f"{one.name}s", symbol) for symbol, one in UNITS.items()),
        *((one.name.replace("metre", "meter"), symbol) for symbol, one in UNITS.items()),
        *((symbol, symbol) for symbol in UNITS if "/" in symbol),
        *OTHER_NAMES.items(),
    )
    if symbol in MEASURES
}


class Conversion(NamedTuple):
    """How values of a unit are shown.

    Attributes:
        unit: in which they are shown.
        factor, offset: a value times the one plus the other is what is shown.
        decimals: digits after the point that make sense for the shown unit.

    """

    unit: str
    factor: float
    offset: float
    decimals: int

    def convert(self, value: float) -> float:
        """Give a stored value as it is shown."""
        return value * self.factor + self.offset

    def of_difference(self) -> Conversion:
        """Give the one for what is the difference of two values: 1 °C more is 1.8 °F more."""
        return self._replace(offset=0.0)

    def digits_for(self, decimals: int) -> int:
        """Give the digits that show a change as finely as ``decimals`` do in the stored unit."""
        finer = decimals - round(math.log10(self.factor))
        return max(0, min(_MOST_DECIMALS, finer))


def conversion_between(stored: str, shown: str) -> Conversion | None:
    """Tell how values of ``stored`` are shown in ``shown``; None where they measure different."""
    one, other = measure_of(stored), measure_of(shown)
    if one is None or other is None or one.powers != other.powers:
        return None
    factor = _plain_number(one.factor / other.factor)
    # Both zeros are in base units, as 273.15 of °C is.
    offset = _plain_number((one.zero - other.zero) / other.factor)
    found = Conversion(shown, factor, offset, 0)
    known = OTHER_NAMES.get(shown, shown) in UNITS
    decimals = unit_of(shown).decimals if known else found.digits_for(unit_of(stored).decimals)
    return found._replace(decimals=decimals)


def shown_units(*choices: Mapping[str, str]) -> dict[str, Conversion]:
    """Give the conversion for each stored unit; of several choices the first that has it counts.

    What cannot be converted is left out: it is shown as it is stored.
    """
    chosen: dict[str, str] = {}
    for choice in reversed(choices):
        chosen |= choice
    found = {
        stored: conversion_between(stored, shown)
        for stored, shown in chosen.items()
        if stored != shown
    }
    return {stored: conversion for stored, conversion in found.items() if conversion is not None}


def units_like(symbol: str) -> list[str]:
    """List the common units in which values of a unit can be shown; it is none of them itself."""
    measure = measure_of(symbol)
    if measure is None:
        return []
    own = OTHER_NAMES.get(symbol, symbol)
    return [
        other
        for other, found in MEASURES.items()
        if found.powers == measure.powers and other != own
    ]


def likely_unit(text: str) -> str:
    """Give the common unit that a text nobody knows is most likely meant to be; empty if unclear.

    Where those that are spelled alike measure different things, none is proposed: °F is no angle.
    """
    if measure_of(text) is not None:
        return ""
    folded = {symbol.casefold(): symbol for symbol in MEASURES if len(symbol) > 1}
    # Small letters for capitals first: ``KPA``, ``hz``.
    if text.casefold() in folded:
        return folded[text.casefold()]
    # Of a few letters every other symbol is alike: ``var`` is no slip of ``bar``.
    over, line, _ = text.partition("/")
    if not line and len(text) < _LONG:
        return ""
    meant = [_NAMES[word] for word in get_close_matches(text.casefold(), _NAMES, 4, _LIKENESS)]
    if line:
        meant = [one for one in meant if one.partition("/")[0] == over]
    kinds = {MEASURES[symbol].powers for symbol in meant}
    return meant[0] if len(kinds) == 1 else ""


def _plain_number(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
