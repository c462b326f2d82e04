"""INDI's numbers: plain or sexagesimal, and their printf-like formats.

From the INDI white paper, version 1.7, "INDI formats": a number is written in any form that
``scanf`` reads, or as two or three numbers between ``:``, ``;`` or blanks. The format
``%<w>.<f>m`` shows sexagesimal: f = 9 is ``:mm:ss.ss``, 8 ``:mm:ss.s``, 6 ``:mm:ss``,
5 ``:mm.m`` and 3 ``:mm``.
"""

from __future__ import annotations

import math
import re

__all__ = ["format_number", "parse_number", "write_number"]

_PLAIN = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,4})?\Z")
_SIXTY = re.compile(
    r"(?P<sign>[+-]?)\s*(?P<whole>\d+(\.\d*)?)\s*[:; ]\s*(?P<min>\d+(\.\d*)?)"
    r"(\s*[:; ]\s*(?P<sec>\d+(\.\d*)?))?\Z"
)
_FORMAT = re.compile(
    r"%(?P<flags>[-+ #0]*)(?P<width>\d{0,3})(\.(?P<frac>\d{0,2}))?l*(?P<kind>[a-zA-Z])\Z"
)
# Smallest part shown, of a unit: what follows the second dot decides it.
_PARTS = {3: 60, 5: 600, 6: 3600, 8: 36_000, 9: 360_000}
_MAX_TEXT = 64


def parse_number(text: str) -> float:
    """Read a number; NaN where it is none (drivers do send ``nan``, and worse).

    The sign holds for all parts: ``-0:30`` is -0.5.
    """
    text = text.strip()[:_MAX_TEXT]
    if _PLAIN.match(text):
        return float(text)
    match = _SIXTY.match(text)
    if match is None:
        return math.nan
    value = float(match["whole"]) + float(match["min"]) / 60 + float(match["sec"] or 0) / 3600
    return -value if match["sign"] == "-" else value


def write_number(value: float) -> str:
    """Write a finite number so that any driver reads it back to the same value.

    Raises:
        ValueError: NaN or infinity, which must never reach an actuator.

    """
    if not math.isfinite(value):
        raise ValueError(f"{value} is not a number that can be sent")
    return repr(float(value))


def format_number(value: float, how: str) -> str:
    """Show a number by a driver's format; one that is no format shows it plainly."""
    match = _FORMAT.match(how.strip())
    if match is None or not math.isfinite(value):
        return f"{value:g}"
    if match["kind"] == "m":
        return _format_sexagesimal(value, int(match["frac"] or 3)).rjust(int(match["width"] or 0))
    if match["kind"] in "diu":
        return str(round(value))
    if match["kind"] not in "eEfFgG":
        return f"{value:g}"
    digits = int(match["frac"]) if match["frac"] else (0 if match["frac"] == "" else 6)
    return f"{value:.{digits}{match['kind']}}"


def _format_sexagesimal(value: float, fraction: int) -> str:
    """Round once, in the smallest part that is shown, so that 59.99 s never shows as 60."""
    base = _PARTS.get(fraction, 3600)
    sign = "-" if value < 0 else ""
    total = round(abs(value) * base)
    whole, rest = divmod(total, base)
    if base == 60:
        return f"{sign}{whole}:{rest:02d}"
    if base == 600:
        return f"{sign}{whole}:{rest // 10:02d}.{rest % 10}"
    minutes, parts = divmod(rest, base // 60)
    seconds, hundredths = divmod(parts, base // 3600)
    tail = {3600: "", 36_000: f".{hundredths}", 360_000: f".{hundredths:02d}"}[base]
    return f"{sign}{whole}:{minutes:02d}:{seconds:02d}{tail}"
