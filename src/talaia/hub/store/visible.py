"""Text that came from outside, made harmless to read: one line, and nothing hidden in it. Pure."""

from __future__ import annotations

import unicodedata

__all__ = ["visible"]

# Control, format (they turn the direction of writing), surrogate, line and paragraph ends.
_UNSEEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})


def visible(text: str, longest: int) -> str:
    """Write what cannot be seen as escapes, a new line too, and cut to ``longest``."""
    if text.isascii() and text.isprintable():
        return text[:longest]
    return "".join(map(_shown, text[:longest]))[:longest]


def _shown(character: str) -> str:
    if unicodedata.category(character) not in _UNSEEN:
        return character
    return character.encode("unicode_escape").decode("ascii")
