"""``talaia call``: one command, and what has become of it."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from talaia.cli.scripting.hub_options import (
    FAILED,
    add_hub_options,
    hub_parser,
    open_client,
    quiet_pipe,
)

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from talaia.client import Client, CommandProgress, CommandResult, ConfirmationNeeded

__all__ = ["main"]

# It may have been done and it may not.
_UNKNOWN = 3
_TRUTHS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}


def main(argv: Sequence[str]) -> int:
    """Ask for a command; 0 when it was done, 1 when not, 3 when nobody knows."""
    parser = hub_parser(
        "call",
        "Ask a device to do something once, and wait for what becomes of it. Exit codes: 0 done,"
        " 1 refused, failed or cancelled, 2 not asked, 3 unknown: it may have been done and it may"
        " not, so look at the device before you ask again. Ctrl-C ends the waiting, not the"
        " command.",
    )
    parser.add_argument("command", help="SITE/DEVICE/COMMAND, or SITE/DEVICE.COMMAND")
    parser.add_argument("argument", nargs="*", metavar="NAME=VALUE", help="in the site's own units")
    parser.add_argument("--yes", action="store_true", help="it is meant; do not ask")
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="how long to wait")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    add_hub_options(parser)
    options = parser.parse_args(argv)
    # Arrays and the wire, which --help and wrong words do not wait for.
    from talaia.client import BadSettings, ConfirmationNeeded

    # A command's name has no dot, and people know `device.command` from elsewhere.
    options.command = options.command.replace(".", "/")
    arguments = dict(_read_argument(text) for text in options.argument)
    with quiet_pipe(), open_client(options) as client:
        try:
            result = _call(client, options, arguments, confirm=options.yes)
        except ConfirmationNeeded as asked:
            if not sys.stdin.isatty():
                raise BadSettings(
                    f"{asked.command} ({asked.name}) wants to be confirmed; if it is meant, add"
                    " --yes"
                ) from asked
            if not _confirmed(asked):
                return FAILED
            result = _call(client, options, arguments, confirm=True)
        _print_result(result, as_json=options.json)
    if result.succeeded:
        return 0
    return _UNKNOWN if result.phase == "unknown" else FAILED


def _call(
    client: Client,
    options: argparse.Namespace,
    arguments: dict[str, bool | float | str],
    *,
    confirm: bool,
) -> CommandResult:
    report = None if options.json else _print_progress
    return client.call_command(
        options.command, arguments, confirm=confirm, timeout_s=options.timeout, report=report
    )


def _read_argument(text: str) -> tuple[str, bool | float | str]:
    """Read ``name=value``; quotation marks around a value make it a text.

    Raises:
        BadSettings: there is no name.

    """
    name, equals, value = text.partition("=")
    if not name or not equals:
        from talaia.client import BadSettings

        raise BadSettings(f"{text!r}: expected NAME=VALUE")
    if len(value) > 1 and value[0] == value[-1] and value[0] in "\"'":
        return name, value[1:-1]
    if value.lower() in _TRUTHS:
        return name, _TRUTHS[value.lower()]
    try:
        # A whole number stays one: some arguments take nothing else.
        return name, int(value)
    except ValueError:
        pass
    try:
        return name, float(value)
    except ValueError:
        return name, value


def _confirmed(asked: ConfirmationNeeded) -> bool:
    print(f"{asked.name} ({asked.command})? [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in {"y", "yes"}


def _print_progress(progress: CommandProgress) -> None:
    share = f" {progress.progress:.0%}" if progress.progress else ""
    said = f": {progress.message}" if progress.message else ""
    print(f"{progress.phase}{share}{said}", file=sys.stderr, flush=True)


def _print_result(result: CommandResult, *, as_json: bool) -> None:
    if as_json:
        import msgspec

        print(msgspec.json.encode(result._asdict()).decode())
        return
    said = f": {result.message}" if result.message else ""
    print(f"{result.command} {result.phase}{said}")
