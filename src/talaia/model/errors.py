"""What can be wrong with a site description."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.errors import TalaiaError
from talaia.model.yaml_text.foreign_letters import alike_letters
from talaia.model.yaml_text.meant_words import list_words, meant_word, near_words, quoted_text

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
    """The file is missing, is not text, or is not YAML.

    Its ``text`` is what can be shown of it, where `where` names a line of that; else empty.
    """

    text = ""


class UnknownWord(DescriptionError):
    """A word that must come from a closed list does not."""

    def __init__(self, where: str, what: str, word: str, known: Iterable[str]) -> None:
        """Offer the nearest known word when there is one, else the list.

        Its ``meant`` is that nearest word, or empty.
        """
        # As they are written: a member of an enumeration would be shown as Python does.
        words = [str(one) for one in known]
        self.word = word
        self.meant = meant_word(word, words)
        # An empty list would be no help, nor a word that cannot be had.
        if not words:
            remedy = f"no {what} is described: describe it, or leave this out"
        elif self.meant and word:
            remedy = f"did you mean {self.meant!r}?{alike_letters(word)}"
        else:
            key = "use" if word else f"add {where.rpartition('.')[2]}: and"
            remedy = f"{key} one of: {list_words(near_words(word, words))}"
        # Nothing was named: to call that unknown would lead astray.
        problem = f"unknown {what} {quoted_text(word)}" if word else f"which {what} is meant?"
        super().__init__(where, problem, remedy)
