"""The file that names another hub to which signed heads go: read once, at the start."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated
from urllib.parse import urlsplit

import msgspec
from msgspec import Meta

from talaia.hub.errors import CannotStart
from talaia.hub.settings import is_loopback
from talaia.hub.settings_file import read_settings_file

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["AuditHubSettings", "read_audit_hub_settings"]

_MOST_FILE = 64 * 1024
_Word = Annotated[str, Meta(min_length=1, max_length=500)]


class AuditHubSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All of the file.

    Attributes:
        url: the other hub, as a browser opens it.
        token_file: holds the token that it gave for this hub; read each time.
        fingerprint: SHA-256 (hex) of its certificate or key; empty: it is known by an authority.
        ca: certificates (PEM) by which its own is checked; empty: the system's.

    """

    url: _Word
    token_file: _Word
    fingerprint: Annotated[str, Meta(max_length=200)] = ""
    ca: Annotated[str, Meta(max_length=500)] = ""


def read_audit_hub_settings(path: Path) -> AuditHubSettings:
    """Read the file; names of files in it are meant from its folder on.

    Raises:
        CannotStart: it cannot be read, or asks for what is not safe.

    """
    read = read_settings_file(
        path,
        AuditHubSettings,
        option="--audit-hub",
        about="which hub",
        guide="run-a-hub",
        most=_MOST_FILE,
    )
    found = urlsplit(read.url)
    # On this machine only: on the way anybody else could say that they are kept.
    plain = found.scheme == "http" and is_loopback(found.hostname or "")
    if not (found.scheme == "https" or plain) or not found.hostname or found.path.strip("/"):
        raise CannotStart(
            f"--audit-hub {path}: url is {read.url!r}, and no https address of a hub",
            "write it as a browser opens it, such as https://other.example:8443",
        )
    fingerprint = read.fingerprint.replace(":", "").lower()
    if fingerprint and not re.fullmatch(r"[0-9a-f]{64}", fingerprint):
        raise CannotStart(
            f"--audit-hub {path}: fingerprint is no SHA-256 of 64 digits (hex)",
            "write the one that the other hub prints when it starts",
        )
    folder = path.parent
    return msgspec.structs.replace(
        read,
        url=read.url.rstrip("/"),
        token_file=str(folder / read.token_file),
        fingerprint=fingerprint,
        ca=str(folder / read.ca) if read.ca else "",
    )
