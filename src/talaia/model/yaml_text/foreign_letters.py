"""Letters of other alphabets that look like our own, and wide ones. Pure.

They come from a keyboard that was left in another language, and from pages that were copied; on the
screen nobody can tell them apart.
"""

from __future__ import annotations

import unicodedata

__all__ = ["alike_letters", "with_own_letters"]

_ALIKE = str.maketrans(
    # Cyrillic, Greek.
    "\u0430\u0435\u043e\u0440\u0441\u0443\u0445\u0456\u0458\u0455\u04bb\u0501"
    "\u0410\u0412\u0415\u041a\u041c\u041d\u041e\u0420\u0421\u0422\u0425\u0406"
    "\u03bf\u03b1\u03bd\u03c1\u03c5\u0391\u0392\u0395\u0397\u0399\u039a\u039c"
    "\u039d\u039f\u03a1\u03a4\u03a7\u0396",
    "aeopcyxijshdABEKMHOPCTXIoavpuABEHIKMNOPTXZ",
)


def with_own_letters(text: str) -> str:
    """Write a text with the letters and digits of our keyboard that it looks like."""
    # Wide forms and digits of any alphabet have one of ours by definition.
    plain = (
        letter
        if letter.isascii()
        else str(unicodedata.decimal(letter, ""))
        or (unicodedata.normalize("NFKC", letter) if _is_wide(letter) else letter.translate(_ALIKE))
        for letter in text
    )
    return "".join(plain)


def alike_letters(word: str) -> str:
    """Say which letter of a word only looks like one of ours; empty for none."""
    for letter in word:
        if not letter.isascii() and with_own_letters(letter).isascii():
            name = unicodedata.name(letter, "").lower()
            return f" {letter!r} in it is U+{ord(letter):04X} ({name})"
    return ""


def _is_wide(letter: str) -> bool:
    return unicodedata.east_asian_width(letter) == "F"
