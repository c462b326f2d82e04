"""``talaia restore``: bring a backup back, into a data folder or into a server's database."""

from __future__ import annotations

import argparse
import asyncio
import os
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.hub.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Put the backup where the hub takes it over at its next start."""
    parser = argparse.ArgumentParser(
        "talaia restore",
        description="Restore a backup. It takes effect when the hub starts next, which may run"
        " meanwhile; what was there before is kept aside in the data folder. If"
        " TALAIA_DATABASE_URL names a server's database, the rows go into that, which must be"
        " empty.",
    )
    parser.add_argument("folder", type=Path, help="a folder that `talaia backup` has written")
    parser.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    options = parser.parse_args(argv)
    # The hub's database: half a second of a core, which --help and wrong words do not wait for.
    from talaia.hub.accounts import make_data_folder
    from talaia.hub.store.backup import restore_folder, restore_server

    settings = Settings(data=options.data, database_url=Settings.url_from(os.environ))
    make_data_folder(settings)
    if not settings.url.startswith("sqlite"):
        # Tables first: rows can only go into a database of today's form.
        asyncio.run(_migrate_database(settings))
        print(f"restored: {restore_server(options.folder, settings.url)} rows")
    # Last: when the database refuses its rows, the folder is as it was.
    restore_folder(options.folder, options.data)
    print("restored: it takes effect when the hub starts next")
    return 0


async def _migrate_database(settings: Settings) -> None:
    from talaia.hub.store.database import open_migrated

    async with open_migrated(settings.url):
        pass
