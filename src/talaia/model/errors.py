"""What can be wrong with a site description."""

from __future__ import annotations

from difflib import get_close_matches
from typing import TYPE_CHECKING

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["DescriptionError", "NotReadable", "UnknownWord"]


class DescriptionError(TalaiaError):
    """The description cannot be used as written."""

    def __init__(self, where: str, problem: str, remedy: str = "") -> None:
        """Keep place, problem and remedy apart, so a form can show each where it belongs."""
        super().__init__(where, problem, remedy)
        self.where = where
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        tail = f"; {self.remedy}" if self.remedy else ""
        return f"{self.where}: {self.problem}{tail}"


class NotReadable(DescriptionError):
    """The file is missing, is not text, or is not YAML."""


class UnknownWord(DescriptionError):
    """A word that must come from a closed list does not."""

    def __init__(self, where: str, what: str, word: str, known: Iterable[str]) -> None:
        """Offer the nearest known word when there is one, else the list."""
        words = sorted(known)
        # Looser than difflib's own 0.6, so that short words with a slip are still met.
        near = get_close_matches(word, words, n=1, cutoff=0.5)
        remedy = f"did you mean {near[0]!r}?" if near else f"use one of: {', '.join(words)}"
        super().__init__(where, f"unknown {what} {word!r}", remedy)
        self.word = word
