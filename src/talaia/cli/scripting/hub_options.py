"""Options that name a hub and hold a token, the same for all commands that ask one."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.client import Client

__all__ = ["FAILED", "add_hub_options", "hub_parser", "open_client", "quiet_pipe"]

# Exit codes: what was asked has failed; 2 is for what could not be asked.
FAILED = 1
_EPILOG = (
    "The hub and the token come from these options, else from TALAIA_HUB, TALAIA_TOKEN,"
    " TALAIA_TOKEN_FILE, TALAIA_FINGERPRINT and TALAIA_CA, else from ~/.config/talaia/client.toml"
    " (mode 0600). A token is made under Account, Tokens for scripts."
)


def hub_parser(command: str, description: str) -> argparse.ArgumentParser:
    """Begin a command's parser."""
    return argparse.ArgumentParser(f"talaia {command}", description=description, epilog=_EPILOG)


def add_hub_options(parser: argparse.ArgumentParser) -> None:
    """Add what names a hub; there is no option for the token itself, which others could read."""
    parser.add_argument("--hub", default="", metavar="URL", help="https://host:port")
    parser.add_argument("--token-file", type=Path, metavar="FILE", help="holds the token alone")
    trust = parser.add_mutually_exclusive_group()
    trust.add_argument(
        "--fingerprint",
        default="",
        metavar="HEX",
        help="SHA-256 of the hub's certificate or public key, as the hub prints it at its start",
    )
    trust.add_argument("--ca", type=Path, metavar="FILE", help="certificate authorities (PEM)")


@contextmanager
def open_client(options: argparse.Namespace) -> Iterator[Client]:
    """Give a client of the hub that the options name.

    Raises:
        ClientError: no hub or no token is named.

    """
    # Arrays and the wire, which --help and wrong words do not wait for.
    from talaia.client import Client, read_token_file

    token = read_token_file(options.token_file) if options.token_file else ""
    with Client(options.hub, token, fingerprint=options.fingerprint, ca=options.ca) as client:
        yield client


@contextmanager
def quiet_pipe() -> Iterator[None]:
    """End without a word when whoever reads the output has had enough (``| head``)."""
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes at its end once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except TalaiaError:
        # What was printed stands before the reason on a terminal.
        sys.stdout.flush()
        raise
