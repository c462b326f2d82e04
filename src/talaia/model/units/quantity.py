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
from talaia.model.errors import UnknownWord
from talaia.model.units.unit import UNITS, unit_of

__all__ = ["PLAIN", "Quantity", "QuantityMismatch", "quantity_of_unit"]

_Powers = tuple[tuple[str, int], ...]


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

    powers: _Powers | None
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
            return not known or (self.powers == () and _same_scale(self, _unit()))
        return self.powers == wanted.powers and _same_scale(self, wanted)

    def _require_same_powers(self, other: Quantity, what: str) -> None:
        if self.powers != other.powers:
            raise QuantityMismatch(f"{self.unit_name} and {other.unit_name} cannot {what}")


PLAIN = Quantity(None)


def quantity_of_unit(symbol: str) -> Quantity:
    """Give what a unit measures; a plain number for none, and for one that nobody knows."""
    try:
        return _QUANTITIES.get(unit_of("", symbol).symbol, PLAIN)
    except UnknownWord:
        return PLAIN


def _same_scale(one: Quantity, other: Quantity) -> bool:
    if one.factor is None or other.factor is None:
        return True
    return math.isclose(one.factor, other.factor) and one.zero == other.zero


def _two_units(one: Quantity, other: Quantity) -> str:
    return f"{one.unit_name} and {other.unit_name} are two units of the same kind"


def _raised(power: int) -> str:
    return "" if power == 1 else "".join("⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".index(c)] for c in str(power))


def _unit(factor: float = 1.0, zero: float = 0.0, **powers: int) -> Quantity:
    return Quantity(tuple(sorted(powers.items())), factor, zero)


# Angles and shares have no dimension, as in SI. Levels in dB, magnitudes and lux stand for
# themselves: nobody works them out from other units.
_QUANTITIES: dict[str, Quantity] = {
    "%": _unit(0.01),
    "m": _unit(m=1),
    "cm": _unit(0.01, m=1),
    "mm": _unit(0.001, m=1),
    "km": _unit(1000.0, m=1),
    "m/s": _unit(m=1, s=-1),
    "km/h": _unit(1 / 3.6, m=1, s=-1),
    "m/s²": _unit(m=1, s=-2),
    "rad": _unit(),
    "rad/s": _unit(s=-1),
    "°": _unit(math.pi / 180),
    "°/s": _unit(math.pi / 180, s=-1),
    "arcsec": _unit(math.pi / 648_000),
    "h": _unit(3600.0, s=1),
    "min": _unit(60.0, s=1),
    "s": _unit(s=1),
    "ms": _unit(0.001, s=1),
    "Hz": _unit(s=-1),
    "rpm": _unit(math.pi / 30, s=-1),
    "V": _unit(A=-1, kg=1, m=2, s=-3),
    "mV": _unit(0.001, A=-1, kg=1, m=2, s=-3),
    "A": _unit(A=1),
    "Ah": _unit(3600.0, A=1, s=1),
    "W": _unit(kg=1, m=2, s=-3),
    "Wh": _unit(3600.0, kg=1, m=2, s=-2),
    "°C": _unit(1.0, 273.15, K=1),
    "K": _unit(K=1),
    "hPa": _unit(100.0, kg=1, m=-1, s=-2),
    "Pa": _unit(kg=1, m=-1, s=-2),
    "lx": _unit(lx=1),
    "mm/h": _unit(0.001 / 3600, m=1, s=-1),
    "mag/arcsec²": _unit(mag=1),
    "dBm": _unit(dBm=1),
    "dB": _unit(dB=1),
    "N": _unit(kg=1, m=1, s=-2),
    "N·m": _unit(kg=1, m=2, s=-2),
    "T": _unit(A=-1, kg=1, s=-2),
    "kg": _unit(kg=1),
    "ppm": _unit(1e-6),
    "B": _unit(B=1),
}
# Whoever adds a unit to the table is asked here for what it measures.
assert _QUANTITIES.keys() == UNITS.keys() - {""}  # noqa: S101 - of two tables in the source
