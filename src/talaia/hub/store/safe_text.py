"""Text that came from outside, made harmless to read and to open in a spreadsheet. Pure."""

from __future__ import annotations

import unicodedata

__all__ = ["safe_cell", "safe_text"]

# Control, format (they turn the direction of writing), surrogate, line and paragraph ends.
_UNSEEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
# A spreadsheet takes a cell that begins with one of these for a formula, and works it out.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def safe_text(text: str, longest: int) -> str:
    """Give one line with nothing hidden in it: escapes stand for it; cut to ``longest``."""
    if text.isascii() and text.isprintable():
        return text[:longest]
    return "".join(map(_escape_character, text[:longest]))[:longest]


def safe_cell(text: str) -> str:
    """Write a text so that a spreadsheet takes it for a text and for nothing else."""
    return f"'{text}" if text.startswith(_FORMULA) else text


def _escape_character(character: str) -> str:
    if unicodedata.category(character) not in _UNSEEN:
        return character
    return character.encode("unicode_escape").decode("ascii")
