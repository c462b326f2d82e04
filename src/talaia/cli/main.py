"""The command line ``talaia <command> …``: finds and runs the subcommand."""

from __future__ import annotations

import importlib
import os
import select
import sys
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, cast

from talaia import __version__
from talaia.cli.errors import PartMissing
from talaia.errors import TalaiaError
from talaia.quiet_import import own_process, quiet_imports
from talaia.ros_installation import ForeignRos, use_ros

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from types import ModuleType

__all__ = ["COMMANDS", "main"]


class Subcommand(NamedTuple):
    """One subcommand: where its ``main(argv)`` is, what it does, the extra it needs."""

    # Imported only when the command is run: the hub's libraries need not be there for `check`.
    module: str
    summary: str
    # As in ``pip install talaia[…]``; empty where the core is enough.
    extra: str


COMMANDS = {
    "demo": Subcommand(
        "talaia.cli.demo.command_line",
        "simulated robots with hub, gateway and dashboard",
        "hub,sim",
    ),
    "demo-indi": Subcommand(
        "talaia.cli.demo.indi_command_line",
        "INDI's simulators with hub, gateway and dashboard",
        "hub,observatory",
    ),
    "configure": Subcommand(
        "talaia.cli.configure", "a window to describe a robot and start everything", "configurator"
    ),
    "up": Subcommand(
        "talaia.cli.up", "hub and gateway of a site together, in your browser", "hub,ros2"
    ),
    "generate": Subcommand(
        "talaia.cli.generate", "write a deployment: compose project and systemd units", ""
    ),
    "hub": Subcommand(
        "talaia.hub.command_line", "the server: accounts, history and dashboard", "hub"
    ),
    "gateway": Subcommand(
        "talaia.gateway.program", "the process that connects a robot to the hub", "ros2"
    ),
    "sim": Subcommand("talaia.cli.demo.sim", "simulated robots", "sim"),
    "twin": Subcommand(
        "talaia.sim.twin.command_line",
        "the simulated vehicle beside the real one, following it",
        "sim",
    ),
    "account": Subcommand("talaia.cli.account", "create or change an account", "hub"),
    "enrol": Subcommand("talaia.cli.enrol", "create a gateway's key", "hub"),
    "audit": Subcommand("talaia.cli.auditing.main", "verify a hub's audit log", "hub"),
    "import": Subcommand(
        "talaia.cli.importing.command_line",
        "import recordings and tables into the history",
        "hub,recording",
    ),
    "anomalies": Subcommand(
        "talaia.cli.anomalies.command_line", "judge a table of signals with a detector", "hub"
    ),
    "plan": Subcommand(
        "talaia.cli.planning.command_line", "plan a night of a telescope from a file", "planner"
    ),
    "watch": Subcommand("talaia.cli.scripting.watch", "print live values of a hub", "client"),
    "get": Subcommand("talaia.cli.scripting.get", "read the history of a hub", "client"),
    "call": Subcommand("talaia.cli.scripting.call", "ask a device to do something", "client"),
    "record": Subcommand(
        "talaia.cli.scripting.record", "begin, end and fetch recordings of a hub", "client"
    ),
    "backup": Subcommand(
        "talaia.cli.backup", "copy a hub's database and data while it runs", "hub"
    ),
    "restore": Subcommand("talaia.cli.restore", "restore a backup", "hub"),
    "move-files": Subcommand(
        "talaia.cli.moving.main", "move a hub's recordings and pictures into a bucket", "hub,s3"
    ),
    "history": Subcommand(
        "talaia.cli.history.main", "move a site's history to another server, or list them", "hub"
    ),
    "probe": Subcommand("talaia.cli.probe", "list what a live robot offers", "ros2"),
    "init": Subcommand("talaia.cli.init", "write a site description of a live robot", ""),
    "check": Subcommand("talaia.cli.checking.command_line", "check a site description", ""),
    "upgrade": Subcommand(
        "talaia.cli.upgrade", "upgrade a site description to the newest format", ""
    ),
    "update": Subcommand(
        "talaia.cli.updating.update", "signed releases of a gateway: install, try, keep", "gateway"
    ),
    "doctor": Subcommand(
        "talaia.cli.examining.doctor", "say what is here, what runs, and what is missing", ""
    ),
    "support-bundle": Subcommand(
        "talaia.cli.support.support_bundle", "gather what a helper needs, without secrets", ""
    ),
    "docs": Subcommand("talaia.cli.examining.docs", "print a guide of the documentation", ""),
    "extensions": Subcommand("talaia.cli.extensions", "list the installed extensions", ""),
    "completion": Subcommand(
        "talaia.cli.examining.completion",
        "print what makes a shell complete commands and options",
        "",
    ),
    "schema": Subcommand("talaia.cli.schema", "print the JSON schema of the site description", ""),
}
# These make keys, accounts, histories, recordings or descriptions: whatever they write is its
# owner's alone (files 0600, folders 0700), however the machine is set up.
_PRIVATE = frozenset(
    {
        *("account", "audit", "backup", "configure", "demo", "demo-indi", "enrol", "gateway"),
        *("history", "hub", "import", "move-files", "record", "restore", "support-bundle"),
        *("up", "update"),
    }
)


