"""The words of ``talaia import``, before anything is imported that reads files.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.history.server_options import add_history_servers
from talaia.cli.importing.times import TimeUnit

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Import each file, or none of them."""
    options = _parse_options(argv)
    # The history with its database, and what reads recordings: a second of a core.
    from talaia.cli.importing.main import import_files

    return import_files(options)


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia import",
        description="Bring recordings (rosbag 1, rosbag 2, MCAP) and tables (CSV) into a site's"
        " history, and files that an installed extension reads. The hub may run. What is in"
        " the history already changes nothing. A server's"
        " database is named by TALAIA_DATABASE_URL, as for the hub.",
    )
    parser.add_argument("file", type=Path, nargs="+", help="a file, or a rosbag 2 folder")
    parser.add_argument(
        "--site", required=True, help="a site description (YAML), or the short name of a known site"
    )
    parser.add_argument(
        "--data", type=Path, default=Path("talaia-data"), help="the hub's data folder (talaia-data)"
    )
    add_history_servers(parser)
    parser.add_argument(
        "--dry-run", action="store_true", help="show what would be imported, and write nothing"
    )
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="HEADING=ADDRESS",
        help="CSV and extensions: this column is that channel, as base/speed or base/pose.x;"
        " may repeat",
    )
    parser.add_argument("--time", default="", metavar="HEADING", help="CSV: the column of times")
    parser.add_argument(
        "--time-unit",
        default="auto",
        choices=[unit.value for unit in TimeUnit],
        help="CSV: format of the times (auto: detected from the first)",
    )
    parser.add_argument(
        "--zone", default="", help="CSV: the time zone of times without one, such as Europe/Madrid"
    )
    return parser.parse_args(argv)
