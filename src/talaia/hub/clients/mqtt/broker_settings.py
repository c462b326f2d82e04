"""The file that names the broker and what goes there: read once, when the hub starts."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
from msgspec import Meta

from talaia.hub.errors import CannotStart
from talaia.hub.settings import is_loopback
from talaia.hub.settings_file import read_settings_file

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = [
    "BrokerAddress",
    "BrokerSettings",
    "SiteChoice",
    "SparkplugChoice",
    "read_broker_settings",
    "read_secret",
]

# One or more levels of a topic: no wildcards, nothing empty, none of the broker's own ($SYS).
_LEVELS = r"[^+#/$\x00]+(/[^+#/$\x00]+)*"
_Levels = Annotated[str, Meta(pattern=rf"^{_LEVELS}\Z", max_length=200)]
_LevelsOrNone = Annotated[str, Meta(pattern=rf"^({_LEVELS})?\Z", max_length=200)]
_Level = Annotated[str, Meta(pattern=r"^[^+#/$\x00]+\Z", max_length=100)]
_Pattern = Annotated[str, Meta(min_length=1, max_length=200)]
_Host = Annotated[str, Meta(pattern=r"^[A-Za-z0-9._:\-]{1,150}\Z")]
_ID = Annotated[str, Meta(pattern=r"^[A-Za-z0-9._\-]{1,64}\Z")]
_MOST_FILE = 1024 * 1024
_MOST_SECRET = 10_000


class BrokerAddress(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the broker is, and how the hub signs in there.

    Attributes:
        port: 0 takes 8883, or 1883 without TLS.
        tls: without it, only on this machine, unless `plain_over_network` says so.
        ca: certificates (PEM) by which the broker's is checked; empty: the system's.
        plain_over_network: what is published, and the password, may be read on the way.
        client_id: of the hub at the broker; another client of that name ends it.
        password_file: holds the password; it is read at each connect.

    """

    host: _Host
    port: Annotated[int, Meta(ge=0, le=65_535)] = 0
    tls: bool = True
    ca: str = ""
    plain_over_network: bool = False
    client_id: _ID = "talaia"
    username: Annotated[str, Meta(max_length=200)] = ""
    password_file: str = ""

    @property
    def number(self) -> int:
        """The port."""
        return self.port or (8883 if self.tls else 1883)

    def __str__(self) -> str:
        """Name it as people do."""
        return f"{self.host}:{self.number}"


class SiteChoice(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What of a site goes to the broker, and which commands come from there.

    Attributes:
        signals: patterns of ``<device>/<signal>`` with the wildcards of ``fnmatch``.
        commands: the same of ``<device>/<command>``; empty: none are listened to.

    """

    signals: Annotated[list[_Pattern], Meta(max_length=1000)] = []
    commands: Annotated[list[_Pattern], Meta(max_length=1000)] = []

    def has_signal(self, name: str) -> bool:
        """Tell whether a signal is published."""
        return _matches(name, self.signals)

    def has_command(self, name: str) -> bool:
        """Tell whether a command may come by MQTT."""
        return _matches(name, self.commands)


class SparkplugChoice(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The hub as an edge node of Sparkplug B, beside the topics under the prefix.

    Attributes:
        group: of the edge node.
        node: its name; one hub of each name in a group.

    """

    group: _Level
    node: _Level = "talaia"


class BrokerSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All of the file.

    Attributes:
        token_file: holds a token of the account by whose rights all is done; it is read anew
            whenever the hub connects.
        prefix: of all topics.
        every_s: a channel is published at most so often.
        home_assistant: prefix of its discovery topics; empty: no discovery.
        sparkplug: how the same is said in Sparkplug B; left out: it is not.
        sites: by short name; a site that is not named stays out.

    """

    broker: BrokerAddress
    token_file: Annotated[str, Meta(min_length=1)]
    prefix: _Levels = "talaia"
    every_s: Annotated[float, Meta(ge=0.1, le=3600)] = 1.0
    home_assistant: _LevelsOrNone = ""
    sparkplug: SparkplugChoice | None = None
    sites: Annotated[dict[str, SiteChoice], Meta(max_length=1000)] = {}


def read_broker_settings(path: Path) -> BrokerSettings:
    """Read the file; names of files in it are meant from its folder on.

    Raises:
        CannotStart: it cannot be read, or asks for what is not safe.

    """
    read = read_settings_file(
        path,
        BrokerSettings,
        option="--mqtt",
        about="which broker",
        guide="mqtt",
        most=_MOST_FILE,
    )
    _refuse_unsafe(path, read)
    return _resolve_files(read, path.parent)


def read_secret(name: str) -> str:
    """Read a secret from its file.

    Raises:
        OSError: the file cannot be read.

    """
    with Path(name).open("rb") as file:
        # What is no UTF-8 is no secret of ours: it will not be let in, and nobody is told of it.
        return file.read(_MOST_SECRET).decode("utf-8", "replace").strip()


def _refuse_unsafe(path: Path, read: BrokerSettings) -> None:
    broker = read.broker
    if not broker.tls and not (is_loopback(broker.host) or broker.plain_over_network):
        raise CannotStart(
            f"--mqtt {path}: without TLS, all that is published could be read on the way to"
            f" {broker.host}",
            "leave tls out, or say plain_over_network: true where that network may read it",
        )
    if not broker.tls and broker.ca:
        raise CannotStart(f"--mqtt {path}: ca says nothing without tls", "take one of them out")
    if broker.password_file and not broker.username:
        raise CannotStart(f"--mqtt {path}: a password without username", "add broker.username")
    if not read.sites:
        raise CannotStart(
            f"--mqtt {path}: no sites are named, so nothing would be published",
            "name sites and their signals; see: talaia docs mqtt",
        )


def _resolve_files(read: BrokerSettings, folder: Path) -> BrokerSettings:
    broker = msgspec.structs.replace(
        read.broker,
        ca=_from_folder(folder, read.broker.ca),
        password_file=_from_folder(folder, read.broker.password_file),
    )
    token_file = _from_folder(folder, read.token_file)
    return msgspec.structs.replace(read, broker=broker, token_file=token_file)


def _from_folder(folder: Path, name: str) -> str:
    return str(folder / name) if name else ""


def _matches(name: str, patterns: Iterable[str]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)
