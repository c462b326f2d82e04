"""``talaia account``: make a person's account on a hub's data folder."""

from __future__ import annotations

import argparse
import asyncio
import getpass
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.hub import accounts
from talaia.hub.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Ask for the password (or read it from standard input) and make the account."""
    parser = argparse.ArgumentParser("talaia account", description="Make a person's account.")
    parser.add_argument("name", help="what the person signs in with")
    parser.add_argument(
        "--role", choices=("guest", "operator", "admin"), default="operator", help="(operator)"
    )
    parser.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    options = parser.parse_args(argv)
    if sys.stdin.isatty():
        password = getpass.getpass(f"password for {options.name}: ")
    else:
        password = sys.stdin.readline().rstrip("\n")
    settings = Settings(data=options.data)
    asyncio.run(accounts.create_user(settings, options.name, password, options.role))
    print(f"made: {options.name} ({options.role})")
    return 0
