"""What is wrong with a text that is not YAML, in words for people who do not know YAML. Pure.

The parser's sentences name its own parts (tokens, nodes, block mappings), and its place is where it
gave up, often a line or twenty behind the mistake. Here the lines themselves are looked at.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

    import yaml

__all__ = ["TextMistake", "explain_yaml_error"]

# A key with its colon; in a list it may stand behind dashes.
_KEY = re.compile(r"\s*(?:- )*(?P<key>[^\s#'\"{}\[\],:][^#'\"{}\[\],:]*):(?P<rest>\s.*|$)")
# Not an address: http://host has its slashes behind the colon.
_NO_SPACE = re.compile(r"(?P<key>[A-Za-z_][\w]*):(?P<value>[^\s/:].*)")
_QUOTES = {'"': "double", "'": "single"}
# What opens, and what closes it.
_CLOSED_BY = {"[": "]", "{": "}"}
_IN_QUOTES = "put a text with any of : { } [ ] , # & * ! | > % @ in quotes"


class TextMistake(NamedTuple):
    """A mistake of a text: line and column from 1, what is wrong, what to do."""

    line: int
    column: int
    problem: str
    remedy: str


def explain_yaml_error(error: yaml.MarkedYAMLError, text: str) -> TextMistake:
    """Tell what is wrong where the parser gave up."""
    lines = text.split("\n")
    mark = error.problem_mark or error.context_mark
    at, column = (mark.line, mark.column) if mark else (0, 0)
    line = lines[at] if at < len(lines) else ""
    problem = error.problem or ""
    context = error.context_mark
    # Where what is not closed begins; the parser looks for its end to the end of the text.
    begin = (context.line, context.column) if context else (at, column)
    # First: where a tab stands the parser says something else each time.
    if "\t" in line[: len(line) - len(line.lstrip())]:
        tab = line.index("\t")
        return TextMistake(
            at + 1, tab + 1, "a tab stands where spaces belong", "indent with spaces only"
        )
    # % begins a directive, and @ and ` are kept for later versions of YAML.
    if "cannot start any token" in problem:
        letter = line[column : column + 1]
        return TextMistake(
            at + 1, column + 1, f"a text cannot begin with {letter}", _quoted(line[column:])
        )
    # Found out in the next line; the context is where the key begins.
    if "could not find expected ':'" in problem:
        return _without_colon(lines, *begin)
    # A colon where a value ends; the line above may be to blame.
    if "mapping values are not allowed" in problem:
        return _second_colon(lines, at, column)
    if "unexpected end of stream" in problem and "quoted" in (error.context or ""):
        return _open_quote(*begin, lines)
    # Told where the next key begins, be it twenty lines below the bracket.
    if "expected ',' or" in problem or "expected node content" in problem:
        return _open_bracket(lines, begin, at, column)
    # ``key: - item`` looks right, and is none of the two ways to write a list.
    if "block sequence entries are not allowed" in problem:
        return TextMistake(
            at + 1,
            column + 1,
            "a list cannot begin behind a colon",
            "write each - in a line of its own below, or the list as [one, two]",
        )
    if "did not find expected '-'" in problem:
        return TextMistake(
            at + 1,
            column + 1,
            "this line belongs to a list, and has no dash",
            "write a list with - before each item, or a mapping with a name and : for each part",
        )
    # A block ended that nobody meant to end.
    if "did not find expected key" in problem or "expected <block end>" in problem:
        return _odd_indent(lines, begin[0], at, column)
    # ``*`` and ``&`` begin an alias and an anchor, which have names.
    if "alphabetic or numeric character" in problem:
        letter = line[begin[1] : begin[1] + 1]
        return TextMistake(
            begin[0] + 1,
            begin[1] + 1,
            f"a text cannot begin with {letter}",
            _quoted(lines[begin[0]][begin[1] :]),
        )
    if "<document start>" in problem:
        return TextMistake(
            at + 1,
            column + 1,
            "something stands behind the end of the description",
            "begin every key of it at the same column, or leave this out",
        )
    return TextMistake(
        at + 1, column + 1, f"this is not YAML: {problem}", f"look at this line: {_IN_QUOTES}"
    )


def _quoted(rest: str) -> str:
    """Say how the text that begins here is written."""
    word = re.split(r"\s#|[,\]}]", rest, maxsplit=1)[0].strip()
    return f'put it in quotes: "{word}"' if word and '"' not in word else "put it in quotes"


def _without_colon(lines: list[str], at: int, column: int) -> TextMistake:
    said = lines[at].strip()
    # Without the space the colon is a letter of the word.
    if glued := _NO_SPACE.match(said):
        return TextMistake(
            at + 1,
            column + 1,
            f"there is no space behind the colon of {glued['key']!r}",
            f"write: {glued['key']}: {glued['value']}",
        )
    if said.startswith("-") and not said.startswith("- "):
        return TextMistake(
            at + 1, column + 1, "there is no space behind the dash", f"write: - {said[1:]}"
        )
    # What is behind # is no part of it.
    word = said.split("#")[0].strip()
    return TextMistake(
        at + 1, column + 1, f"there is no colon behind {word[:60]!r}", f"write: {word[:60]}:"
    )


def _second_colon(lines: list[str], at: int, column: int) -> TextMistake:
    line = lines[at]
    begin = len(line) - len(line.lstrip())
    said = line.strip()
    if said.startswith("-") and not said.startswith("- "):
        return TextMistake(
            at + 1, begin + 1, "there is no space behind the dash", f"write: - {said[1:]}"
        )
    key = _KEY.match(line)
    # The first colon made the key, so the second stands in its value.
    if key and key.end("key") < column:
        value = key["rest"].strip()
        return TextMistake(
            at + 1,
            column + 1,
            "a second colon in one line",
            f'put a text with a colon in quotes: {key["key"].strip()}: "{value}"'
            if '"' not in value
            else "put a text with a colon in quotes",
        )
    # What is odd about this line is often the one above it.
    above = _above(lines, at)
    if above is not None:
        upper = lines[above]
        other = len(upper) - len(upper.lstrip())
        if glued := _NO_SPACE.match(upper.strip()):
            return TextMistake(
                above + 1,
                other + 1,
                f"there is no space behind the colon of {glued['key']!r}",
                f"write: {glued['key']}: {glued['value']}",
            )
        if _KEY.match(upper) is None:
            return _without_colon(lines, above, other)
        if other < begin:
            return TextMistake(
                at + 1,
                begin + 1,
                f"this line is {begin - other} further to the right than the one above, "
                "which has a value already",
                f"indent it by {other} spaces, as that one, if it stands beside it",
            )
    return TextMistake(at + 1, column + 1, "a colon is not expected here", _IN_QUOTES)


def _above(lines: list[str], at: int) -> int | None:
    """Give the nearest line above that says something."""
    # Neither blank lines nor comments.
    for other in range(at - 1, -1, -1):
        said = lines[other].strip()
        if said and not said.startswith("#"):
            return other
    return None


def _open_quote(at: int, column: int, lines: list[str]) -> TextMistake:
    mark = lines[at][column : column + 1]
    kind = _QUOTES.get(mark, "")
    return TextMistake(
        at + 1,
        column + 1,
        f"the {kind} quote that begins here is not closed",
        f"add {mark} at its end",
    )


def _unclosed_quote(lines: list[str], first: int, last: int) -> tuple[int, int] | None:
    """Find a line in which a quote begins and does not end."""
    for at in range(first, min(last + 1, len(lines))):
        found = ""
        column = 0
        for position, letter in enumerate(lines[at]):
            if found:
                if letter == found:
                    found = ""
            # In the middle of a word it is a letter as any other.
            elif letter in _QUOTES and not lines[at][position - 1 : position].strip(" [{,:-("):
                found, column = letter, position
            elif letter == "#" and not lines[at][position - 1 : position].strip():
                break
        if found:
            return at, column
    return None


def _open_bracket(lines: list[str], begin: tuple[int, int], at: int, column: int) -> TextMistake:
    opened = lines[begin[0]][begin[1] : begin[1] + 1] if begin[0] < len(lines) else ""
    closing = _CLOSED_BY.get(opened, "")
    # An open quote swallows brackets.
    quote = _unclosed_quote(lines, begin[0], at)
    if quote is not None:
        return _open_quote(*quote, lines)
    # In one line something is left out within it; over several its end is missing.
    if closing and begin[0] != at:
        return _not_closed(opened, *begin)
    if not closing and at >= len(lines) - 1:
        opened, *place = _last_opened(lines)
        if opened:
            return _not_closed(opened, *place)
    expected = f"expected , or {closing} here" if closing else "expected a value here"
    return TextMistake(at + 1, column + 1, expected, _IN_QUOTES)


def _not_closed(opened: str, at: int, column: int) -> TextMistake:
    problem = f"the {opened} that begins here is not closed"
    return TextMistake(at + 1, column + 1, problem, f"add {_CLOSED_BY[opened]}")


def _last_opened(lines: list[str]) -> tuple[str, int, int]:
    """Find the innermost bracket that is open at the end of a text."""
    # Not aware of quotes: asked only for a text that ends too soon.
    opened: list[tuple[str, int, int]] = []
    for at, line in enumerate(lines):
        for column, letter in enumerate(line):
            if letter in _CLOSED_BY:
                opened.append((letter, at, column))
            elif opened and letter == _CLOSED_BY[opened[-1][0]]:
                opened.pop()
    return opened[-1] if opened else ("", 0, 0)


def _odd_indent(lines: list[str], first: int, at: int, column: int) -> TextMistake:
    # It ends at the next quote in the text, and what follows that makes no sense.
    quote = _unclosed_quote(lines, first, at)
    if quote is not None:
        return _open_quote(*quote, lines)
    line = lines[at] if at < len(lines) else ""
    begin = len(line) - len(line.lstrip())
    if begin < column:
        # Something stands behind a value that was already complete, as behind a quote.
        return TextMistake(
            at + 1, column + 1, "this is too much behind what stands before", _IN_QUOTES
        )
    said = sorted(set(_open_indents(lines, at)))
    some = ", ".join(map(str, said[:-1]))
    words = f"{some} or {said[-1]}" if some else str(said[-1] if said else 0)
    return TextMistake(
        at + 1,
        begin + 1,
        f"this line is indented by {begin} spaces, as none above that it could stand beside",
        f"indent it by {words}: as far as the lines that it belongs to",
    )


def _open_indents(lines: list[str], at: int) -> Iterator[int]:
    """Give the indents of the line above, and of all that it stands in."""
    # Only lines that are further to the left than all below them hold this one.
    least: int | None = None
    for other in range(at - 1, -1, -1):
        said = lines[other].strip()
        indent = len(lines[other]) - len(lines[other].lstrip())
        if said and not said.startswith("#") and (least is None or indent < least):
            least = indent
            yield indent
