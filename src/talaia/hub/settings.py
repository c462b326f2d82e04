"""All that can be chosen for a hub: address, data folder, TLS, limits."""

from __future__ import annotations

import ipaddress
import os
import socket
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Network", "Settings", "is_loopback"]

Network = ipaddress.IPv4Network | ipaddress.IPv6Network


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """What a hub is told at its start.

    Attributes:
        data: folder of the database, the certificate and its key.
        port: 0 takes any free one.
        plain: no TLS; allowed on a loopback address only.
        cert: certificate chain (PEM); none makes one in ``data``.
        hosts: names besides localhost and ``host`` under which the hub is reached.
        proxies: reverse proxies that end TLS before this hub; their headers are believed.
        balancers: load balancers that let TLS pass; by the PROXY protocol they say who comes.
        cluster: addresses of NATS, by which several hubs are one; none: this hub is alone.
        cluster_name: of this hub among them; empty: the machine's name and the port.
        cluster_ca: authorities of NATS's certificate (PEM); none takes the system's.
        database_url: like ``postgresql://user@host/name``; empty takes SQLite in ``data``.
        files: address of a bucket for recordings and pictures (``s3://bucket/folder``); empty:
            they are in ``data``.
        files_endpoint: of the store that has the bucket; empty: AWS's own.
        files_region: of that store.
        files_key_file: file of the key that opens the bucket; none: it is in the environment.
        files_ca: authorities of that store's certificate (PEM); none takes the system's.
        notify_networks: messages about alarms may go to these besides public addresses.
        history_servers: file that names databases for histories besides; none: all are in the
            hub's own.
        history_bytes: the history's blocks may take so many bytes; then the oldest go. 0: no limit.
        file_bytes: a file that a gateway sends may be so large (bytes).
        recordings_bytes: those of one site may take so many bytes; then its oldest go. 0: no limit.
        sightings_days: what a camera saw is kept for so many days. 0: for good.
        sightings_most: of each site so many sightings are kept; then the oldest go.
        robot_log_days: lines of robots' own logs are kept for so many days. 0: for good.
        robot_log_most: of each site so many of those lines are kept; then the oldest go.
        extensions: folder of web components that the administrator fills; none: there are none.
        assets: folder with a folder for each site, with its robots' meshes; none: there are none.
        maps: folder with PMTiles files that pages show as maps; none: there are none.
        oidc: file that names a provider of sign-ins (OpenID Connect); none: there is none.
        mqtt: file that names an MQTT broker and what is published there; none: no broker.
        alpaca: file that says where the hub answers as an Alpaca server; none: it does not.
        alerts: folder of notices of transients that become rapid requests; none: nobody looks.
        archive_hook: file that says to what each new picture is handed over; none: to nothing.
        audit_heads: files to which signed heads of the audit log are appended, besides its own.
        audit_syslog: heads go to the machine's log, too.
        audit_mail: heads are mailed to this address, too; empty: to none.
        audit_mail_s: at most one such mail in this time (s).
        audit_hub: file that names another hub that keeps heads, too; none: none does.
        simulated_sites: short names of sites that are simulators; they have nights in minutes.
        password_cost: bcrypt's cost (2 to the power of it rounds).
        idle_s: a session that is not used for this long ends (s).
        life_s: a session ends this long after its start, used or not (s).
        warn_s: a person is told this long before the session ends (s).
        confirm_s: who gave the password this long ago may give rights away (s).
        unsure_s: when sessions could not be checked for this long, commands are refused (s).
        setup_s: the set-up link is good for this long (s).
        commit_s: samples are gathered this long before each commit (s).
        beat_s: a link says a word at least this often; three missed and it is gone (s).
        check_s: open sockets are held against the sessions this often (s).
        linger_s: a stream rests this long after its last viewer has gone (s).
        hello_s: a gateway must say hello within this time (s).

    """

    data: Path
    host: str = "127.0.0.1"  # the address to listen on
    port: int = 8443
    plain: bool = False
    cert: Path | None = None
    key: Path | None = None  # of ``cert``; both are given, or neither
    hosts: tuple[str, ...] = ()
    proxies: tuple[Network, ...] = ()
    balancers: tuple[Network, ...] = ()
    cluster: tuple[str, ...] = ()
    cluster_name: str = ""
    cluster_ca: Path | None = None
    database_url: str = ""
    files: str = ""
    files_endpoint: str = ""
    files_region: str = ""
    files_key_file: Path | None = None
    files_ca: Path | None = None
    notify_networks: tuple[Network, ...] = ()
    history_servers: Path | None = None
    history_bytes: int = 0
    file_bytes: int = 4 * 1024**3
    recordings_bytes: int = 20_000_000_000
    sightings_days: float = 90.0
    robot_log_days: float = 30.0
    robot_log_most: int = 200_000
    sightings_most: int = 10_000
    extensions: Path | None = None
    assets: Path | None = None
    maps: Path | None = None
    oidc: Path | None = None
    mqtt: Path | None = None
    alpaca: Path | None = None
    alerts: Path | None = None
    archive_hook: Path | None = None
    audit_heads: tuple[Path, ...] = ()
    audit_syslog: bool = False
    audit_mail: str = ""
    audit_mail_s: float = 86_400.0
    audit_hub: Path | None = None
    simulated_sites: tuple[str, ...] = ()
    password_cost: int = 12
    idle_s: float = 12 * 3600.0
    life_s: float = 7 * 86400.0
    warn_s: float = 300.0
    confirm_s: float = 300.0
    unsure_s: float = 2.0
    setup_s: float = 86400.0
    max_body: int = 1024 * 1024  # of a request (bytes)
    # Of one that brings a description: its text, escaped for JSON, and what it is to say instead.
    max_description_body: int = 16 * 1024 * 1024
    commit_s: float = 0.2
    beat_s: float = 1.0
    check_s: float = 0.5
    linger_s: float = 2.0
    hello_s: float = 10.0

    @property
    def tls(self) -> bool:
        """Whether browsers and gateways speak TLS, with this hub or with the proxy before it."""
        # With a proxy the cookies are for TLS although this hub speaks plain.
        return not self.plain or bool(self.proxies)

    @property
    def url(self) -> str:
        """Give the database's URL; accounts and history are both there."""
        return self.database_url or f"sqlite:///{self.data.absolute() / 'talaia.db'}"

    @property
    def hub_name(self) -> str:
        """The name of this hub among several."""
        return self.cluster_name or f"{socket.gethostname()}:{self.port}"

    @property
    def host_names(self) -> frozenset[str]:
        """Names that the Host header may hold, without port, in lower case."""
        own = socket.gethostname()
        names = {"localhost", "127.0.0.1", "::1", own, self.host, *self.hosts}
        # All interfaces are no name: nobody dials these.
        return frozenset(name.lower() for name in names if name not in {"0.0.0.0", "::", ""})  # noqa: S104 - compared, not bound

    @staticmethod
    def url_from(environment: Mapping[str, str] = os.environ) -> str:
        """Read the database's URL: ``TALAIA_DATABASE_URL``, or the file ``…_URL_FILE`` names.

        Empty when neither is set.

        Raises:
            CannotStart: the file cannot be read.

        """
        file = environment.get("TALAIA_DATABASE_URL_FILE", "")
        if not file or environment.get("TALAIA_DATABASE_URL"):
            return environment.get("TALAIA_DATABASE_URL", "")
        try:
            return Path(file).read_text().strip()
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise CannotStart(
                f"TALAIA_DATABASE_URL_FILE {file} cannot be read: {reason}",
                "name a file that holds the database's URL",
            ) from error


def is_loopback(host: str) -> bool:
    """Tell whether an address reaches this machine only."""
    # By its name only; another name could lead anywhere the next time it is asked.
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
