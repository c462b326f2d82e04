"""What common units measure: powers of base units, and how many of those one of it is. Pure.

Angles, bits and things that are counted have base units of their own here, though SI has none for
them: nobody wants turns a minute shown as hertz, or a share shown as an angle. A test holds the
table to what the library pint says; for units that are not in it pint is asked (`unit_text`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["COUNTED", "MEASURES", "OTHER_NAMES", "RARE_MEASURES", "Measure", "Powers"]

Powers = tuple[tuple[str, int], ...]


class Measure(NamedTuple):
    """What a unit measures.

    Attributes:
        powers: of base units, sorted.
        factor: how many of the base units one of it is.
        zero: where its scale begins, in base units: 273.15 for °C.

    """

    powers: Powers
    factor: float
    zero: float = 0.0

    def times(self, other: Measure, power: int) -> Measure:
        """Give the product with a power of another; a scale's own zero does not survive it."""
        powers = dict(self.powers)
        for unit, exponent in other.powers:
            powers[unit] = powers.get(unit, 0) + power * exponent
        kept = tuple(sorted((unit, exponent) for unit, exponent in powers.items() if exponent))
        return Measure(kept, self.factor * other.factor**power)


def _measure(factor: float = 1.0, zero: float = 0.0, **powers: int) -> Measure:
    return Measure(tuple(sorted(powers.items())), factor, zero)


def _energy(factor: float) -> Measure:
    return _measure(factor, kg=1, m=2, s=-2)


def _power(factor: float) -> Measure:
    return _measure(factor, kg=1, m=2, s=-3)


def _pressure(factor: float) -> Measure:
    return _measure(factor, kg=1, m=-1, s=-2)


