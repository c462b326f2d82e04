"""``talaia enrol``: make the key by which one site's gateway proves itself to a hub."""

from __future__ import annotations

import argparse
import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.hub import accounts
from talaia.hub.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Print a new key; the one the site had before is void from now on."""
    parser = argparse.ArgumentParser(
        "talaia enrol", description="Make a gateway's key; the site's earlier key becomes void."
    )
    parser.add_argument("site", help="the short name in the site description")
    parser.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    options = parser.parse_args(argv)
    print(
        asyncio.run(
            accounts.create_gateway(
                Settings(data=options.data, database_url=Settings.url_from()), options.site
            )
        )
    )
    return 0
