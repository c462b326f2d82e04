"""Secrets and authorities of servers that a gateway asks: read once, written nowhere."""

from __future__ import annotations

import os
import ssl
from typing import TYPE_CHECKING

from talaia.gateway.errors import SettingsError

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["read_authorities", "read_secret"]

# No password or token is longer; a file that is, is another one.
_MAX_SECRET = 10_000


def read_secret(what: str, folder: Path, *, file: str = "", variable: str = "") -> str:
    """Read a password or token; empty where neither is named.

    Raises:
        SettingsError: it cannot be read, or is not one line of text.

    """
    secret = ""
    if variable:
        secret = os.environ.get(variable, "").strip()
        if not secret:
            raise SettingsError(f"the variable {variable} with the {what} is not set")
    elif file:
        try:
            secret = (folder / file).read_text().strip()
        except (OSError, UnicodeDecodeError) as error:
            raise SettingsError(f"the {what} in {folder / file} cannot be read: {error}") from error
        if not secret:
            raise SettingsError(f"there is no {what} in {folder / file}")
    # A line break in it would begin another header.
    if not secret.isprintable() or len(secret) > _MAX_SECRET:
        raise SettingsError(f"the {what} is not one line of text")
    return secret


def read_authorities(folder: Path, ca: str) -> ssl.SSLContext:
    """Make TLS that trusts these authorities, or without any the machine's.

    Raises:
        SettingsError: they cannot be read.

    """
    try:
        return ssl.create_default_context(cafile=str(folder / ca) if ca else None)
    except (OSError, ssl.SSLError) as error:
        raise SettingsError(f"the authorities in {ca} cannot be read: {error}") from error
