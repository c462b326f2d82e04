"""``talaia completion``: what a shell asks for when somebody presses Tab.

The scripts ask this program for words, so they never say what the installed version does not have.
Commands are listed without importing any; options come from the parser of the command itself.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.cli.main import Subcommand

__all__ = ["main", "words_at"]

_SCRIPTS = {
    "bash": """\
# talaia completion for bash: source <(talaia completion bash)
_talaia() {
    local words
    # Where it ends, the words that a person wrote follow: up to the one at the cursor.
    words=$(talaia completion --words "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "${COMP_WORDS[COMP_CWORD]}")
}
complete -o default -F _talaia talaia
""",
    "zsh": """\
#compdef talaia
# talaia completion for zsh: source <(talaia completion zsh)
_talaia() {
    local -a found
    found=(${(f)"$(talaia completion --words "${(@)words[2,CURRENT]}" 2>/dev/null)"})
    if (( $#found )); then
        compadd -- $found
    else
        _files
    fi
}
compdef _talaia talaia
""",
    "fish": """\
# talaia completion for fish: talaia completion fish | source
function __talaia_words
    set -l before (commandline -opc)
    talaia completion --words $before[2..-1] (commandline -ct | string collect --allow-empty) \\
        2>/dev/null
end
complete -c talaia -n __fish_use_subcommand -f
complete -c talaia -a '(__talaia_words)'
""",
}


class _Found(BaseException):
    """The parser that a command was about to read its words with; no error of a command's own."""

    def __init__(self, parser: argparse.ArgumentParser) -> None:
        super().__init__()
        self.parser = parser


def main(argv: Sequence[str]) -> int:
    """Print the script for a shell, or words for it."""
    parser = argparse.ArgumentParser(
        "talaia completion",
        description="Print what makes a shell complete talaia's commands and options: "
        "source <(talaia completion bash), the same with zsh, or talaia completion fish | source.",
    )
    parser.add_argument("shell", choices=sorted(_SCRIPTS), nargs="?", help="print its script")
    parser.add_argument(
        "--words",
        nargs=argparse.REMAINDER,
        metavar="WORD",
        help="print what may stand at the last of these words, one in each line",
    )
    options = parser.parse_args(argv)
    # It imports this module no earlier than this command runs.
    from talaia.cli.main import COMMANDS

    if options.words is not None:
        words = words_at(options.words, COMMANDS)
        sys.stdout.write("".join(f"{word}\n" for word in words))
        return 0
    if options.shell is None:
        parser.error("name a shell: bash, zsh or fish")
    sys.stdout.write(_SCRIPTS[options.shell])
    return 0


def words_at(words: Sequence[str], commands: Mapping[str, Subcommand]) -> list[str]:
    """List what may stand at the last word: commands, words of a command, options, or choices.

    Args:
        words: those behind ``talaia``, up to the one that is being written, which may be empty.
        commands: all that there are.

    Returns:
        All that begin as the last word does; none where a file or a text of one's own stands.

    """
    *before, last = words or [""]
    if not before:
        return [name for name in commands if name.startswith(last)]
    parser = _parser_of(before[0], commands)
    if parser is None:
        return []
    awaited = None
    for word in before[1:]:
        parser, awaited = _read_word(parser, word, awaited)
    if awaited is not None:
        found = _choices_of(awaited)
    elif last.startswith("-"):
        found = sorted(
            {option for action in _actions_of(parser) for option in action.option_strings}
        )
    else:
        found = [
            choice
            for action in _actions_of(parser)
            if not action.option_strings
            for choice in _choices_of(action)
        ]
    return [word for word in found if word.startswith(last)]


def _read_word(
    parser: argparse.ArgumentParser, word: str, awaited: argparse.Action | None
) -> tuple[argparse.ArgumentParser, argparse.Action | None]:
    """Give the parser of the words behind this one, and the option that waits for its value."""
    for action in _actions_of(parser):
        if word in action.option_strings:
            # With 0 it is one that is there or not.
            return parser, action if action.nargs != 0 else None
        # Of words of its own it has the parser of each.
        if isinstance(action.choices, dict) and not awaited and word in action.choices:
            return action.choices[word], None
    return parser, None


def _choices_of(action: argparse.Action) -> list[str]:
    # Ranges of numbers are choices, too.
    return [str(choice) for choice in action.choices or ()]


def _actions_of(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    return parser._actions  # noqa: SLF001 - argparse lists them nowhere else


def _parser_of(name: str, commands: Mapping[str, Subcommand]) -> argparse.ArgumentParser | None:
    """Give the parser of a command; none of one that is not there or whose part is missing."""
    if name not in commands:
        return None

    def report_parser(parser: argparse.ArgumentParser, *_: object, **__: object) -> NoReturn:
        raise _Found(parser)

    kept = argparse.ArgumentParser.parse_known_args
    # Every way of reading words goes through it.
    argparse.ArgumentParser.parse_known_args = report_parser  # type: ignore[assignment]
    try:
        importlib.import_module(commands[name].module).main([])
    except _Found as found:
        return found.parser
    except ImportError:
        return None
    finally:
        argparse.ArgumentParser.parse_known_args = kept  # type: ignore[method-assign]
    return None
