"""Ways to people that a gateway has of its own, from a TOML file beside it; never the description.

Passwords and tokens stand in files or variables that the TOML names.
"""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

import msgspec

from talaia.gateway.errors import SettingsError

__all__ = [
    "CommandWay",
    "MailWay",
    "NoticeSettings",
    "WebhookWay",
    "read_notice_settings",
    "secret_of",
]


# Unknown keys are errors in all of these: a mistyped way would be no way, unnoticed.
class MailWay(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Mail by SMTP. Without TLS no password is sent."""

    server: str
    sender: str
    to: list[str]
    # For submission with STARTTLS (RFC 6409).
    port: int = 587
    security: Literal["starttls", "tls", "none"] = "starttls"
    user: str = ""
    # The password stands where one of these says; the file goes first.
    password_file: str = ""
    password_env: str = ""


class WebhookWay(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An HTTP POST with JSON; the token goes as ``Authorization: Bearer``."""

    url: str
    token_file: str = ""
    token_env: str = ""


class CommandWay(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A program of this machine, without a shell; it gets the JSON on its input."""

    words: list[str]


class NoticeSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How people are told while the hub is away.

    Attributes:
        after: the hub has been away for so long while it stands (s).
        repeat: told again after so long (s), then after twice that, and so on …
        longest: … up to this (s).

    """

    after: float = 60.0
    repeat: float = 300.0
    longest: float = 3600.0
    # msgspec gives each its own list.
    mail: list[MailWay] = []
    webhook: list[WebhookWay] = []
    command: list[CommandWay] = []


def read_notice_settings(path: Path) -> NoticeSettings:
    """Read the file.

    Raises:
        SettingsError: it cannot be read, or something in it does not fit.

    """
    try:
        found = msgspec.convert(tomllib.loads(path.read_text()), NoticeSettings)
    except (OSError, ValueError, msgspec.ValidationError) as error:
        raise SettingsError(f"the notices {path} cannot be read: {error}") from error
    for key in ("after", "repeat", "longest"):
        # Below a second people would be flooded, above a day forgotten.
        if not 1 <= getattr(found, key) <= 86_400:
            raise SettingsError(f"the notices {path}: {key}: expected 1 to 86400 s")
    if not found.mail and not found.webhook and not found.command:
        raise SettingsError(
            f"the notices {path} name no way: write [[mail]], [[webhook]] or [[command]]"
        )
    for mail in found.mail:
        if not mail.to:
            raise SettingsError(f"the notices {path}: mail: to: nobody is named")
        # Without TLS everybody on the way could read it.
        if mail.user and mail.security == "none":
            raise SettingsError(f"the notices {path}: mail: a password needs starttls or tls")
    for hook in found.webhook:
        if urlsplit(hook.url).scheme not in {"http", "https"}:
            raise SettingsError(f"the notices {path}: webhook: url: expected https://…")
    if any(not pattern.words for pattern in found.command):
        raise SettingsError(f"the notices {path}: command: words: expected a program")
    return found


def secret_of(file: str, variable: str) -> str:
    """Read a secret from where the settings say it is; empty where they say nothing.

    Raises:
        SettingsError: it is not there.

    """
    try:
        if file:
            return Path(file).read_text().strip()
        return os.environ[variable] if variable else ""
    except (OSError, ValueError, KeyError) as error:
        raise SettingsError(f"the secret in {file or variable} cannot be read: {error}") from error
