"""Mistakes of a description as a compiler prints them, and as JSON for editors. Pure."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.model.checks.text_checks import Mistake

__all__ = ["json_text", "mistakes_text", "notes_text"]

# A line is shown so far; what is behind it is told by dots.
_LONGEST_LINE = 110
_WORD = re.compile(r"\w+")


def mistakes_text(name: str, text: str, mistakes: list[Mistake]) -> str:
    """Print each mistake of a file with its line, the place in it, and what to do."""
    lines = text.splitlines()
    parts = [_mistake_text(name, lines, mistake, "error") for mistake in mistakes]
    count = "1 mistake" if len(mistakes) == 1 else f"{len(mistakes)} mistakes"
    return "\n\n".join([*parts, f"{name}: {count}"])


def notes_text(name: str, text: str, notes: Sequence[Mistake]) -> str:
    """Print what is worth a word and is no mistake, in the same form."""
    lines = text.splitlines()
    return "\n\n".join(_mistake_text(name, lines, note, "note") for note in notes)


def _mistake_text(name: str, lines: list[str], mistake: Mistake, level: str) -> str:
    said = [f"{level}: {mistake.problem}"]
    at = f":{mistake.line}:{mistake.column}" if mistake.line else ""
    margin = " " * len(str(mistake.line))
    said.append(f"{margin}--> {name}{at}")
    if 0 < mistake.line <= len(lines):
        # What cannot be seen, or moves the cursor, would end up in somebody's terminal.
        line = "".join(
            letter if letter.isprintable() else " " for letter in lines[mistake.line - 1]
        )
        start = max(0, mistake.column - 1 - _LONGEST_LINE // 2) if len(line) > _LONGEST_LINE else 0
        shown = line[start : start + _LONGEST_LINE]
        before, behind = "…" * bool(start), "…" * (start + _LONGEST_LINE < len(line))
        # The dots before a cut line take their place.
        arrow = " " * (mistake.column - 1 - start + len(before))
        said += [
            f"{margin} |",
            f"{mistake.line} | {before}{shown}{behind}",
            f"{margin} | {arrow}{'^' * _width_of(line, mistake.column - 1)}",
        ]
    said.append(f"{margin} = in {mistake.where}")
    if mistake.remedy:
        said.append(f"{margin} = {mistake.remedy}")
    return "\n".join(said)


def _width_of(line: str, column: int) -> int:
    """Tell how long the word is that begins there."""
    word = _WORD.match(line, column)
    return len(word[0]) if word else 1


def json_text(found: Mapping[str, tuple[Sequence[Mistake], Sequence[Mistake]]]) -> str:
    """Write the mistakes and the notes of each file as a JSON list, one object for each."""
    rows = [
        {"file": name, "level": level, **mistake._asdict()}
        for name, (mistakes, notes) in found.items()
        for level, some in (("error", mistakes), ("note", notes))
        for mistake in some
    ]
    return json.dumps(rows, ensure_ascii=False, indent=2)
