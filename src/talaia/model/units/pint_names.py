"""What one name of a unit measures, by the library pint. Imported for names beyond our table only.

pint reads its own list of units when it is first asked (some tenths of a second).
"""

from __future__ import annotations

import math
from functools import cache

import pint

from talaia.model.units.unit_measures import Measure

__all__ = ["measure_by_pint"]

# pint's names of its base units, and ours.
_BASES = {
    "meter": "m",
    "kilogram": "kg",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
    "bit": "bit",
    "count": "count",
}
# Only with these does a prefix make a unit that anybody writes. pint takes any: ``amps`` would be
# attometres a second, ``cfm`` hundredths of a femtometre, ``pct`` a millionth of a millionth carat.
_PREFIXES = {
    *("pico", "nano", "micro", "milli", "centi", "deci", "hecto", "kilo", "mega", "giga", "tera"),
    *("kibi", "mebi", "gibi", "tebi"),
}
_PREFIXED = {
    *("meter", "gram", "second", "ampere", "kelvin", "mole", "candela", "radian", "arcsecond"),
    *("hertz", "newton", "pascal", "joule", "watt", "volt", "farad", "ohm", "siemens", "weber"),
    *("tesla", "henry", "lumen", "lux", "becquerel", "gray", "sievert", "rem", "curie", "liter"),
    *("bar", "torr", "byte", "bit", "baud", "electron_volt", "watt_hour"),
    *(
        "ampere_hour",
        "calorie",
        "poise",
        "stokes",
        "parsec",
        "year",
        "pixel",
        "count",
        "force_gram",
    ),
    *("kilogram_force", "pound_force", "watt_peak"),
}
# Short words that mean something else on a robot: points, charges, gas constants.
_NO_UNITS = {
    *("pint", "dry_pint", "point", "rads", "molar_gas_constant", "elementary_charge"),
    *("speed_of_light", "number_meter", "absorbance_unit"),
}


@cache
def _registry() -> pint.UnitRegistry[float]:
    # Its names are English, and case tells units apart: mW and MW.
    return pint.UnitRegistry(case_sensitive=True, on_redefinition="ignore")


def measure_by_pint(name: str) -> Measure | None:
    """Tell what a name measures; None for one that pint does not know, or whose scale bends."""
    # A name only: pint would reckon with what looks like an expression.
    if not name.isalpha() and not name.startswith("°"):
        return None
    meant = _meant_name(name)
    if not meant:
        return None
    try:
        # Levels (dB) and magnitudes have no even scale: three values tell.
        zero, one, two = (
            _registry().Quantity(float(value), meant).to_base_units() for value in (0, 1, 2)
        )
    # Of what pint raises, much is no `PintError`; and an unknown unit must stop nothing.
    except Exception:  # noqa: BLE001
        return None
    start, step, next_step = zero.magnitude, one.magnitude - zero.magnitude, two.magnitude
    if not math.isclose(next_step - one.magnitude, step, rel_tol=1e-9) or not step > 0:
        return None
    powers: dict[str, int] = {}
    for base, power in one.unit_items():
        exponent = float(str(power))
        # Roots of units are nobody's unit.
        if base not in _BASES or not exponent.is_integer():
            return None
        powers[_BASES[base]] = int(exponent)
    return Measure(tuple(sorted(powers.items())), step, start)


def _meant_name(name: str) -> str:
    """Give pint's whole name of what a person means by a short one; empty for nothing."""
    for prefix, unit, _plural in _registry().parse_unit_name(name):
        known = unit not in _NO_UNITS or name.startswith(unit)
        if known and (not prefix or (prefix in _PREFIXES and unit in _PREFIXED)):
            return f"{prefix}{unit}"
    return ""
