"""``talaia hub``: words, variables and settings file, before the server itself is imported.

So ``--help`` and wrong words are answered at once. Long, because all options are read together.
"""

from __future__ import annotations

import argparse
import ipaddress
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.hub.audit_options import add_audit_options
from talaia.hub.errors import CannotStart
from talaia.hub.files_options import add_files_options
from talaia.hub.settings import Settings, is_loopback
from talaia.log_setup import add_log_options
from talaia.program_options import parse_options, print_settings
from talaia.quiet_import import quiet_imports

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.settings import Network

__all__ = ["main"]

# Of the variables that say what the options say.
_PREFIX = "TALAIA_HUB_"


def main(argv: Sequence[str]) -> int:
    """Serve until SIGTERM or SIGINT; 0 after a clean end, 2 when it cannot start."""
    options, sources = parse_options(_make_parser(), argv, _PREFIX)
    if options.show_settings:
        print_settings(sources)
        return 0
    try:
        settings = _make_settings(options)
    except CannotStart as error:
        sys.stderr.write(f"talaia hub: {error}\n")
        return 2
    # The server and all its libraries: more than a second of a core.
    with quiet_imports():
        from talaia.hub.run import serve_hub

    return serve_hub(settings, options.log_level, options.log_format)


def _read_port(text: str) -> int:
    # ASCII digits only: `int` takes those of other scripts as well.
    if not text.isascii() or not text.isdigit() or not 0 <= int(text) <= 65_535:
        raise argparse.ArgumentTypeError(f"{text} is not a port from 0 to 65535")
    return int(text)