_TURN = 2 * math.pi
# Levels in dB, magnitudes and dew scales stand for themselves: no factor leads to other units.
MEASURES: dict[str, Measure] = {
    "%": _measure(0.01),
    "‰": _measure(0.001),
    "ppm": _measure(1e-6),
    "ppb": _measure(1e-9),
    # Lengths, areas, volumes, flows.
    "m": _measure(m=1),
    "cm": _measure(0.01, m=1),
    "mm": _measure(0.001, m=1),
    "µm": _measure(1e-6, m=1),
    "nm": _measure(1e-9, m=1),
    "km": _measure(1000.0, m=1),
    "in": _measure(0.0254, m=1),
    "ft": _measure(0.3048, m=1),
    "mi": _measure(1609.344, m=1),
    "nmi": _measure(1852.0, m=1),
    "m²": _measure(m=2),
    "m³": _measure(m=3),
    "L": _measure(0.001, m=3),
    "L/min": _measure(0.001 / 60, m=3, s=-1),
    "L/s": _measure(0.001, m=3, s=-1),
    "m³/h": _measure(1 / 3600, m=3, s=-1),
    # Speeds and accelerations.
    "m/s": _measure(m=1, s=-1),
    "cm/s": _measure(0.01, m=1, s=-1),
    "mm/s": _measure(0.001, m=1, s=-1),
    "km/h": _measure(1 / 3.6, m=1, s=-1),
    "mph": _measure(0.44704, m=1, s=-1),
    "kn": _measure(1852 / 3600, m=1, s=-1),
    "m/s²": _measure(m=1, s=-2),
    "mm/h": _measure(0.001 / 3600, m=1, s=-1),
    # Angles.
    "rad": _measure(rad=1),
    "rad/s": _measure(rad=1, s=-1),
    "rad/s²": _measure(rad=1, s=-2),
    "°": _measure(math.pi / 180, rad=1),
    "°/s": _measure(math.pi / 180, rad=1, s=-1),
    "°/s²": _measure(math.pi / 180, rad=1, s=-2),
    "arcmin": _measure(math.pi / 10_800, rad=1),
    "arcsec": _measure(math.pi / 648_000, rad=1),
    "arcsec/s": _measure(math.pi / 648_000, rad=1, s=-1),
    "rpm": _measure(_TURN / 60, rad=1, s=-1),
    # Times.
    "d": _measure(86_400.0, s=1),
    "h": _measure(3600.0, s=1),
    "min": _measure(60.0, s=1),
    "s": _measure(s=1),
    "ms": _measure(0.001, s=1),
    "µs": _measure(1e-6, s=1),
    "Hz": _measure(s=-1),
    "kHz": _measure(1e3, s=-1),
    "MHz": _measure(1e6, s=-1),
    # Electricity.
    "V": _measure(A=-1, kg=1, m=2, s=-3),
    "mV": _measure(0.001, A=-1, kg=1, m=2, s=-3),
    "kV": _measure(1000.0, A=-1, kg=1, m=2, s=-3),
    "A": _measure(A=1),
    "mA": _measure(0.001, A=1),
    "Ah": _measure(3600.0, A=1, s=1),
    "mAh": _measure(3.6, A=1, s=1),
    "W": _power(1.0),
    "mW": _power(0.001),
    "kW": _power(1000.0),
    "Wh": _energy(3600.0),
    "kWh": _energy(3.6e6),
    "J": _energy(1.0),
    "kJ": _energy(1000.0),
    "Ω": _measure(A=-2, kg=1, m=2, s=-3),
    # Temperatures and pressures.
    "°C": _measure(1.0, 273.15, K=1),
    "°F": _measure(5 / 9, 459.67 * 5 / 9, K=1),
    "K": _measure(K=1),
    "Pa": _pressure(1.0),
    "hPa": _pressure(100.0),
    "kPa": _pressure(1000.0),
    "MPa": _pressure(1e6),
    "mbar": _pressure(100.0),
    "bar": _pressure(1e5),
    "psi": _pressure(0.45359237 * 9.80665 / 0.0254**2),
    "inHg": _pressure(25.4 * 133.322387415),
    "mmHg": _pressure(133.322387415),
    # Forces, masses, what air and water hold.
    "N": _measure(kg=1, m=1, s=-2),
    "kN": _measure(1000.0, kg=1, m=1, s=-2),
    # A torque does its work over an angle: nobody wants it in kWh.
    "N·m": _measure(kg=1, m=2, rad=-1, s=-2),
    "kg": _measure(kg=1),
    "g": _measure(0.001, kg=1),
    "t": _measure(1000.0, kg=1),
    "lb": _measure(0.45359237, kg=1),
    "µg/m³": _measure(1e-9, kg=1, m=-3),
    "mg/m³": _measure(1e-6, kg=1, m=-3),
    # Fields, light, levels.
    "T": _measure(A=-1, kg=1, s=-2),
    "µT": _measure(1e-6, A=-1, kg=1, s=-2),
    "lx": _measure(cd=1, m=-2, rad=2),
    "W/m²": _measure(kg=1, s=-3),
    "mag/arcsec²": Measure((("mag/arcsec²", 1),), 1.0),
    "dBm": _measure(dBm=1),
    "dB": _measure(dB=1),
    # Data, in powers of ten.
    "bit": _measure(bit=1),
    "B": _measure(8.0, bit=1),
    "kB": _measure(8e3, bit=1),
    "MB": _measure(8e6, bit=1),
    "GB": _measure(8e9, bit=1),
    "kB/s": _measure(8e3, bit=1, s=-1),
    "MB/s": _measure(8e6, bit=1, s=-1),
    "Mbit/s": _measure(1e6, bit=1, s=-1),
    "counts": _measure(count=1),
    "ADU": _measure(ADU=1),
    "px": _measure(px=1),
}
# Written here and there, and known to pint by no such name, or as something else.
RARE_MEASURES: dict[str, Measure] = {
    # Standard gravity; ``g`` alone is the gram.
    "gₙ": _measure(9.80665, m=1, s=-2),
    "PS": _power(735.49875),
    "mmH2O": _pressure(9.80665),
    "cmH2O": _pressure(98.0665),
    "inH2O": _pressure(249.08891),
    "G": _measure(1e-4, A=-1, kg=1, s=-2),
    "mG": _measure(1e-7, A=-1, kg=1, s=-2),
    "ppt": _measure(1e-12),
    "kvar": _measure(1000.0, var=1),
    "kVA": _measure(1000.0, VA=1),
}
# Things that are counted, beside what the table has, and scales of their own. Never one for
# another: apparent and reactive power are no power that does work.
COUNTED = frozenset(
    {
        *("pulses", "steps", "ticks", "samples", "messages", "msgs", "events", "packets"),
        *("frames", "photons", "electrons", "cycles", "errors", "people", "points", "pixels"),
        *("mag", "dBi", "dBV", "dBA", "dBFS", "pH", "NTU", "FNU", "PSU", "UVI", "items", "rows"),
        *("VA", "var", "breaths", "beats"),
    }
)
# Other names of units, to the table's symbol or to pint's own name: what people type who do not
# find the sign on the keyboard, and what pint would read as something else.
OTHER_NAMES = {
    "m/s^2": "m/s²",
    "m/s2": "m/s²",
    "deg": "°",
    "deg/s": "°/s",
    "degC": "°C",
    "celsius": "°C",
    "degF": "°F",
    "fahrenheit": "°F",
    "percent": "%",
    "%RH": "%",
    "% RH": "%",
    "deg C": "°C",
    "deg F": "°F",
    "Nm": "N·m",
    "mag/arcsec^2": "mag/arcsec²",
    # Both letters that look like a micro sign, and the letter without its tail.
    "\u03bcm": "µm",
    "um": "µm",
    "\u03bcs": "µs",
    "us": "µs",
    "\u03bcT": "µT",
    "uT": "µT",
    "\u03bcg/m³": "µg/m³",
    "ug/m3": "µg/m³",
    "m3": "m³",
    "m3/h": "m³/h",
    "m2": "m²",
    "l": "L",
    "l/min": "L/min",
    "lpm": "L/min",
    "LPM": "L/min",
    "SLPM": "L/min",
    "slpm": "L/min",
    "sccm": "cm³/min",
    "gpm": "gal/min",
    "GPM": "gal/min",
    "gph": "gal/h",
    "cfm": "ft³/min",
    "CFM": "ft³/min",
    "fpm": "ft/min",
    "kph": "km/h",
    "kmph": "km/h",
    "kmh": "km/h",
    "kt": "kn",
    "kts": "kn",
    "knot": "kn",
    "knots": "kn",
    "RPM": "rpm",
    "sec": "s",
    "hr": "h",
    "mb": "mbar",
    "\u2126": "Ω",
    "Ohm": "Ω",
    "ohm": "Ω",
    "lux": "lx",
    "count": "counts",
    "cts": "counts",
    "cps": "counts/s",
    "cpm": "counts/min",
    "CPM": "counts/min",
    # Of cameras, on a robot; feet are written ft/s.
    "fps": "frames/s",
    "FPS": "frames/s",
    "sps": "samples/s",
    "bpm": "1/min",
    "BPM": "1/min",
    "rev": "turn",
    "r/min": "rpm",
    "PSI": "psi",
    "Bar": "bar",
    "Torr": "torr",
    "inWC": "inH2O",
    "inWc": "inH2O",
    "amp": "A",
    "amps": "A",
    "Amps": "A",
    "g_n": "gₙ",
    "gn": "gₙ",
    "g0": "gₙ",
    "pct": "%",
    "dB(A)": "dBA",
    "rads": "rad",
    "adu": "ADU",
    "pix": "px",
    "pixel": "px",
    '"': "arcsec",
    "'": "arcmin",
    "\u2033": "arcsec",
    "\u2032": "arcmin",
    "°R": "degR",
}
