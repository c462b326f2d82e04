"""``talaia backup``: copy a hub's database and data folder while it runs."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.hub.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Write the backup and say where it is."""
    parser = argparse.ArgumentParser(
        "talaia backup",
        description="Copy a hub's database and data folder into a new folder. The hub may run."
        " A server's database is named by TALAIA_DATABASE_URL, as for the hub.",
    )
    parser.add_argument("folder", type=Path, help="folder of the backup; must not exist yet")
    parser.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    options = parser.parse_args(argv)
    # Half a second of a core, which --help and wrong words do not wait for.
    from talaia.hub.store.backup import histories_elsewhere, write_backup

    settings = Settings(data=options.data, database_url=Settings.url_from(os.environ))
    folder = write_backup(settings.url, options.data, options.folder, SystemClock())
    print(f"backup: {folder}")
    for server, sites in histories_elsewhere(folder).items():
        print(
            f"not in it: the history of {', '.join(sites)}, on the server {server!r}; back that"
            " database up with its own tools, at the same time"
        )
    return 0
