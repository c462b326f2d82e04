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

__all__ = ["main", "option_words"]

_SCRIPTS = {
    "bash": """\
# talaia completion for bash: source <(talaia completion bash)
_talaia() {
    local word=${COMP_WORDS[COMP_CWORD]}
    if [ "$COMP_CWORD" -eq 1 ]; then
        mapfile -t COMPREPLY < <(compgen -W "$(talaia completion --words)" -- "$word")
    elif [[ $word == -* ]]; then
        local words
        words=$(talaia completion --words "${COMP_WORDS[1]}")
        mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
    fi
}
complete -o default -F _talaia talaia
""",
    "zsh": """\
#compdef talaia
# talaia completion for zsh: source <(talaia completion zsh)
_talaia() {
    if (( CURRENT == 2 )); then
        compadd -- ${(f)"$(talaia completion --words)"}
    elif [[ $words[CURRENT] == -* ]]; then
        compadd -- ${(f)"$(talaia completion --words $words[2])"}
    else
        _files
    fi
}
compdef _talaia talaia
""",
    "fish": """\
# talaia completion for fish: talaia completion fish | source
complete -c talaia -n __fish_use_subcommand -f -a '(talaia completion --words)'
complete -c talaia -n 'not __fish_use_subcommand; and string match -q -- "-*" (commandline -ct)' \\
    -a '(talaia completion --words (commandline -opc)[2])'
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
        nargs="?",
        const="",
        metavar="COMMAND",
        help="print the commands, or the options of one, one in each line",
    )
    options = parser.parse_args(argv)
    # It imports this module no earlier than this command runs.
    from talaia.cli.main import COMMANDS

    if options.words is not None:
        words = option_words(options.words, COMMANDS) if options.words else list(COMMANDS)
        sys.stdout.write("".join(f"{word}\n" for word in words))
        return 0
    if options.shell is None:
        parser.error("name a shell: bash, zsh or fish")
    sys.stdout.write(_SCRIPTS[options.shell])
    return 0


def option_words(name: str, commands: Mapping[str, Subcommand]) -> list[str]:
    """List the options of a command; none of one that is not there or whose part is missing."""
    if name not in commands:
        return []

    def report_parser(parser: argparse.ArgumentParser, *_: object, **__: object) -> NoReturn:
        raise _Found(parser)

    kept = argparse.ArgumentParser.parse_known_args
    # Every way of reading words goes through it.
    argparse.ArgumentParser.parse_known_args = report_parser  # type: ignore[assignment]
    try:
        importlib.import_module(commands[name].module).main([])
    except _Found as found:
        actions = found.parser._actions  # noqa: SLF001 - argparse lists them nowhere else
        return sorted({option for action in actions for option in action.option_strings})
    except ImportError:
        return []
    finally:
        argparse.ArgumentParser.parse_known_args = kept  # type: ignore[method-assign]
    return []
