"""What is wrong with a text that is not YAML, in words for people who do not know YAML. Pure.

The parser's sentences name its own parts (tokens, nodes, block mappings), and its place is where it
gave up, often a line or twenty behind the mistake. Here the lines themselves are looked at.

Long, because each kind of mistake has a rule of its own.
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
# What git leaves of two versions.
_MERGE = re.compile(r"(?:<{7}|={7}|>{7})(?:\s|$)")
# Wide ones that are no space of YAML, and those that are not seen at all.
_WIDE = "\u00a0\u1680\u2007\u202f\u205f\u3000"
_ODD_SPACE = re.compile(f"[{_WIDE}\u2000-\u200f\u2060\ufeff]")
_DOUBLE = re.compile(r'"((?:[^"\\]|\\.)*)"')
# A value in quotes that hold more of the same.
_OWN_QUOTES = re.compile(r"(?P<head>.*?:\s+)(?P<mark>['\"])(?P<inner>.+)(?P=mark)\s*\Z")
# ``name: Base, kind: vehicle``, and ``max_speed = 0.5``.
_TWO_KEYS = re.compile(r"[^,:]+,\s*(?P<second>\w+):\s")
_EQUALS = re.compile(r"(?P<key>\w+)\s*=\s*(?P<value>\S.*)\Z")
_WIDE_COLON = re.compile("[\uff1a\ufe55\ua789\u2236\u05c3]")
# Only spaces indent; a tab among or behind them.
_TAB = re.compile(r" *\t\s*\S")
# Numbers of lines in one sentence.
_MOST_SHOWN = 8
_BEGIN = "begin with: talaia: 1; a first description comes from: talaia init"
_IN_QUOTES = "put a text with any of : { } [ ] , # & * ! | > % @ in quotes"


class TextMistake(NamedTuple):
    """A mistake of a text: line and column from 1, what is wrong, what to do.

    Attributes:
        instead: the line as it was most likely meant, to read on by; None where nobody can tell.

    """

    line: int
    column: int
    problem: str
    remedy: str
    instead: str | None = None


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
    if text.strip() in ("...", "--- ...", "---\n..."):
        return TextMistake(1, 1, "there is no description in it", _BEGIN)
    # First: where one of these stands the parser says something else each time.
    for look in (_foreign_line, _odd_space):
        if (told := look(lines, at)) is not None:
            return told
    if _TAB.match(line):
        return _tabs(lines, at)
    # % begins a directive, and @ and ` are kept for later versions of YAML.
    if "cannot start any token" in problem:
        return _bare_sign(line, at, column)
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
        return _bare_sign(lines[begin[0]], *begin)
    if "escape character" in problem or "hexdecimal number" in problem:
        return _escape(line, at, column)
    # A text over several lines begins with > or |, and how it is indented stands behind that.
    if "indentation indicator" in problem or "expected comment or line break" in problem:
        begins = max(line.rfind(">", 0, column + 1), line.rfind("|", 0, column + 1), 0)
        return _bare_sign(line, at, begins)
    if "incompatible YAML" in problem:
        return TextMistake(
            at + 1, column + 1, "a version of YAML that is not read here", "leave out this line", ""
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


def _bare_sign(line: str, at: int, column: int) -> TextMistake:
    """Tell of a text that begins with a sign of YAML's own."""
    # Over several lines the whole of it would have to be in quotes: only one line is mended.
    return TextMistake(
        at + 1,
        column + 1,
        f"a text cannot begin with {line[column : column + 1]}",
        _quoted(line[column:]),
        _with_quotes(line, column),
    )


def _foreign_line(lines: list[str], at: int) -> TextMistake | None:
    """Find a line that no description has, up to where the parser gave up."""
    for number, line in enumerate(lines[: at + 1]):
        if _MERGE.match(line):
            return TextMistake(
                number + 1,
                1,
                "two versions of the file stand here, one after the other (git)",
                "keep one, and delete the lines with <<<<<<<, ======= and >>>>>>>",
            )
        if line.startswith("```"):
            return TextMistake(
                number + 1, 1, "``` is no part of a description", "delete this line", ""
            )
        if line.lstrip().startswith("//"):
            column = len(_indent_of(line)) + 1
            remedy = "begin it with #"
            return TextMistake(number + 1, column, "a comment does not begin with //", remedy, "")
    return None


