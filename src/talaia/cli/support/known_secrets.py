"""Finds the secrets of this machine's Talaia, so that a support bundle can be held against them."""

from __future__ import annotations

import contextlib
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit

from talaia.cli.support.redaction import names_secret

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

__all__ = ["secrets_in_environment", "secrets_in_files", "secrets_in_tree", "secrets_in_url"]

# Bytes; keys, tokens and password files are small, and a database is not gone through.
_MOST_FILE = 64 * 1024
# Files whose text is a secret as a whole, beside those with a secret's name.
_SECRET_ENDS = (".key", ".pem", ".p8", ".pfx", ".p12", ".token", ".secret", ".password")
_CERTIFICATE = re.compile(rb"-----BEGIN [A-Z ]*CERTIFICATE-----")


def secrets_in_environment(environment: Mapping[str, str]) -> Iterator[str]:
    """Give the values of variables that are secrets by their names, and passwords in addresses."""
    for name, value in environment.items():
        if names_secret(name) and not Path(value).exists():
            yield value
        yield from secrets_in_url(value)


def secrets_in_url(text: str) -> Iterator[str]:
    """Give the password of an address, as it stands and decoded."""
    with contextlib.suppress(ValueError):
        password = urlsplit(text).password
        if password:
            yield password
            yield unquote(password)


def secrets_in_files(paths: Iterable[Path]) -> Iterator[str]:
    """Give the contents of key files, and of all in these folders; others are left alone."""
    for path in paths:
        with contextlib.suppress(OSError):
            if path.is_dir():
                yield from secrets_in_files(sorted(path.iterdir()))
            elif names_secret(path.name) or path.suffix in _SECRET_ENDS:
                yield from _secrets_of_file(path)


def secrets_in_tree(value: object, folder: Path, environment: Mapping[str, str]) -> Iterator[str]:
    """Give what stands at secrets' names in a description or a settings file.

    What a key like ``password_file`` or ``token_env`` names is read as well, beside ``folder``.
    """
    if isinstance(value, list):
        for item in value:
            yield from secrets_in_tree(item, folder, environment)
    elif isinstance(value, dict):
        for key, found in value.items():
            if isinstance(found, str) and found:
                yield from secrets_in_url(found)
                yield from _secrets_at(str(key), found, folder, environment)
            elif names_secret(str(key)) and isinstance(found, int) and found is not True:
                yield str(found)
            yield from secrets_in_tree(found, folder, environment)


def _secrets_at(key: str, text: str, folder: Path, environment: Mapping[str, str]) -> Iterator[str]:
    if not names_secret(key):
        return
    # A name like `password_file` says where it is; a person may have written the password itself.
    file = folder / text
    with contextlib.suppress(OSError, ValueError):
        if file.is_file():
            yield from _secrets_of_file(file)
            return
    if key.endswith("_env"):
        yield environment.get(text, "")
        return
    yield text


def _secrets_of_file(path: Path) -> Iterator[str]:
    with path.open("rb") as file:
        content = file.read(_MOST_FILE)
    # Everybody is shown a certificate.
    if _CERTIFICATE.match(content.lstrip()):
        return
    text = content.decode("utf-8", "replace")
    if text.lstrip().startswith("{"):
        with contextlib.suppress(ValueError):
            said = json.loads(text)
            # A gateway's key file: its hub's address is no secret.
            for name, value in said.items() if isinstance(said, dict) else ():
                if isinstance(value, str) and names_secret(str(name)):
                    yield value
            return
    if "\N{REPLACEMENT CHARACTER}" in text:
        # Raw bytes are in no text but as hexadecimal.
        yield content.hex()
        return
    yield from (line for line in text.splitlines() if not line.startswith("-----"))
