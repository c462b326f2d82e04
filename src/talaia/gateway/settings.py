"""Numbers and places a gateway is started with; what the description does not say."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.errors import SettingsError

if TYPE_CHECKING:
    from talaia.gateway.notices.settings import NoticeSettings

__all__ = ["GatewaySettings", "HubAddress", "LegacySettings", "UpdateSettings"]

# Names of this machine; what is sent to them never leaves it.
_LOOPBACK = ("127.0.0.1", "::1", "localhost")


@dataclass(frozen=True, slots=True)
class UpdateSettings:
    """How a gateway changes to another release of itself.

    Attributes:
        releases: their folder.
        linked_s: a release works once its link has been there for so long (s).
        rest_s: the gateway ends for another one when nothing has moved for so long (s).

    """

    releases: Path
    linked_s: float = 10.0
    rest_s: float = 30.0


@dataclass(frozen=True, slots=True)
class HubAddress:
    """Where the hub is and how it proves itself.

    Attributes:
        url: ``wss://host:port``, without a path.
        others: of other hubs that are one with it; dialled in turn when it is not reached.
        fingerprint: SHA-256 of the hub's certificate or of its public key, hex without colons;
            empty to use a CA.
        ca: file of certificate authorities; none takes the system's.

    """

    url: str
    fingerprint: str = ""
    ca: Path | None = None
    others: tuple[str, ...] = ()

    @classmethod
    def from_text(
        cls, text: str, *, fingerprint: str = "", ca: Path | None = None, allow_plain: bool = False
    ) -> HubAddress:
        """Check an address as a person gave it; several hubs that are one, with commas between.

        Raises:
            SettingsError: not a WebSocket address; plain text without being asked for or to
                another machine; a fingerprint that is none.

        """
        urls = [_check_url(url.strip(), allow_plain=allow_plain) for url in text.split(",")]
        if len({url.partition(":")[0] for url in urls}) > 1:
            raise SettingsError(f"hub address {text!r}: some of it is plain text; use wss://")
        # As browsers and openssl show it, with colons and capitals.
        pin = fingerprint.replace(":", "").lower()
        if pin and (len(pin) != 64 or set(pin) - set("0123456789abcdef")):
            raise SettingsError(
                f"fingerprint {fingerprint!r}: expected 64 hexadecimal digits (SHA-256)"
            )
        return cls(urls[0], pin, ca, tuple(urls[1:]))

    @property
    def text(self) -> str:
        """All addresses, as `from_text` reads them."""
        return ",".join((self.url, *self.others))

    @property
    def plain(self) -> bool:
        """Tell whether the link is not encrypted."""
        return self.url.startswith("ws://")


@dataclass(frozen=True, slots=True)
class LegacySettings:
    """The door for clients of the founding observatory.

    Attributes:
        port: 0 takes any.
        host: the address it listens on.
        certificate: PEM; none makes one in the data folder.
        key: of the certificate, PEM.
        token_file: holds what clients must say; none makes one in the data folder.

    """

    port: int
    host: str = "127.0.0.1"
    certificate: Path | None = None
    key: Path | None = None
    token_file: Path | None = None


@dataclass(frozen=True, slots=True)
class GatewaySettings:
    """How one gateway runs.

    Attributes:
        key: proves the gateway to the hub; never logged.
        data: folder of spool, journal, epochs and STOP latches.
        folder: where the description stands; relative paths in it begin there.
        domain: a ROS domain that overrides the description's.
        spool_bytes: most that may wait on disk; the oldest gives way.
        spool_age_s: what has waited for longer gives way too; only time in which a gateway runs
            counts, so that a wrong clock makes nothing old.
        spare_bytes: so much of the disk the spool leaves free for STOP, commands and the rest of
            the machine, or a twentieth of the disk if that is less.
        flush: samples are batched about so often (s).
        sync: the spool is forced to disk so often (s); a power cut loses no more than this.
        outbox_bytes: most that pictures and other files may take while they wait for the hub; the
            oldest give way.
        upload_bytes: files go out at this rate, below everything else (bytes/s).
        door: for founding clients; none leaves it closed.
        accepts: which changes of the description it takes from the hub.
        notices: ways to people while the hub is away; none where there are none.
        updates: where its releases are; none where it is not started by `talaia update run`.
        backfill_bytes: old samples go out at this rate beside the live ones (bytes/s).
        detector_provider: what detectors of objects and faces run on.
        meshes: files that the robot's description names go to the hub when it asks for them.
        meshes_from: such files may also lie below this folder; none: in their packages' own alone.

    """

    hub: HubAddress
    key: str = field(repr=False)
    data: Path = Path("talaia-gateway")
    folder: Path = Path()
    domain: int | None = None
    spool_bytes: int = 1024 * 1024 * 1024
    spool_age_s: float = 14 * 86400.0
    spare_bytes: int = 64 * 1024 * 1024
    flush: float = 0.04
    sync: float = 1.0
    outbox_bytes: int = 4 * 1024 * 1024 * 1024
    upload_bytes: int = 1024 * 1024
    backfill_bytes: int = 512 * 1024
    door: LegacySettings | None = None
    accepts: AcceptedChanges = AcceptedChanges.NO
    notices: NoticeSettings | None = None
    detector_provider: str = "cpu"
    updates: UpdateSettings | None = None
    meshes: bool = True
    meshes_from: Path | None = None


def _check_url(url: str, *, allow_plain: bool) -> str:
    """Check one address; give it without its path.

    Raises:
        SettingsError: it is none.

    """
    shown = f"hub address {url!r}"
    parts = urlsplit(url)
    # People copy the address of the page.
    if parts.scheme in ("http", "https"):
        parts = parts._replace(scheme="ws" if parts.scheme == "http" else "wss")
    if parts.scheme not in ("ws", "wss") or not parts.hostname:
        raise SettingsError(f"{shown}: expected wss://host:port")
    if parts.scheme == "ws" and not allow_plain:
        raise SettingsError(f"{shown}: plain text; use wss://, or --allow-plain on loopback")
    # Also with `--allow-plain`: a key must never cross a network in clear text.
    if parts.scheme == "ws" and parts.hostname not in _LOOPBACK:
        raise SettingsError(f"{shown}: plain text is for loopback only; use wss://")
    # Only the place: the paths are the protocol's own.
    return parts._replace(path="", query="", fragment="").geturl()
