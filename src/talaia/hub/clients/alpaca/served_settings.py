"""The file that says where the hub answers as an Alpaca server: read once, at the start."""

from __future__ import annotations

import ipaddress
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated

import msgspec
import yaml
from msgspec import Meta

from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["AlpacaServing", "read_alpaca_serving"]

_MOST_FILE = 64 * 1024


class AlpacaServing(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All of the file.

    Attributes:
        address: IP address to listen on, one of this computer's; Alpaca has no sign-in, so whoever
            reaches it reads what the account may see.
        port: TCP.
        site: its short name; an Alpaca server has the devices of one observatory.
        token_file: holds a token of the account by whose rights all is done.
        commands: patterns of ``<device>/<command>`` that clients may call; empty: reads only.
            Closing a dome comes with any other command of it.
        discovery: answer to Alpaca's discovery (UDP 32227), to those who reach ``address``.

    """

    address: Annotated[str, Meta(min_length=1, max_length=60)]
    site: Annotated[str, Meta(min_length=1, max_length=100)]
    token_file: Annotated[str, Meta(min_length=1)]
    port: Annotated[int, Meta(ge=0, le=65_535)] = 11_111
    commands: Annotated[list[Annotated[str, Meta(min_length=3)]], Meta(max_length=100)] = []
    discovery: bool = True

    def has_command(self, name: str) -> bool:
        """Tell whether a command (``dome/open``) may be called."""
        return any(fnmatchcase(name, pattern) for pattern in self.commands)


def read_alpaca_serving(path: Path) -> AlpacaServing:
    """Read the file; the token's is meant from its folder on.

    Raises:
        CannotStart: it cannot be read, or says no address.

    """
    advice = "see: talaia docs alpaca"
    try:
        with path.open("rb") as file:
            text = file.read(_MOST_FILE)
    except OSError as error:
        why = f"--alpaca {path} cannot be read: {error.strerror or error}"
        raise CannotStart(why, advice) from error
    try:
        read = msgspec.convert(yaml.safe_load(text), AlpacaServing)
    except (yaml.YAMLError, msgspec.ValidationError, RecursionError, ValueError) as error:
        raise CannotStart(f"--alpaca {path}: {error}", advice) from error
    try:
        address = ipaddress.ip_address(read.address)
    except ValueError as error:
        why = f"--alpaca {path}: address: expected an IP address, found {read.address!r}"
        raise CannotStart(why, advice) from error
    # Every network at once is nothing that anybody has chosen.
    if address.is_unspecified or address.is_multicast:
        why = f"--alpaca {path}: address: {read.address} is no single address of this computer"
        raise CannotStart(why, "name the address of the network in which the clients are")
    return msgspec.structs.replace(read, token_file=str(path.parent / read.token_file))
