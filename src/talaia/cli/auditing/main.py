"""``talaia audit verify``: hold a hub's audit log against its chain and its signed heads."""

from __future__ import annotations

import argparse
import asyncio
import os
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.hub.errors import CannotStart
from talaia.hub.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Say whether the log is as it was; 0: it is, 1: it is not."""
    options = _read_options(argv)
    # The hub's database: half a second of a core, which --help and wrong words do not wait for.
    from talaia.hub.accounts import verify_audit
    from talaia.hub.auth.audit_heads import head_key
    from talaia.hub.notify.audit_heads import HEADS_FILE, read_heads

    public = options.key or head_key(options.data).public
    files = options.heads or [options.data / HEADS_FILE]
    heads: dict[int, str] = {}
    for file in files:
        try:
            with file.open(encoding="utf-8", errors="replace") as lines:
                found = read_heads(lines, public)
        except OSError as error:
            said = f"{file} cannot be read: {error.strerror}"
            raise CannotStart(said, "name the file with --heads") from error
        except ValueError as error:
            print(f"{file}: {error}")
            return 1
        for row, said in found.items():
            if heads.setdefault(row, said) != said:
                print(f"{file}: another hash of row {row} than the files before")
                return 1
    settings = Settings(data=options.data, database_url=Settings.url_from(os.environ))
    chain = asyncio.run(verify_audit(settings, heads))
    print(f"{chain.rows} rows follow each from the one before; {chain.heads} signed heads fit")
    if chain.broken:
        print(f"row {chain.broken} was changed, is missing, or is not the one that was signed")
        return 1
    if not chain.heads:
        print("no signed head was found: who has the database could have made all rows anew")
    print(f"key of the heads: {public}")
    return 0


def _read_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia audit", description="Hold a hub's audit log against its chain and its signed heads."
    )
    what = parser.add_subparsers(dest="what", required=True)
    verify = what.add_parser("verify", help="say whether a row was changed or is missing")
    verify.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    verify.add_argument(
        "--heads",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="file with signed heads, a log server's too (the one in the data folder); may repeat",
    )
    verify.add_argument(
        "--key", default="", help="public key of the heads (the one in the data folder)"
    )
    return parser.parse_args(argv)
