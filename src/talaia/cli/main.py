"""``talaia <word> …``: one word for each thing a person wants to start or to ask."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, NamedTuple, cast

from talaia import __version__
from talaia.cli.errors import PartMissing
from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["WORDS", "main"]


class Word(NamedTuple):
    """One subcommand: where its ``main(argv)`` is, what it does, the extra it needs."""

    module: str
    summary: str
    extra: str


WORDS = {
    "demo": Word("talaia.cli.demo.ros2", "simulated robots and the whole product", "hub,sim"),
    "demo-indi": Word(
        "talaia.cli.demo.indi", "INDI's own simulators and the whole product", "hub,observatory"
    ),
    "configure": Word(
        "talaia.cli.configure", "a window to describe a robot and start everything", "configurator"
    ),
    "up": Word("talaia.cli.up", "hub and gateway of a site together, in your browser", "hub,ros2"),
    "generate": Word("talaia.cli.generate", "a folder that runs a site for good", ""),
    "hub": Word("talaia.hub.run", "the server: accounts, history, dashboard", "hub"),
    "gateway": Word("talaia.gateway.run", "the process beside the robot", "ros2"),
    "sim": Word("talaia.sim.run", "robots that are not there", "sim"),
    "account": Word("talaia.cli.account", "make a person's account", "hub"),
    "enrol": Word("talaia.cli.enrol", "make a gateway's key", "hub"),
    "import": Word(
        "talaia.cli.importing.main", "bring recordings and tables into a history", "hub,recording"
    ),
    "backup": Word("talaia.cli.backup", "copy a hub's database and data while it runs", "hub"),
    "restore": Word("talaia.cli.restore", "bring a backup back", "hub"),
    "probe": Word("talaia.cli.probe", "list what a live robot offers", "ros2"),
    "init": Word("talaia.cli.init", "write a site description of a live robot", ""),
    "check": Word("talaia.cli.check", "say whether a site description is right", ""),
    "upgrade": Word("talaia.cli.upgrade", "bring a site description to the newest format", ""),
    "extensions": Word("talaia.cli.extensions", "list the parts that other packages bring", ""),
    "schema": Word("talaia.cli.schema", "print the JSON schema of the site description", ""),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one word; gives the process's exit code: 0 done, 2 not as asked."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    first = arguments[0] if arguments else "--help"
    if first in ("-h", "--help", "help"):
        print(_help())
        return 0
    if first == "--version":
        print(f"talaia {__version__}")
        return 0
    word = WORDS.get(first)
    if word is None:
        # Last, where a terminal or a log still shows it.
        print(f"{_help()}\n\ntalaia: unknown word {first!r}", file=sys.stderr)
        return 2
    try:
        return _load(first, word)(arguments[1:])
    except TalaiaError as error:
        print(f"talaia {first}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _help() -> str:
    rows = "\n".join(f"  {name:<10} {word.summary}" for name, word in WORDS.items())
    return (
        f"usage: talaia WORD …    (talaia {__version__})\n\n{rows}\n\n"
        "talaia WORD --help tells more about a word."
    )


def _load(name: str, word: Word) -> Callable[[Sequence[str]], int]:
    try:
        module = importlib.import_module(word.module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.startswith("talaia"):
            raise
        raise PartMissing(f"talaia {name}", error.name, word.extra) from error
    return cast("Callable[[Sequence[str]], int]", module.main)
