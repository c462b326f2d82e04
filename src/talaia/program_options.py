"""Options of a long-running program: from its words, the environment, a file, or their defaults.

Every option of a parser can be given in all these ways: ``--port 8443``, ``TALAIA_HUB_PORT=8443``,
or ``port: 8443`` in the file that ``--settings`` (or ``TALAIA_HUB_SETTINGS``) names. The words win
over the environment, and that over the file. A list is replaced, never mixed.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

__all__ = ["OptionRefused", "OptionSource", "parse_options", "print_settings", "settings_text"]

# Of a file: some dozen options are in it.
_MOST_TEXT = 64 * 1024
_TRUE, _FALSE = frozenset({"1", "true", "yes", "on"}), frozenset({"0", "false", "no", "off", ""})
# Ways to ask for something else than to run.
# In an address, after its user's name.
_PASSWORD = re.compile(r"(://[^\s/:@]*):[^\s/@]+@")
_ASKING = frozenset({"help", "settings", "show_settings", "version"})


class OptionRefused(TalaiaError):
    """A value in the environment or in the settings file; a sentence for people."""


class OptionSource(NamedTuple):
    """An option with where its value comes from.

    Attributes:
        name: as in the settings file.
        variable: in the environment.
        value: as the program uses it.
        source: ``--port``, ``TALAIA_HUB_PORT``, the file's name, or ``default``.

    """

    name: str
    variable: str
    value: object
    source: str


def parse_options(
    parser: argparse.ArgumentParser,
    argv: Sequence[str],
    prefix: str,
    environment: Mapping[str, str] = os.environ,
) -> tuple[argparse.Namespace, list[OptionSource]]:
    """Read all options; ``--help`` and wrong words end the process as ever.

    Args:
        parser: of the program's options; gets ``--settings`` and ``--show-settings``.
        argv: the words.
        prefix: of the variables, ``TALAIA_HUB_``.
        environment: the variables.

    Returns:
        The options, and where each comes from.

    Raises:
        OptionRefused: the settings file cannot be read, or does not fit.

    """
    parser.add_argument(
        "--settings",
        type=Path,
        metavar="FILE",
        help=f"options from a file (YAML), each also as {prefix}…; words and variables win",
    )
    parser.add_argument(
        "--show-settings",
        action="store_true",
        help="print every option with where its value comes from, and end",
    )
    given = _given_options(parser, argv)
    path = given.get("settings") or environment.get(f"{prefix}SETTINGS")
    file = _read_file(Path(str(path)), parser) if path else {}
    words: list[str] = []
    sources: dict[str, str] = {}
    _warn_of_unknown(parser, prefix, environment)
    for action in _options_of(parser):
        name, variable = _name_of(action), prefix + action.dest.upper()
        if action.dest in given:
            sources[action.dest] = max(action.option_strings, key=len)
        elif variable in environment:
            words += _words_of(action, environment[variable], variable)
            sources[action.dest] = variable
        elif name in file:
            words += _words_of(action, file[name], f"{path}: {name}")
            sources[action.dest] = str(path)
    # Before the others: what the person has typed comes last and has a message of its own.
    options = _parse_naming_sources(parser, [*words, *argv], sources)
    shown = [
        OptionSource(
            _name_of(action),
            prefix + action.dest.upper(),
            getattr(options, action.dest),
            sources.get(action.dest, "default"),
        )
        for action in _options_of(parser)
    ]
    return options, shown


def settings_text(sources: Sequence[OptionSource]) -> str:
    """Print every option as the settings file has it, with where it comes from and its variable."""
    rows = [(f"{option.name}: {_value_text(option.value)}", option) for option in sources]
    width = max((len(text) for text, _ in rows), default=0)
    return "\n".join(
        f"{text:<{width}}  # {option.source} ({option.variable})" for text, option in rows
    )


def _options_of(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:  # noqa: SLF001 - argparse lists them nowhere else
        if action.option_strings and action.dest not in _ASKING:
            yield action


def _name_of(action: argparse.Action) -> str:
    return action.dest.replace("_", "-")


def _given_options(parser: argparse.ArgumentParser, argv: Sequence[str]) -> dict[str, object]:
    """Tell which options stand among the words: those that no default fills."""
    defaults = {action: (action.default, action.required) for action in parser._actions}  # noqa: SLF001 - see above
    try:
        for action in defaults:
            # What is required may come from elsewhere; it is asked for at the end.
            action.default, action.required = argparse.SUPPRESS, False
        found, _ = parser.parse_known_args(list(argv))
    finally:
        for action, (default, required) in defaults.items():
            action.default, action.required = default, required
    return vars(found)


def _parse_naming_sources(
    parser: argparse.ArgumentParser, words: Sequence[str], sources: Mapping[str, str]
) -> argparse.Namespace:
    """Read the words; a value that is refused is told with where it comes from."""
    kept = parser.error

    def report_error(message: str) -> NoReturn:
        for action in _options_of(parser):
            begin = f"argument {'/'.join(action.option_strings)}: "
            source = sources.get(action.dest, "")
            if message.startswith(begin) and source and source not in action.option_strings:
                # Of a file: the line in it; a variable is one option's alone.
                where = source if source.isidentifier() else f"{source}: {_name_of(action)}"
                message = f"{where}: {message.removeprefix(begin)}"
        kept(message)

    parser.error = report_error  # type: ignore[method-assign]
    try:
        return parser.parse_args(words)
    finally:
        parser.error = kept  # type: ignore[method-assign]


def _warn_of_unknown(
    parser: argparse.ArgumentParser, prefix: str, environment: Mapping[str, str]
) -> None:
    """Say which variables begin as ours do and are none: a slip of the keys changes nothing.

    No refusal, for others may set such: Kubernetes does for a service of that name.
    """
    known = [f"{prefix}SETTINGS", *(prefix + action.dest.upper() for action in _options_of(parser))]
    for name in sorted(set(environment) - set(known)):
        if name.startswith(prefix):
            from difflib import get_close_matches

            near = get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            sys.stderr.write(f"{parser.prog}: {name} is no option{hint}\n")


def _read_file(path: Path, parser: argparse.ArgumentParser) -> dict[str, object]:
    # Most starts have none, and are spared the reader.
    import yaml

    try:
        with path.open(encoding="utf-8") as file:
            read = yaml.safe_load(file.read(_MOST_TEXT)) or {}
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise OptionRefused(f"the settings file {path} cannot be read: {reason}") from error
    except (yaml.YAMLError, RecursionError) as error:
        raise OptionRefused(f"the settings file {path} is no YAML: {error}") from error
    names = {_name_of(action) for action in _options_of(parser)}
    if not isinstance(read, dict):
        raise OptionRefused(f"the settings file {path}: expected lines like 'port: 8443'")
    for name in read:
        if name not in names:
            from difflib import get_close_matches

            near = get_close_matches(str(name), names, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"it has: {', '.join(sorted(names))}"
            raise OptionRefused(f"the settings file {path}: unknown option {name!r}; {hint}")
    return read


def _words_of(action: argparse.Action, value: object, where: str) -> list[str]:
    """Give the words that say the same."""
    option = max(action.option_strings, key=len)
    if action.nargs == 0:
        text = str(value).strip().lower()
        if text not in _TRUE | _FALSE:
            raise OptionRefused(f"{where}: expected true or false, found {value!r}")
        return [option] if text in _TRUE else []
    if isinstance(value, str) and isinstance(action.default, list):
        # A variable holds one text: its parts have spaces or commas between them.
        value = value.replace(",", " ").split()
    # With = between: a value may begin with a dash.
    return [f"{option}={item}" for item in (value if isinstance(value, list) else [value])]


def _value_text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value_text, value))}]"
    # What is printed is copied into questions: a password in an address is not.
    return _PASSWORD.sub(r"\1:***@", str(value))


def print_settings(sources: Sequence[OptionSource]) -> None:
    """Print them to stdout."""
    sys.stdout.write(settings_text(sources) + "\n")