def _make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("talaia hub", description="Serve the control room.")
    parser.add_argument(
        "--data", type=Path, default=Path("talaia-data"), help="data folder (talaia-data)"
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (127.0.0.1)")
    parser.add_argument("--port", type=_read_port, default=8443, help="0 takes any free one (8443)")
    parser.add_argument("--plain", action="store_true", help="no TLS; on a loopback address only")
    parser.add_argument(
        "--tls-cert",
        "--cert",
        type=Path,
        metavar="FILE",
        help="certificate chain (PEM); else one is made",
    )
    said = "the certificate's private key (PEM)"
    parser.add_argument("--tls-key", "--key", type=Path, metavar="FILE", help=said)
    parser.add_argument(
        "--allow-host",
        "--name",
        action="append",
        default=[],
        metavar="NAME",
        help="another host name under which this hub is reached; may repeat",
    )
    _add_proxies(parser)
    parser.add_argument(
        "--notify-network",
        action="append",
        default=[],
        metavar="NETWORK",
        help="messages about alarms may go to servers in this network besides public addresses;"
        " may repeat",
    )
    parser.add_argument(
        "--history-gb",
        type=float,
        default=0.0,
        help="the history's blocks may take so many GB; then the oldest go (no limit)",
    )
    parser.add_argument(
        "--recordings-gb",
        type=float,
        default=20.0,
        help="recordings of one site may take so many GB; then its oldest go (20; 0: no limit)",
    )
    parser.add_argument(
        "--sightings-days",
        type=float,
        default=90.0,
        help="what cameras have seen is kept for so many days (90; 0: for good)",
    )
    parser.add_argument(
        "--sightings-most",
        type=int,
        default=10_000,
        help="of each site so many sightings are kept at the most; then the oldest go (10000)",
    )
    _add_robot_log(parser)
    parser.add_argument(
        "--extensions",
        type=Path,
        metavar="FOLDER",
        help="web components of the administrator's own, a folder for each tile, that devices'"
        " pages show; read at the start",
    )
    _add_neighbours(parser)
    add_log_options(parser)
    return parser


def _add_robot_log(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--robot-log-days",
        type=float,
        default=30.0,
        help="lines of robots' own logs are kept for so many days (30; 0: for good)",
    )
    parser.add_argument(
        "--robot-log-most",
        type=int,
        default=200_000,
        help="of each site so many of those lines are kept; then the oldest go (200000)",
    )


def _add_proxies(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--proxy",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="address or network of a reverse proxy that ends TLS before this hub; its"
        " X-Forwarded headers are believed, and nobody else's; may repeat",
    )
    parser.add_argument(
        "--proxy-protocol",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="address or network of a load balancer that lets TLS pass, and says by the PROXY"
        " protocol (version 2) who comes; connections from there begin with it; may repeat",
    )


def _add_neighbours(parser: argparse.ArgumentParser) -> None:
    said = "names a provider (OpenID Connect) by which people sign in besides"
    parser.add_argument("--oidc", type=Path, metavar="FILE", help=said)
    parser.add_argument(
        "--mqtt",
        type=Path,
        metavar="FILE",
        help="names an MQTT broker and what is published there, once an admin opens it",
    )
    parser.add_argument(
        "--alpaca",
        type=Path,
        metavar="FILE",
        help="says at which address a site's domes, weather and safety are served as ASCOM Alpaca"
        " devices, once an admin opens it",
    )
    parser.add_argument(
        "--alerts",
        type=Path,
        metavar="FOLDER",
        help="notices of transients (VOEvent, GCN's JSON) that come there become rapid requests by"
        " the rules of proposals",
    )
    parser.add_argument(
        "--archive-hook",
        type=Path,
        metavar="FILE",
        help="names a command or webhook to which each new picture is handed over",
    )
    add_audit_options(parser)
    _add_cluster(parser)
    said = "names databases for sites' histories besides the hub's own, and which has whose"
    parser.add_argument("--history-servers", type=Path, metavar="FILE", help=said)
    add_files_options(parser)
    parser.add_argument(
        "--simulated-site",
        action="append",
        default=[],
        metavar="SITE",
        help="a site that is a simulator: its page has a button for a night in minutes; repeatable",
    )
    parser.add_argument(
        "--assets",
        type=Path,
        metavar="FOLDER",
        help="meshes of robots for Foxglove, in a folder for each site: package://arm/a.stl of the"
        " site agv is agv/arm/a.stl",
    )
    parser.add_argument(
        "--maps",
        type=Path,
        metavar="FOLDER",
        help="maps that pages show under the robots: files named *.pmtiles",
    )


def _add_cluster(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--cluster",
        action="append",
        default=[],
        metavar="URL",
        help="address of NATS (nats:// or tls://, with user and password if it asks), by which"
        " several hubs on one database are one; may repeat for the servers of one NATS",
    )
    said = (
        "file that holds the addresses of NATS, so that no password stands in a list of processes"
    )
    parser.add_argument("--cluster-file", type=Path, metavar="FILE", help=said)
    said = "name of this hub among several (the machine's name and the port)"
    parser.add_argument("--cluster-name", default="", metavar="NAME", help=said)
    said = "certificate authorities of NATS (PEM); else the system's"
    parser.add_argument("--cluster-ca", type=Path, metavar="FILE", help=said)


def _make_settings(options: argparse.Namespace) -> Settings:
    # On loopback it is for development, or for a proxy on this machine that ends TLS.
    if options.plain and not is_loopback(options.host):
        raise CannotStart(
            f"--plain would send passwords over the network on {options.host}",
            "leave --plain out, or listen on 127.0.0.1",
        )
    if options.assets is not None and not options.assets.is_dir():
        raise CannotStart(f"--assets: {options.assets} is no folder", "name one, or leave it out")
    if options.maps is not None and not options.maps.is_dir():
        raise CannotStart(f"--maps: {options.maps} is no folder", "name one, or leave it out")
    if options.alerts is not None and not options.alerts.is_dir():
        raise CannotStart(f"--alerts: {options.alerts} is no folder", "name one, or leave it out")
    database_url = Settings.url_from(os.environ)
    addresses = options.cluster or _read_cluster_file(options.cluster_file)
    cluster = _read_cluster(addresses, database_url)
    return Settings(
        data=options.data,
        host=options.host,
        port=options.port,
        plain=options.plain,
        cert=options.tls_cert,
        key=options.tls_key,
        hosts=tuple(options.allow_host),
        proxies=_read_networks("--proxy", options.proxy),
        balancers=_read_networks("--proxy-protocol", options.proxy_protocol),
        notify_networks=_read_networks("--notify-network", options.notify_network),
        cluster=cluster,
        cluster_name=options.cluster_name[:200],
        cluster_ca=options.cluster_ca,
        database_url=database_url,
        files=options.files,
        files_endpoint=options.files_endpoint,
        files_region=options.files_region,
        files_key_file=options.files_key_file,
        files_ca=options.files_ca,
        history_servers=options.history_servers,
        history_bytes=max(0, round(options.history_gb * 1e9)),
        recordings_bytes=max(0, round(options.recordings_gb * 1e9)),
        sightings_days=max(0.0, options.sightings_days),
        sightings_most=max(1, options.sightings_most),
        robot_log_days=max(0.0, options.robot_log_days),
        robot_log_most=max(1, options.robot_log_most),
        extensions=options.extensions,
        assets=options.assets,
        maps=options.maps,
        oidc=options.oidc,
        mqtt=options.mqtt,
        alpaca=options.alpaca,
        alerts=options.alerts,
        archive_hook=options.archive_hook,
        audit_heads=tuple(options.audit_heads),
        audit_syslog=options.audit_syslog,
        audit_mail=options.audit_mail or "",
        audit_mail_s=options.audit_mail_hours * 3600.0,
        audit_hub=options.audit_hub,
        simulated_sites=tuple(options.simulated_site),
    )


def _read_cluster_file(file: Path | None) -> list[str]:
    if file is None:
        return []
    try:
        found = file.read_text().split()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise CannotStart(
            f"--cluster-file {file} cannot be read: {reason}", "name a file of NATS's addresses"
        ) from error
    # A hub that took itself for alone would be refused by the others' lock, and say nothing of it.
    if not found:
        raise CannotStart(f"--cluster-file {file} is empty", "write the addresses of NATS there")
    return found


def _read_cluster(addresses: Sequence[str], database_url: str) -> tuple[str, ...]:
    # From the environment they come as one.
    found = tuple(part for address in addresses for part in address.split(",") if part)
    for address in found:
        parts = urlsplit(address)
        if parts.scheme not in {"nats", "tls"} or not parts.hostname:
            # Not shown: it may hold a password.
            raise CannotStart(
                "--cluster: an address is none of NATS", "write it like nats://10.0.0.5:4222"
            )
        if parts.scheme == "nats" and parts.password and not is_loopback(parts.hostname):
            raise CannotStart(
                "--cluster: a password would go over the network in clear text",
                "write tls:// instead of nats://",
            )
    if found and not database_url.startswith(("postgres", "mysql", "mariadb")):
        raise CannotStart(
            "--cluster needs a database that several hubs can use",
            "set TALAIA_DATABASE_URL to one of PostgreSQL or MariaDB",
        )
    return found


def _read_networks(option: str, texts: Sequence[str]) -> tuple[Network, ...]:
    try:
        return tuple(ipaddress.ip_network(text) for text in texts)
    except ValueError as error:
        raise CannotStart(f"{option}: {error}", "write it like 10.0.0.5 or 10.0.0.0/24") from error
