"""Commands of the operating system that are run, and whose answers are read."""

from __future__ import annotations

import re
import shlex
from typing import TYPE_CHECKING

from talaia.model.base import Shape, SourceShape
from talaia.model.checks.identifiers import Finding, check_above
from talaia.model.closed_lists import CommandKind, SignalType
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules, argument_fields

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Command, Signal

__all__ = ["PLACEHOLDER", "ProcessConnection", "ProcessRules", "ProcessSource"]

# A word of a command line that stands for an argument: `{ra}`.
PLACEHOLDER = re.compile(r"\{([A-Za-z][A-Za-z0-9_]*)\}")


class ProcessConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="process"):
    """Commands of the operating system that are run, and whose answers are read.

    Attributes:
        file: a JSON command file (``command``, ``devices``) whose devices are taken in; a path
            beside the description or an absolute one; empty for none.
        prefix: stands before every argument line: ``ros2 run``.
        poll: what is read is asked for so often (s).
        timeout: a command that has not ended by then is ended (s).

    """

    file: str = ""
    prefix: str = ""
    poll: float = 1.0
    timeout: float = 10.0


class ProcessSource(SourceShape, frozen=True, kw_only=True, tag="process"):
    """Where a signal comes from when it is a command's answer.

    Attributes:
        run: the arguments of the command whose answer is the value, as one line; there is no
            shell.
        pattern: a regular expression with one group, which is the value; without it the whole
            answer is.
        messages: what an answer means, in words: ``{opened: the dome is opened}``.

    """

    run: str = ""
    pattern: str = ""
    messages: dict[str, str] = {}


class ProcessRules(KindRules[ProcessConnection, ProcessSource]):
    """Checks what is described of commands that are run."""

    kind = ConnectionKind.PROCESS
    source = ProcessSource
    example = "run: dome_servcli client status"
    commands = frozenset({CommandKind.PROCESS})

    def __init__(self, connection: ProcessConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, ProcessSource)

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        yield from check_above(f"{where}.poll", connection.poll, 0)
        yield from check_above(f"{where}.timeout", connection.timeout, 0)
        yield from _line_fits(f"{where}.prefix", connection.prefix, empty=True)

    def signal_fits(self, where: str, signal: Signal, source: ProcessSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if signal.type is SignalType.POSITION:
            yield self.no_positions(where)
            return
        yield from _line_fits(f"{where}.run", source.run)
        yield from _pattern_fits(f"{where}.pattern", source.pattern)

    def command_fits(self, where: str, command: Command) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        findings = [*_line_fits(f"{where}.target", command.target)]
        yield from findings
        if findings:
            return
        # A placeholder is a whole argument, so that what a person writes stays one argument.
        words = shlex.split(command.target)
        places = [found[1] for word in words if (found := PLACEHOLDER.fullmatch(word))]
        fields = argument_fields(where, command)
        for at, field in fields:
            if field not in places:
                problem = f"there is no {{{field}}} in the target"
                yield Finding(at, problem, "write it as its own word")
        filled = {field for _, field in fields}
        for place in places:
            if place not in filled:
                problem = f"nothing fills {{{place}}}"
                yield Finding(f"{where}.target", problem, "add an argument with this field")
        for word in words:
            if not PLACEHOLDER.fullmatch(word) and PLACEHOLDER.search(word):
                problem = f"{word!r}: a placeholder is an argument of its own"
                yield Finding(f"{where}.target", problem, "put spaces round it")


# By what Python's own sentences have in them.
_PATTERN_WORDS = (
    ("unterminated subpattern", "a ( is not closed"),
    ("unbalanced parenthesis", "a ) has no ( before it"),
    ("unterminated character set", "a [ is not closed"),
    ("nothing to repeat", "nothing stands before a *, + or ? that it could repeat"),
    ("multiple repeat", "two of *, + and ? stand one behind the other"),
    ("bad escape", "a \\ stands before a letter that has no meaning with it"),
    ("bad character range", "a range such as a-z is the wrong way round"),
    ("", "something in it has no meaning there"),
)
_AS_PATTERN = r"write as: Alt:(\S+), where ( ) stand round what is read"


def _line_fits(where: str, line: str, *, empty: bool = False) -> Iterator[Finding]:
    try:
        words = shlex.split(line)
    # A quote, or a backslash with nothing behind it: all that the shell's rules know of.
    except ValueError:
        problem = "it cannot be cut into arguments: a quote in it is not closed"
        if line.rstrip().endswith("\\"):
            problem = "it cannot be cut into arguments: nothing stands behind the last \\"
        yield Finding(where, problem, "close every quote, or put \\ before one that is a letter")
        return
    if not words and not empty:
        yield Finding(where, "there is no command", "write: dome_servcli client status")
    # A line end in it would hide arguments from whoever reads the description.
    if any(ord(letter) < 32 for letter in line):
        yield Finding(where, "there are control characters in it", "write it on one line")


def _said_of(error: Exception) -> str:
    """Say what is wrong with a pattern in words that no library has made."""
    said = getattr(error, "msg", "")
    place = getattr(error, "pos", None)
    at = "" if place is None else f" (letter {place + 1})"
    return next((words for part, words in _PATTERN_WORDS if part in said), "it is too long") + at


def _pattern_fits(where: str, pattern: str) -> Iterator[Finding]:
    if not pattern:
        return
    try:
        groups = re.compile(pattern).groups
    # `re` raises these, too, for what is nested or repeated beyond its bounds.
    except (re.error, RecursionError, OverflowError) as error:
        yield Finding(where, f"{pattern!r} is no pattern: {_said_of(error)}", _AS_PATTERN)
        return
    # With several groups it would be a guess which of them is the value.
    if groups != 1:
        problem = f"expected one pair of brackets round the value, found {groups or 'none'}"
        yield Finding(where, problem, _AS_PATTERN)
