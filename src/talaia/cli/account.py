"""``talaia account``: make a person's account on a hub's data folder, or set its password."""

from __future__ import annotations

import argparse
import asyncio
import getpass
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.hub.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Ask for the password (or read it from standard input) and make the account."""
    parser = argparse.ArgumentParser(
        "talaia account",
        description="Create an account, or set its password (from a prompt, or from stdin)."
        " TALAIA_DATABASE_URL says where the hub keeps its accounts, unless in the data folder.",
    )
    parser.add_argument("name", help="user name")
    parser.add_argument(
        "--role",
        default="operator",
        help="guest, operator, admin or a role of your own (default: operator)",
    )
    parser.add_argument(
        "--new-password", action="store_true", help="the account exists; only set its password"
    )
    parser.add_argument(
        "--remove-factor", action="store_true", help="remove the account's second factor"
    )
    parser.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    options = parser.parse_args(argv)
    # Half a second of a core, which --help and wrong words do not wait for.
    from talaia.hub import accounts

    settings = Settings(data=options.data, database_url=Settings.url_from())
    if options.remove_factor:
        removed = asyncio.run(accounts.remove_factor(settings, options.name))
        said = "signs in without a second factor now" if removed else "has no second factor"
        print(f"{options.name} {said}; sessions that were open are ended")
        return 0
    # No option for a password: every user of the machine can read the words of a command.
    if sys.stdin.isatty():
        password = getpass.getpass(f"password for {options.name}: ")
    else:
        # The line's end is no part of it; blanks are.
        password = sys.stdin.readline().rstrip("\n")
    if options.new_password:
        asyncio.run(accounts.set_password(settings, options.name, password))
        print(f"{options.name} has a new password; sessions that were open are ended")
        return 0
    asyncio.run(accounts.create_user(settings, options.name, password, options.role))
    print(f"made: {options.name} ({options.role})")
    return 0
