"""``talaia history``: list where histories are, and move a site's from one server to another."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError
from talaia.cli.history.server_options import add_history_servers

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """List them, or move one and say how far it is."""
    options = _parse_options(argv)
    if not options.data.is_dir():
        raise CliError(f"--data: {options.data} is no folder; name the hub's data folder")
    # The history with its database: half a second of a core, which --help does not wait for.
    from talaia.cli.history.moving import list_histories, move_history
    from talaia.hub.history.servers.server_file import read_history_servers
    from talaia.hub.settings import Settings
    from talaia.hub.store.history_servers.home_tables import OWN

    settings = Settings(
        data=options.data,
        database_url=Settings.url_from(),
        history_servers=options.history_servers,
    )
    if options.what == "list":
        asyncio.run(list_histories(settings, _print_line))
        return 0
    if options.history_servers is None:
        raise CliError("--history-servers: name the file that names them, as for the hub")
    names = [OWN, *read_history_servers(options.history_servers).servers]
    if options.to not in names:
        raise CliError(f"--to: there is no server {options.to!r}; name one of {', '.join(names)}")
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(move_history(settings, options.site, options.to, _print_line))
        return 0
    _print_line(
        "a hub that runs goes on with it; run this again to see how far it is, or to go on where"
        " none runs"
    )
    return 130


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia history",
        description="Sites' histories on more than one server. A server's database of the accounts"
        " is named by TALAIA_DATABASE_URL, as for the hub.",
    )
    commands = parser.add_subparsers(dest="what", required=True, metavar="COMMAND")
    listed = commands.add_parser("list", help="list which server has which site's history")
    moved = commands.add_parser(
        "move",
        help="move a site's history to another server",
        description="Move a site's history to another server while all goes on. The hub that runs"
        " does it, and this shows how far it is; where none runs, it is done here. Broken off at"
        " any point, nothing is lost: the hub goes on, and to run this again shows it. To ask for"
        " the server where it is ends a move. Where the server is of another shard, the leads of"
        " both close and open again when it is there: their sites are away for a moment.",
    )
    for command in (listed, moved):
        command.add_argument(
            "--data", type=Path, default=Path("talaia-data"), help="the hub's data folder"
        )
        add_history_servers(command)
    moved.add_argument("site", help="the site's short name")
    moved.add_argument(
        "--to", required=True, metavar="SERVER", help="its name; own is the hub's own database"
    )
    return parser.parse_args(argv)


def _print_line(line: str) -> None:
    print(line)
    # Whoever reads it through a pipe sees how far it is.
    sys.stdout.flush()
