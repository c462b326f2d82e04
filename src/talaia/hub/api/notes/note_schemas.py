"""What is said about notes."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from talaia.hub.store.sites.notes import LONGEST_NOTE

__all__ = ["NoteAsk", "NoteChangeAsk", "NoteList", "NoteShape"]

_LAST_US = 2**53
# The short name of a device or a signal; empty for all of them.
_NAME = Field(default="", max_length=200, pattern=r"^[^\x00]*$")


class _Shape(BaseModel):
    """A key that is not described is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class NoteAsk(_Shape):
    """Write a note at a moment (``from_us`` and ``to_us`` are the same), or over a span.

    It is about the whole site, one ``device``, or one ``signal`` of it by its short name. A text
    may have several lines.
    """

    device: str = _NAME
    signal: str = _NAME
    from_us: int = Field(ge=0, le=_LAST_US)
    to_us: int = Field(ge=0, le=_LAST_US)
    text: str = Field(min_length=1, max_length=LONGEST_NOTE, pattern=r"^[^\x00]*$")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.to_us < self.from_us:
            raise ValueError("a note ends before it begins")
        if self.signal and not self.device:
            raise ValueError("a signal is one of a device")
        if not self.text.strip():
            raise ValueError("a note without words says nothing")
        return self


class NoteChangeAsk(NoteAsk):
    """Change a note; ``base`` is the version that you have seen."""

    base: int = Field(ge=1, le=2**31 - 1)


class NoteShape(_Shape):
    """A note. ``version`` counts its changes from 1; ``may_change``: you may change and remove it.

    ``who`` wrote it; ``changed_by`` is who wrote it last.
    """

    id: str
    device: str
    signal: str
    from_us: int
    to_us: int
    text: str
    who: str
    created_us: int
    changed_us: int
    changed_by: str
    version: int
    may_change: bool


class NoteList(_Shape):
    """The last to begin first. ``more``: earlier ones were left out."""

    notes: list[NoteShape]
    more: bool
