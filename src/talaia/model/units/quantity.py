"""What unit a calculation gives: dimensions as powers of base units. Pure.

A plain number in a calculation, or a signal without a unit, may be of any unit: in a sum it takes
the unit of its neighbour, and what is multiplied or divided by it keeps its dimension while its
scale is from then on the author's word: ``{base/speed} / 3.6`` may be in m/s where the signal is in
km/h. Nothing is ever converted here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from talaia.errors import TalaiaError
from talaia.model.units.unit_measures import MEASURES, Powers
from talaia.model.units.unit_text import measure_of

__all__ = ["PLAIN", "Quantity", "QuantityMismatch", "quantity_of_unit"]

# What SI counts as pure numbers: a sum may hold them, and so may what they are multiplied with.
_PURE = frozenset({"rad", "count"})
# Apparent and reactive power, which units keep apart from what does work.
_POWER = frozenset({"VA", "var"})


class QuantityMismatch(TalaiaError):
    """Two quantities that cannot be added, compared or given for each other."""


class Quantity(NamedTuple):
    """What a part of a calculation measures.

    Attributes:
        powers: of base units, sorted; ``None`` for a plain number, which fits every unit.
        factor: how many of the base units one of it is; ``None`` where a plain number has been
            multiplied in.
        zero: where its scale begins, in base units: 273.15 for °C.

    """

    powers: Powers | None
    factor: float | None = None
    zero: float = 0.0

    @property
    def symbol(self) -> str:
        """The unit of the table that it is in, or could be in; empty where there is none."""
        # The first that fits: rad/s and Hz are one to SI.
        for symbol, known in _QUANTITIES.items():
            if known.powers == self.powers and _same_scale(known, self):
                return symbol
        return ""

    @property
    def unit_name(self) -> str:
        """What people would call it: a unit's symbol, or powers of base units."""
        if self.powers is None:
            return "a plain number"
        if self.symbol:
            return self.symbol if self.factor is not None else f"{self.symbol} or its like"
        said = "·".join(f"{unit}{_raised(power)}" for unit, power in self.powers)
        scale = "" if self.factor is None or self.factor == 1 else f"{self.factor:g} "
        return f"{scale}{said}" if said else f"{scale}without dimension"

    def times(self, other: Quantity, sign: int = 1) -> Quantity:
        """Give the product; the quotient with ``sign`` -1."""
        # Two plain numbers may still become anything.
        if self.powers is None and other.powers is None:
            return PLAIN
        powers = dict(self.powers or ())
        for unit, power in other.powers or ():
            powers[unit] = powers.get(unit, 0) + sign * power
        kept = tuple(sorted((unit, power) for unit, power in powers.items() if power))
        # A product with a temperature that begins at its own zero is on nobody's scale.
        if self.factor is None or other.factor is None or self.zero or other.zero:
            return Quantity(kept)
        return Quantity(kept, self.factor * other.factor**sign)

    def plus(self, other: Quantity, sign: int = 1) -> Quantity:
        """Give the sum; the difference with ``sign`` -1.

        Raises:
            QuantityMismatch: they have different dimensions or scales.

        """
        if self.powers is None or other.powers is None:
            known = other if self.powers is None else self
            # ``{outside} + 273.15`` is no temperature in °C any more, or it is: the author's word.
            return known._replace(factor=None, zero=0.0) if known.zero else known
        self._require_same_powers(other, "be added" if sign > 0 else "be subtracted")
        if self.factor is None or other.factor is None:
            return self if other.factor is None else other
        # Not equal: factors are products of floats.
        if not math.isclose(self.factor, other.factor):
            raise QuantityMismatch(_two_units(self, other))
        if self.zero and other.zero:
            # The difference of two temperatures is as good in °C as in K.
            return self if sign > 0 else Quantity(self.powers)
        # Kelvin less a temperature in °C: on nobody's scale.
        if other.zero and sign < 0:
            return Quantity(self.powers)
        return self if self.zero else other

    def beside(self, other: Quantity) -> Quantity:
        """Give what the smaller of the two is in, or what a comparison compares.

        Raises:
            QuantityMismatch: they have different dimensions or scales.

        """
        if self.powers is None or other.powers is None:
            return other if self.powers is None else self
        self._require_same_powers(other, "be compared")
        if self.factor is None or other.factor is None:
            return self if other.factor is None else other
        # The smaller of °C and K would be the wrong one.
        if not _same_scale(self, other):
            raise QuantityMismatch(_two_units(self, other))
        return self

    def fits_unit(self, symbol: str) -> bool:
        """Tell whether a signal of this unit may hold it."""
        wanted = quantity_of_unit(symbol)
        if self.powers is None:
            return True
        if wanted.powers is None:
            # A ratio; or what has no unit in the table, as square metres.
            known = any(unit.powers == self.powers for unit in _QUANTITIES.values())
            return not known or (self.powers == () and _same_scale(self, _RATIO))
        return self.powers == wanted.powers and _same_scale(self, wanted)

    def _require_same_powers(self, other: Quantity, what: str) -> None:
        if self.powers != other.powers:
            raise QuantityMismatch(f"{self.unit_name} and {other.unit_name} cannot {what}")


PLAIN = Quantity(None)
_WATT = Quantity(MEASURES["W"].powers)


def quantity_of_unit(symbol: str) -> Quantity:
    """Give what a unit measures; a plain number for none, and for one that nobody knows."""
    measure = measure_of(symbol)
    if measure is None:
        return PLAIN
    powers = Quantity(tuple(part for part in measure.powers if part[0] not in _PURE))
    # A voltage times a current is either, and which one only its author knows.
    for name, power in measure.powers:
        for _ in range(abs(power) if name in _POWER else 0):
            sign = 1 if power > 0 else -1
            powers = powers.times(Quantity(((name, 1),)), -sign).times(_WATT, sign)
    return Quantity(powers.powers, measure.factor, measure.zero)


def _same_scale(one: Quantity, other: Quantity) -> bool:
    if one.factor is None or other.factor is None:
        return True
    return math.isclose(one.factor, other.factor) and one.zero == other.zero


def _two_units(one: Quantity, other: Quantity) -> str:
    return f"{one.unit_name} and {other.unit_name} are two units of the same kind"


def _raised(power: int) -> str:
    return "" if power == 1 else "".join("⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".index(c)] for c in str(power))


_RATIO = Quantity((), 1.0)
_QUANTITIES: dict[str, Quantity] = {symbol: quantity_of_unit(symbol) for symbol in MEASURES}
