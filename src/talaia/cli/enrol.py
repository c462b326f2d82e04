"""``talaia enrol``: make the key by which one site's gateway proves itself to a hub."""

from __future__ import annotations

import argparse
import asyncio
import datetime as dt
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError
from talaia.hub.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Print a new key, or keep it in a file; the one the site had before is void from now on."""
    parser = argparse.ArgumentParser(
        "talaia enrol",
        description="Create a gateway's key; the site's earlier key becomes invalid.",
    )
    parser.add_argument("site", help="the short name in the site description")
    parser.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    parser.add_argument(
        "--to",
        type=Path,
        metavar="FILE",
        help="write the gateway's key file; an existing, valid one is kept",
    )
    parser.add_argument("--hub", metavar="URL", help="with --to: wss://host:port of this hub")
    parser.add_argument(
        "--allow-plain",
        action="store_true",
        help="with --to: let --hub be ws:// on this machine (no encryption)",
    )
    options = parser.parse_args(argv)
    settings = Settings(data=options.data, database_url=Settings.url_from())
    # The key alone on standard output, for a script that stores it.
    if options.to is None:
        # The hub's database: half a second of a core, which --help and wrong words do not wait for.
        from talaia.hub import accounts

        print(asyncio.run(accounts.create_gateway(settings, options.site)))
        return 0
    if not options.hub:
        raise CliError("--to needs --hub: where the gateway finds this hub (wss://host:port)")
    return _write_key_file(settings, options)


def _find_certificate(settings: Settings, now: dt.datetime) -> Path:
    from talaia.hub.certificate import certificate_of, own_certificate

    # The hub's own, as it is: here nobody knows all names by which it is reached, and one made
    # anew without them would be in its place.
    found = certificate_of(settings).cert
    return found if found.exists() else own_certificate(settings, now).cert


def _write_key_file(settings: Settings, options: argparse.Namespace) -> int:
    # As above.
    from talaia.cli.keys import is_good, make_key
    from talaia.gateway.key_file import KeyFile
    from talaia.gateway.settings import HubAddress
    from talaia.hub.certificate import key_hash

    now = dt.datetime.now(dt.UTC)
    address = HubAddress.from_text(options.hub, allow_plain=options.allow_plain)
    # Safe to run at each start of a container: a key that works is not replaced.
    if asyncio.run(is_good(settings, options.to, options.site)):
        print(f"{options.to} is valid already", file=sys.stderr)
        return 0
    # The gateway knows the hub by this key, so nobody else can pose as it, and no authority is
    # needed. Without encryption there is none to know it by.
    pin = "" if address.plain else key_hash(_find_certificate(settings, now))
    content = KeyFile(key="", site=options.site, hub=address.url, fingerprint=pin)
    asyncio.run(make_key(settings, options.to, content))
    print(f"{options.to}: the key of the gateway of {options.site}", file=sys.stderr)
    return 0