def _odd_space(lines: list[str], at: int) -> TextMistake | None:
    """Find what looks like a space, or like nothing, and is neither, near the place."""
    for number in range(max(0, at - 1), min(at + 1, len(lines))):
        if (odd := _ODD_SPACE.search(lines[number])) is not None:
            mended = _ODD_SPACE.sub(lambda one: " " if one[0] in _WIDE else "", lines[number])
            return TextMistake(
                number + 1,
                odd.start() + 1,
                "a character that looks like a space, or like none, and is not "
                f"(U+{ord(odd[0]):04X})",
                "write a space instead, or nothing; such ones come from pages that were copied",
                mended,
            )
    return None


def _escape(line: str, at: int, column: int) -> TextMistake:
    """Tell of a backslash in double quotes that begins nothing: a pattern, a folder of Windows."""
    quoted = next(
        (one for one in _DOUBLE.finditer(line) if one.start() <= column < one.end()), None
    )
    inner = quoted[1] if quoted else ""
    single = f"'{inner}'" if inner and "'" not in inner else ""
    return TextMistake(
        at + 1,
        line.rfind("\\", 0, column + 1) + 1 or column + 1,
        "in double quotes a backslash begins a sign of its own, and there is none like this",
        f"put it in single quotes: {single}" if single else "write two backslashes for one",
        line[: quoted.start()] + single + line[quoted.end() :] if quoted and single else None,
    )


def _tabs(lines: list[str], at: int) -> TextMistake:
    """Tell of every line that a tab indents at once: an editor that makes one makes many."""
    # An editor counts it as as many columns as it likes, so nobody can tell what was meant.
    more = [number + 1 for number in range(at + 1, len(lines)) if _TAB.match(lines[number])]
    shown = ", ".join(map(str, more[:_MOST_SHOWN])) + ", …" * (len(more) > _MOST_SHOWN)
    also = f", and so in line{'s' * (len(more) > 1)} {shown}" if more else ""
    return TextMistake(
        at + 1,
        lines[at].index("\t") + 1,
        f"a tab stands where spaces belong{also}",
        "indent with spaces only",
    )


def _word_at(rest: str) -> str:
    return re.split(r"\s#|[,\]}]", rest, maxsplit=1)[0].strip()


def _quoted(rest: str) -> str:
    """Say how the text that begins here is written."""
    word = _word_at(rest)
    return f'put it in quotes: "{word}"' if word and '"' not in word else "put it in quotes"


def _with_quotes(line: str, column: int) -> str | None:
    word = _word_at(line[column:])
    if not word or '"' in word or "\\" in word:
        return None
    return f'{line[:column]}"{word}"{line[column + len(word) :]}'


def _without_colon(lines: list[str], at: int, column: int) -> TextMistake:
    said = lines[at].strip()
    # Without the space the colon is a letter of the word.
    if glued := _NO_SPACE.match(said):
        return _glued(lines[at], at, column, glued)
    if said.startswith("-") and not said.startswith("- "):
        return _dash(lines[at], at, column)
    if equals := _EQUALS.match(said):
        written = f"{equals['key']}: {equals['value']}"
        return TextMistake(
            at + 1,
            column + 1,
            "= stands where a colon belongs",
            f"write: {written}",
            f"{_indent_of(lines[at])}{written}",
        )
    if wide := _WIDE_COLON.search(lines[at]):
        # As they are typed with a keyboard for Chinese or Japanese.
        mended = f"{lines[at][: wide.start()]}: {lines[at][wide.end() :].lstrip()}"
        return TextMistake(
            at + 1,
            wide.start() + 1,
            f"this is no colon, though it looks like one (U+{ord(wide[0]):04X})",
            f"write: {mended.strip()}",
            mended,
        )
    # What is behind # is no part of it.
    word = said.split("#")[0].strip()
    return TextMistake(
        at + 1,
        column + 1,
        f"there is no colon behind {word[:60]!r}",
        f"write: {word[:60]}:",
        f"{_indent_of(lines[at])}{word}:",
    )


def _glued(line: str, at: int, column: int, glued: re.Match[str]) -> TextMistake:
    written = f"{glued['key']}: {glued['value']}"
    return TextMistake(
        at + 1,
        column + 1,
        f"there is no space behind the colon of {glued['key']!r}",
        f"write: {written}",
        f"{_indent_of(line)}{written}",
    )


