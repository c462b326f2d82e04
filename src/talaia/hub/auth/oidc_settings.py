"""The file that says by which provider people sign in (OpenID Connect): read once, at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated
from urllib.parse import urlsplit

import msgspec
from msgspec import Meta

from talaia.hub.errors import CannotStart
from talaia.hub.settings import is_loopback
from talaia.hub.settings_file import read_settings_file

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["OidcSettings", "read_oidc_settings"]

_MOST_FILE = 256 * 1024
_Word = Annotated[str, Meta(min_length=1, max_length=200)]
_Domain = Annotated[str, Meta(pattern=r"^[a-z0-9]([a-z0-9.\-]*[a-z0-9])?\Z", max_length=200)]


class OidcSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All of the file.

    Attributes:
        issuer: the provider, as it calls itself; ``/.well-known/openid-configuration`` is below it.
        client_secret_file: holds the secret; it is read at each sign-in.
        label: what the button on the sign-in page says after *Sign in with*.
        scopes: asked for besides ``openid``.
        ca: certificates (PEM) by which the provider's is checked; empty: the system's.
        name_claim: by which a new person is called.
        groups_claim: holds a person's groups.
        groups: which role a group gives; of several groups the first in this file counts. Each
            sign-in gives the role anew.
        role: of who is in none of the groups; empty: they are not let in.
        domains: only people with a verified mail address in one of these; empty: all.
        new_people: whether somebody without an account gets one at the first sign-in.

    """

    issuer: _Word
    client_id: _Word
    client_secret_file: _Word
    label: _Word = "your organisation"
    scopes: Annotated[tuple[_Word, ...], Meta(max_length=20)] = ("profile", "email")
    ca: str = ""
    name_claim: _Word = "preferred_username"
    groups_claim: _Word = "groups"
    groups: Annotated[dict[_Word, _Word], Meta(max_length=200)] = {}
    role: Annotated[str, Meta(max_length=200)] = ""
    domains: Annotated[list[_Domain], Meta(max_length=100)] = []
    new_people: bool = False

    @property
    def discovery(self) -> str:
        """Where the provider says what it can do."""
        return f"{self.issuer.rstrip('/')}/.well-known/openid-configuration"

    def role_of(self, groups: set[str]) -> str:
        """Give the role of somebody in these groups; empty: none."""
        return next((role for group, role in self.groups.items() if group in groups), self.role)


def read_oidc_settings(path: Path) -> OidcSettings:
    """Read the file; names of files in it are meant from its folder on.

    Raises:
        CannotStart: it cannot be read, or asks for what is not safe.

    """
    read = read_settings_file(
        path,
        OidcSettings,
        option="--oidc",
        about="which provider",
        guide="openid-connect",
        most=_MOST_FILE,
    )
    found = urlsplit(read.issuer)
    # On this machine only: else who is in the network could sign people in.
    plain = found.scheme == "http" and is_loopback(found.hostname or "")
    if not (found.scheme == "https" or plain) or not found.hostname or found.query:
        raise CannotStart(
            f"--oidc {path}: issuer is {read.issuer!r}, and no https address",
            "write it as the provider does, such as https://login.example/realms/staff",
        )
    if not read.groups and not read.role:
        raise CannotStart(
            f"--oidc {path}: neither groups nor role say what people may do",
            "name the role of each group under groups, or one for all as role",
        )
    folder = path.parent
    return msgspec.structs.replace(
        read,
        client_secret_file=str(folder / read.client_secret_file),
        ca=str(folder / read.ca) if read.ca else "",
    )
