"""``--mqtt`` and ``--http`` of `talaia probe` and `talaia init`: brokers, and servers of JSON."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.cli.errors import CliError, PartMissing

if TYPE_CHECKING:
    import argparse

    from talaia.model.discovery.probe_report import Found

__all__ = ["add_server_options", "look_at_broker", "look_at_server"]


def add_server_options(parser: argparse.ArgumentParser) -> None:
    """Add how to sign in at a broker or a server."""
    parser.add_argument("--user", default="", help="MQTT, HTTP: who signs in")
    parser.add_argument(
        "--password-file",
        default="",
        help="a file with that user's password; passwords stand in no command",
    )
    parser.add_argument("--token-file", default="", help="HTTP: a file with a bearer token")
    parser.add_argument(
        "--ca", default="", help="mqtts, https: a file of authorities (default: the system's)"
    )


def look_at_broker(options: argparse.Namespace, seconds: float) -> Found:
    """Listen to all topics of a broker for a while.

    Raises:
        CliError: it is no broker's address.
        PartMissing: what it takes is not installed here.
        AdapterLost: it is not reached.

    """
    # People name a broker by its host; without TLS then, as its tools do.
    url = options.mqtt if "://" in options.mqtt else f"mqtt://{options.mqtt}"
    _check_address("--mqtt", url, ("mqtt", "mqtts"), "mqtts://broker.local")
    if urlsplit(url).path.strip("/"):
        raise CliError(f"--mqtt: expected a broker without a path, found {url!r}")
    # Here, not at the top: the other protocols can be looked at without it.
    try:
        from talaia.gateway.adapters.mqtt.probe import BrokerLogin, probe_broker
    except ImportError as error:
        raise PartMissing("talaia probe --mqtt", error.name or "aiomqtt", "gateway") from error
    print(f"listening for {seconds:g} s …", file=sys.stderr, flush=True)
    login = BrokerLogin(url, Path(), options.user, options.password_file, options.ca)
    return probe_broker(login, seconds)


def look_at_server(options: argparse.Namespace) -> Found:
    """Ask for an address once.

    Raises:
        CliError: it is no address.
        AdapterLost: it does not answer, or with what cannot be read.

    """
    from talaia.gateway.adapters.http.probe import probe_address
    from talaia.model.discovery.probe_report import FORMAT, Found

    url = options.http
    _check_address("--http", url, ("http", "https"), "http://192.168.1.30/api/status")
    asked = Found(
        talaia_probe=FORMAT,
        protocol="http",
        where=f"the server at {url}",
        seconds=0.0,
        url=url,
        user=options.user,
        password_file=options.password_file,
        token_file=options.token_file,
        ca=options.ca,
    )
    print("asking …", file=sys.stderr, flush=True)
    return probe_address(asked, Path())


def _check_address(option: str, url: str, schemes: tuple[str, ...], example: str) -> None:
    """Refuse what is no address of these schemes.

    Raises:
        CliError: it is none, or holds a password.

    """
    try:
        parts = urlsplit(url)
        known = parts.scheme in schemes and parts.hostname and parts.port != 0
    except ValueError as error:
        raise CliError(f"{option}: expected {example}, found {url!r}") from error
    if not known:
        raise CliError(f"{option}: expected {example}, found {url!r}")
    # It would stand in the description, and in the list of processes.
    if "@" in parts.netloc:
        raise CliError(f"{option}: name the user by --user and the password by --password-file")