def _dash(line: str, at: int, column: int) -> TextMistake:
    written = f"- {line.strip()[1:]}"
    return TextMistake(
        at + 1,
        column + 1,
        "there is no space behind the dash",
        f"write: {written}",
        f"{_indent_of(line)}{written}",
    )


def _indent_of(line: str) -> str:
    return line[: len(line) - len(line.lstrip())]


def _second_colon(lines: list[str], at: int, column: int) -> TextMistake:
    line = lines[at]
    begin = len(line) - len(line.lstrip())
    said = line.strip()
    if said.startswith("-") and not said.startswith("- "):
        return _dash(line, at, begin)
    # ``speed:{name: …``: the first colon is a part of the name.
    if (glued := _NO_SPACE.match(said)) and glued["value"][0] in _CLOSED_BY:
        return _glued(line, at, begin, glued)
    key = _KEY.match(line)
    # The first colon made the key, so the second stands in its value.
    if key and key.end("key") < column:
        value = key["rest"].strip()
        if two := _TWO_KEYS.match(value):
            return TextMistake(
                at + 1,
                line.index(value) + two.start("second") + 1,
                "a second key in one line",
                f"write {two['second']}: … in a line of its own, and no comma before it",
            )
        plain = '"' not in value and "\\" not in value
        return TextMistake(
            at + 1,
            column + 1,
            "a second colon in one line",
            f'put a text with a colon in quotes: {key["key"].strip()}: "{value}"'
            if '"' not in value
            else "put a text with a colon in quotes",
            f'{line[: key.end("key")]}: "{value}"' if plain else None,
        )
    # What is odd about this line is often the one above it.
    above = _above(lines, at)
    if above is not None:
        upper = lines[above]
        other = len(upper) - len(upper.lstrip())
        if glued := _NO_SPACE.match(upper.strip()):
            return _glued(upper, above, other, glued)
        if _KEY.match(upper) is None:
            return _without_colon(lines, above, other)
        if other < begin:
            return TextMistake(
                at + 1,
                begin + 1,
                f"this line is {begin - other} further to the right than the one above, "
                "which has a value already",
                f"indent it by {other} spaces, as that one, if it stands beside it",
                f"{' ' * other}{said}",
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
        f"{lines[at].rstrip()}{mark}",
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
        return _not_closed(opened, begin, lines)
    if not closing and at >= len(lines) - 1:
        opened, *place = _last_opened(lines)
        if opened:
            return _not_closed(opened, (place[0], place[1]), lines)
    expected = f"expected , or {closing} here" if closing else "expected a value here"
    return TextMistake(at + 1, column + 1, expected, _IN_QUOTES)


def _not_closed(opened: str, begin: tuple[int, int], lines: list[str]) -> TextMistake:
    at, column = begin
    problem = f"the {opened} that begins here is not closed"
    closing = _CLOSED_BY[opened]
    # Most are of one line.
    return TextMistake(
        at + 1, column + 1, problem, f"add {closing}", f"{lines[at].rstrip()}{closing}"
    )


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
    if at < len(lines) and (end := lines[at].strip()[:1]) in _CLOSED_BY.values() and end:
        begin = len(_indent_of(lines[at]))
        problem = f"this {end} closes nothing that was opened"
        return TextMistake(at + 1, begin + 1, problem, "delete it", "")
    # It ends at the next quote in the text, and what follows that makes no sense.
    quote = _unclosed_quote(lines, first, at)
    if quote is not None:
        return _open_quote(*quote, lines)
    line = lines[at] if at < len(lines) else ""
    begin = len(line) - len(line.lstrip())
    if begin < column and (own := _OWN_QUOTES.match(line)) is not None:
        mark, inner = own["mark"], own["inner"]
        other = "'" if mark == '"' else '"'
        written = f"{other}{inner}{other}" if other not in inner and "\\" not in inner else ""
        return TextMistake(
            at + 1,
            column + 1,
            f"the text ended before this, at the second {mark}",
            f"write it in the other quotes: {written}" if written else f"write {mark}{mark} for it",
            f"{own['head']}{written}" if written else None,
        )
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
        _indented(line.strip(), begin, said),
    )


def _indented(said: str, begin: int, known: list[int]) -> str | None:
    """Put a line as far as the nearest indent; None where two are as near."""
    least = min((abs(one - begin) for one in known), default=0)
    nearest = [one for one in known if abs(one - begin) == least]
    return f"{' ' * nearest[0]}{said}" if len(nearest) == 1 else None


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
