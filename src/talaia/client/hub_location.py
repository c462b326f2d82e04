"""Where the hub is, how it is known, and the token: from arguments, the environment or a file.

A token never stands on a command line, where every process of the machine could read it; a file
that holds one is read only if nobody else can read it.
"""

from __future__ import annotations

import os
import stat
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.client.errors import BadSettings

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["HubLocation", "find_hub", "read_token_file"]

# Names of this machine; what is sent to them never leaves it.
_LOOPBACK = frozenset({"127.0.0.1", "::1", "localhost"})
# Of a file with a token, or settings (bytes).
_LONGEST = 64 * 1024
_KEYS = frozenset({"hub", "token", "token_file", "fingerprint", "ca"})


@dataclass(frozen=True, slots=True)
class HubLocation:
    """A hub, and how it and this script prove themselves to each other.

    Attributes:
        host: its name or address.
        port: where it listens.
        plain: without TLS; on loopback alone.
        token: of a person, made under *Account → Tokens for scripts*.
        fingerprint: SHA-256 of the hub's certificate or of its public key, hexadecimal; empty: by
            an authority.
        ca: file of certificate authorities (PEM); none takes the system's.

    """

    host: str
    port: int
    plain: bool
    token: str = field(repr=False)
    fingerprint: str = ""
    ca: Path | None = None

    @classmethod
    def from_text(
        cls, hub: str, token: str, *, fingerprint: str = "", ca: Path | None = None
    ) -> HubLocation:
        """Check what a person gave.

        Raises:
            BadSettings: it cannot be meant, says where and what was expected.

        """
        # A bare name is the usual case, and TLS the only one on a network.
        try:
            parts = urlsplit(hub if "://" in hub else f"https://{hub}")
            host, port = parts.hostname, parts.port
        except ValueError as error:
            raise BadSettings(f"hub {hub!r}: expected https://host:port ({error})") from error
        if parts.scheme not in {"http", "https", "ws", "wss"} or not host:
            raise BadSettings(f"hub {hub!r}: expected https://host:port")
        plain = parts.scheme in {"http", "ws"}
        if plain and host not in _LOOPBACK:
            raise BadSettings(
                f"hub {hub!r}: plain text is for loopback only, since the token would cross the"
                " network in clear; use https://"
            )
        if not token:
            raise BadSettings(
                "no token: make one under Account, Tokens for scripts, and set TALAIA_TOKEN or"
                " name a file that holds it"
            )
        # It goes into an HTTP header.
        if any(ord(letter) <= 32 or ord(letter) > 126 for letter in token):
            raise BadSettings("the token holds characters that no token has; copy it anew")
        # As browsers and openssl show it, with colons and capitals.
        pin = fingerprint.replace(":", "").lower()
        if pin and (len(pin) != 64 or set(pin) - set("0123456789abcdef")):
            raise BadSettings(f"fingerprint {fingerprint!r}: expected 64 hexadecimal digits")
        return cls(host, port or (80 if plain else 443), plain, token, pin, ca)

    @property
    def authority(self) -> str:
        """Host and port, as they stand in an address."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}"

    @property
    def page(self) -> str:
        """The address of the hub's own pages, for people."""
        return f"{'http' if self.plain else 'https'}://{self.authority}"

    @property
    def socket_url(self) -> str:
        """The beginning of the addresses of its WebSockets."""
        return f"{'ws' if self.plain else 'wss'}://{self.authority}"


def find_hub(
    hub: str = "",
    token: str = "",
    *,
    fingerprint: str = "",
    ca: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> HubLocation:
    """Find out which hub is meant: by what is given, then the environment, then a file.

    The environment's words are ``TALAIA_HUB``, ``TALAIA_TOKEN``, ``TALAIA_TOKEN_FILE``,
    ``TALAIA_FINGERPRINT`` and ``TALAIA_CA``; the file is ``talaia/client.toml`` in the folder for
    settings (``~/.config``), with the keys ``hub``, ``token`` or ``token_file``, ``fingerprint``
    and ``ca``. A hub that is named goes with the file's token only if the file names the same one.

    Raises:
        BadSettings: no hub or no token is named, or one that cannot be meant.

    """
    said = os.environ if environment is None else environment
    hub = hub or said.get("TALAIA_HUB", "")
    token = token or said.get("TALAIA_TOKEN", "")
    if not token and said.get("TALAIA_TOKEN_FILE"):
        token = read_token_file(Path(said["TALAIA_TOKEN_FILE"]))
    fingerprint = fingerprint or said.get("TALAIA_FINGERPRINT", "")
    authority = ca or (Path(said["TALAIA_CA"]) if said.get("TALAIA_CA") else None)
    kept = _read_settings(said)
    # A token of one hub is never shown to another.
    if hub and kept.get("hub", hub) != hub:
        kept = {}
    hub = hub or kept.get("hub", "")
    if not hub:
        raise BadSettings("no hub: name it, as https://host:port, or set TALAIA_HUB")
    if not token and kept.get("token_file"):
        token = read_token_file(Path(kept["token_file"]).expanduser())
    location = HubLocation.from_text(
        hub,
        token or kept.get("token", ""),
        fingerprint=fingerprint or ("" if authority else kept.get("fingerprint", "")),
        ca=authority,
    )
    if not location.ca and not location.fingerprint and kept.get("ca"):
        return replace(location, ca=Path(kept["ca"]).expanduser())
    return location


def read_token_file(path: Path) -> str:
    """Read a token that stands alone in a file.

    Raises:
        BadSettings: it cannot be read, or others can.

    """
    return _read_private(path).strip()


def _read_settings(environment: Mapping[str, str]) -> dict[str, str]:
    base = environment.get("XDG_CONFIG_HOME") or str(Path.home() / ".config")
    path = Path(base) / "talaia" / "client.toml"
    if not path.is_file():
        return {}
    try:
        found = tomllib.loads(_read_private(path))
    except tomllib.TOMLDecodeError as error:
        raise BadSettings(f"{path}: {error}") from error
    for key, value in found.items():
        if key not in _KEYS:
            raise BadSettings(f"{path}: there is no key {key!r}; known are {sorted(_KEYS)}")
        if not isinstance(value, str):
            raise BadSettings(f"{path}: {key} is a text in quotation marks")
    return found


def _read_private(path: Path) -> str:
    try:
        with path.open(encoding="utf-8") as file:
            mode = os.fstat(file.fileno()).st_mode
            # A pipe (`<(pass show …)`) is nobody else's; a file may be.
            if stat.S_ISREG(mode) and mode & 0o077:
                raise BadSettings(f"{path} can be read by others; run: chmod 600 {path}")
            return file.read(_LONGEST)
    except (OSError, UnicodeDecodeError) as error:
        raise BadSettings(f"{path} cannot be read: {error}") from error
