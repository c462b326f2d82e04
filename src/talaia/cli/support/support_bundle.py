"""``talaia support-bundle``: one file for whoever helps, without secrets."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Write the bundle and say where it is."""
    parser = argparse.ArgumentParser(
        "talaia support-bundle",
        description="Gather what somebody who helps needs to know, as one ZIP file: versions, what "
        "`talaia doctor` says, settings, site descriptions, sizes of the database, gateways and "
        "the last lines of logs. Secrets are masked. It goes nowhere by itself: look through it, "
        "then hand it on.",
    )
    parser.add_argument("file", type=Path, help="the ZIP file; must not be there yet")
    parser.add_argument(
        "--data", type=Path, default=Path("talaia-data"), help="the hub's data folder (talaia-data)"
    )
    parser.add_argument("--port", type=int, default=8443, help="the hub's port (8443)")
    repeated: dict[str, str] = {
        "--site": "a site description; may repeat",
        "--settings": "a settings file of hub or gateway (YAML), or one that it names; may repeat",
        "--log": "a file with a log, beside those in the data folder and systemd's journal;"
        " may repeat",
    }
    for option, said in repeated.items():
        parser.add_argument(
            option, type=Path, action="append", default=[], metavar="FILE", help=said
        )
    options = parser.parse_args(argv)
    # The model and what examines machines, which --help and wrong words do not wait for.
    from talaia.cli.support.bundle import BundleSources, bundle_texts, write_bundle

    sources = BundleSources(
        data=options.data,
        port=options.port,
        database_url=_database_url(options.data),
        sites=tuple(options.site),
        settings=tuple(options.settings),
        logs=tuple(options.log),
        environment=dict(os.environ),
    )
    write_bundle(bundle_texts(sources), options.file)
    print(f"support bundle: {options.file}\nlook through it before you hand it on")
    return 0


def _database_url(data: Path) -> str:
    """Give the URL of the hub's database, as the hub takes it."""
    url = os.environ.get("TALAIA_DATABASE_URL", "")
    file = os.environ.get("TALAIA_DATABASE_URL_FILE", "")
    if not url and file:
        url = Path(file).read_text(encoding="utf-8").strip()
    return url or f"sqlite:///{data.absolute() / 'talaia.db'}"
