"""Reads a unit as people write it: ``µg/m³``, ``L/min``, ``kWh``, ``°F``.

Products, quotients and powers are read here, in a small grammar of its own: a description comes
from a gateway, and a general reader of expressions could be kept busy by ``9**9**9``. What a single
name measures the table of `unit_measures` says, or else the library pint, which is imported when
the first name is met that the table does not have.
"""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import TYPE_CHECKING

from talaia.model.units.unit_measures import COUNTED, MEASURES, OTHER_NAMES, RARE_MEASURES, Measure

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["LONGEST_UNIT", "measure_of"]

# Letters of a symbol without signs; what is longer is a word.
_LONGEST_SYMBOL = 4
# In letters; the longest that is in use, W/(m²·sr·nm), has a dozen.
LONGEST_UNIT = 24
# Letters of any alphabet, and the signs that stand for a unit.
_LETTER = r"[^\W\d_⁰¹²³⁴⁵⁶⁷⁸⁹]"
_NAME = rf"{_LETTER}+|%|‰|°{_LETTER}*|'|\""
_TOKEN = re.compile(
    rf"\s*(?:(?P<name>{_NAME})(?:\^?(?P<power>[-−]?\d)|(?P<raised>⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]))?"
    r"|(?P<one>1)(?=\s*/)|(?P<sign>[·⋅×*/.]))\s*"
)
# ``W/(m²·K)``: what stands in the brackets is all below the line.
_BELOW = re.compile(r"([^()]*)/\s*\(([^()/]*)\)\Z")
# What a detector counts: a letter with a charge.
_ELECTRONS = re.compile(r"\be[-⁻](?=[/·* ]|\Z)")
_ENERGY, _LENGTH = MEASURES["J"].powers, MEASURES["m"].powers
_RAISED = str.maketrans("⁻−⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")


@lru_cache(maxsize=2000)
def measure_of(text: str) -> Measure | None:
    """Tell what a unit measures; None where nobody knows it. No text makes it raise."""
    text = OTHER_NAMES.get(text, text)
    known = MEASURES.get(text) or RARE_MEASURES.get(text)
    if known is not None:
        return known
    if not text or len(text) > LONGEST_UNIT:
        return None
    # No unit is without dimension here, as a plain number is: what counts things names them.
    plain = _ELECTRONS.sub("electrons", text.replace(" per ", "/"))
    factors = list(_factors(f"1{plain}" if plain.startswith("/") else plain))
    if not factors or None in factors:
        return None
    product = _product_of([factor for factor in factors if factor is not None])
    return product if math.isfinite(product.factor) and product.factor > 0 else None


def _product_of(factors: list[tuple[Measure, int]]) -> Measure:
    # A scale with a zero of its own has none in a product: W/°C is per degree.
    if len(factors) == 1 and factors[0][1] == 1:
        return factors[0][0]
    product = Measure((), 1.0)
    for measure, power in factors:
        product = product.times(measure, power)
    # A force and a lever are a torque: N·m, lbf·ft, kgf·cm.
    levers = [power == 1 and measure.powers == _LENGTH for measure, power in factors]
    if product.powers == _ENERGY and len(factors) == len("FL") and any(levers):
        return product.times(MEASURES["rad"], -1)
    return product


def _factors(text: str) -> Iterator[tuple[Measure, int] | None]:
    """Give each name's measure with its power; None for what cannot be read."""
    if (below := _BELOW.match(text)) is not None:
        yield from _factors(below[1].strip() or "1/")
        yield from (part and (part[0], -part[1]) for part in _factors(below[2]))
        return
    at, sign, wants_name = 0, 1, True
    while at < len(text):
        token = _TOKEN.match(text, at)
        if token is None:
            yield None
            return
        at = token.end()
        if token["sign"]:
            # Two signs side by side, or one at the beginning, mean nothing.
            if wants_name:
                yield None
                return
            sign, wants_name = (-1 if token["sign"] == "/" else 1), True
            continue
        # Two names side by side: ``deg F`` is no product of a degree and a farad.
        if not wants_name:
            yield None
            return
        wants_name = False
        if token["one"]:
            continue
        power = int((token["power"] or token["raised"] or "1").translate(_RAISED))
        if not power:
            yield None
            return
        measure = _measure_of_name(token["name"])
        yield measure and (measure, sign * power)
        sign = 1
    if wants_name and text != "1/":
        yield None


def _measure_of_name(name: str) -> Measure | None:
    name = OTHER_NAMES.get(name, name)
    found = MEASURES.get(name) or RARE_MEASURES.get(name)
    if found is not None:
        return found
    if name in COUNTED:
        # Pixels are no pulses: each is a dimension of its own.
        return Measure(((name, 1),), 1.0)
    # Here and not above: most descriptions need no more than the table.
    from talaia.model.units.pint_names import measure_by_pint

    measure = measure_by_pint(name)
    if measure is None and len(name) > _LONGEST_SYMBOL and name.istitle():
        # ``Volts``: case tells symbols apart (mW, MW), and no whole words.
        return _measure_of_name(name.lower())
    return measure