# Their modules have a ``parse_words`` as well.
_WITH_ROS = frozenset({"demo", "sim", "twin", "up"})


def main(argv: Sequence[str] | None = None) -> int:
    """Run one subcommand.

    Returns:
        The process's exit code: 0 done, 2 refused or failed.

    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    first = arguments[0] if arguments else "--help"
    if first in ("-h", "--help", "help"):
        print(_help_text())
        return 0
    if first == "--version":
        print(f"talaia {__version__}")
        return 0
    command = COMMANDS.get(first)
    if command is None:
        # Last, where a terminal or a log still shows it.
        print(f"{_help_text()}\n\ntalaia: unknown command {first!r}", file=sys.stderr)
        return 2
    try:
        if argv is None and _needs_ros(arguments):
            if first in _WITH_ROS:
                # Wrong words are refused before the process begins anew for ROS.
                _load_module(first, command).parse_words(arguments[1:])
            # Before the imports: where ROS comes from wheels the process begins anew. What is
            # missing is said by whoever needs it, if anybody does.
            with suppress(ForeignRos):
                use_ros(ordered=True, bridged=first == "gateway")
        run = _load_main(first, command)
        if argv is None and first in _PRIVATE:
            # For what it starts as well, which inherits it.
            os.umask(0o077)
        if argv is None:
            own_process()
        # A hub and a gateway are imported once their words are read.
        with _missing_parts(first, command):
            code = run(arguments[1:])
            sys.stdout.flush()
            return code
    except BrokenPipeError:
        if not _is_unread():
            raise
        return 0
    # On purpose, so a sentence is enough; all else is a mistake of ours, and shows its traceback.
    except TalaiaError as error:
        print(_mistakes_of(arguments, error) or f"talaia {first}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        # 128 and the number of SIGINT, as shells have it.
        return 130


def _is_unread() -> bool:
    """Tell whether whoever reads the output has had enough (``| head``); then no more is written.

    A pipe or socket of another kind that broke is a mistake of ours.
    """
    output = select.poll()
    output.register(sys.stdout.fileno(), 0)
    if not output.poll(0):
        return False
    # Python flushes at its end once more.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return True


def _mistakes_of(arguments: Sequence[str], error: TalaiaError) -> str:
    """Print a description that a command could not use as `check` does; empty of another error."""
    from talaia.model.errors import DescriptionError

    names = [word for word in arguments[1:] if word.endswith((".yaml", ".yml"))]
    if not isinstance(error, DescriptionError) or not names:
        return ""
    from talaia.cli.checking.check import check_file
    from talaia.cli.checking.mistake_texts import mistakes_text

    checked = ((name, check_file(Path(name))) for name in names)
    wrong = [(name, report) for name, report in checked if report.mistakes]
    return "\n\n".join(mistakes_text(name, one.text, one.mistakes) for name, one in wrong)


def _needs_ros(arguments: Sequence[str]) -> bool:
    """Tell whether a command will import ROS 2; where this says no, it is found out later."""
    if arguments[0] != "gateway":
        # What these start inherits it. Who asks for help waits for no ROS.
        asks = {"-h", "--help"} & set(arguments[1:])
        return arguments[0] in _WITH_ROS and not asks
    for word in arguments[1:]:
        # Of a gateway's words only its description is a file of YAML.
        if word.endswith((".yaml", ".yml")) and Path(word).is_file():
            with suppress(OSError):
                return b"ros2" in Path(word).read_bytes()
    return False


def _help_text() -> str:
    rows = "\n".join(f"  {name:<10} {command.summary}" for name, command in COMMANDS.items())
    return (
        f"usage: talaia COMMAND …    (talaia {__version__})\n\n{rows}\n\n"
        "talaia COMMAND --help shows the options of a command."
    )


@contextmanager
def _missing_parts(name: str, command: Subcommand) -> Iterator[None]:
    """Say which extra brings a module that is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        # A module of our own that is missing is no extra that one could install, but for the
        # simulators, which are a package of their own.
        ours = error.name is None or error.name.startswith("talaia")
        if ours and error.name != "talaia.sim":
            raise
        missing = "talaia-simulators" if ours else str(error.name)
        raise PartMissing(f"talaia {name}", missing, command.extra) from error


def _load_main(name: str, command: Subcommand) -> Callable[[Sequence[str]], int]:
    return cast("Callable[[Sequence[str]], int]", _load_module(name, command).main)


def _load_module(name: str, command: Subcommand) -> ModuleType:
    with _missing_parts(name, command), quiet_imports():
        return importlib.import_module(command.module)
