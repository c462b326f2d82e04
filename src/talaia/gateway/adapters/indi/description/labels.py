"""Names and labels of drivers as words for addresses, names for people, and units. Pure."""

from __future__ import annotations

import re
import unicodedata
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["is_describable", "label_without_unit", "shown_name", "unit_in_label", "word_of"]

# The longest name of a device, property or element that a description takes.
_MAX_NAME = 64
# Drivers write the unit at the end of a label: `Wind speed (kph)`.
_UNIT_AT_END = re.compile(r"\(([^()]{1,12})\)\s*\Z")
# By drivers' spelling, small: the symbol of `model.units`. Empty for those it has none for.
_UNITS = {
    "c": "°C",
    "°c": "°C",
    "kph": "km/h",
    "km/h": "km/h",
    "m/s": "m/s",
    "mm": "mm",
    "mm/h": "mm/h",
    "deg": "°",
    "s": "s",
    "sec": "s",
    "ms": "ms",
    "%": "%",
    "hpa": "hPa",
    # A millibar is a hectopascal.
    "mb": "hPa",
    "m": "m",
    "v": "V",
    "a": "A",
    "w": "W",
    "um": "",
    "arcsecs/s": "",
    # Written so (`numbers.format_number`), but sent as hours and degrees with a fraction.
    "hh:mm:ss": "h",
    "dd:mm:ss": "°",
}


def word_of(name: str, taken: Iterable[str] = (), otherwise: str = "indi") -> str:
    """Make a word for an address of any name, other than those that are taken."""
    # Accents fall off their letters; what has no Latin letter falls away.
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    word = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")[:50]  # room for a number behind it
    if not word or not word[0].isalpha():
        word = f"{otherwise}_{word}".rstrip("_")
    used, unique, count = set(taken), word, 2
    while unique in used:
        unique, count = f"{word}_{count}", count + 1
    return unique


def is_describable(name: str) -> bool:
    """Tell whether a description can name something so: not too long, and no unseen characters."""
    return 0 < len(name) <= _MAX_NAME and name.isprintable() and bool(name.strip())


def shown_name(name: str) -> str:
    """Make a name that people can read of any text; never empty."""
    seen = "".join(letter if letter.isprintable() else " " for letter in name)
    return " ".join(seen.split())[:100] or "unnamed"


def unit_in_label(label: str) -> str:
    """Read the unit at a label's end; empty where there is none that is known."""
    match = _UNIT_AT_END.search(label)
    return "" if match is None else _UNITS.get(match[1].strip().lower(), "")


def label_without_unit(label: str) -> str:
    """Give a label without the brackets at its end."""
    return _UNIT_AT_END.sub("", label)
