"""Servers and cameras that `talaia probe` and `init` ask: MQTT, HTTP, rosbridge, Alpaca, ONVIF."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.cli.errors import CliError, PartMissing

if TYPE_CHECKING:
    import argparse

    from talaia.model.discovery.probe_report import Found

__all__ = [
    "add_server_options",
    "look_at_alpaca",
    "look_at_bridge",
    "look_at_broker",
    "look_at_cameras",
    "look_at_server",
    "read_server_address",
]

# Their usual ones.
_ALPACA_PORT = 11_111
_BRIDGE_PORT = 9090


def add_server_options(parser: argparse.ArgumentParser) -> None:
    """Add how to sign in at a broker or a server."""
    parser.add_argument("--user", default="", help="MQTT, HTTP, ONVIF: who signs in")
    parser.add_argument(
        "--password-file",
        default="",
        help="a file with that user's password; passwords stand in no command",
    )
    parser.add_argument(
        "--token-file", default="", help="HTTP, rosbridge: a file with a bearer token"
    )
    parser.add_argument(
        "--ca", default="", help="mqtts, https, wss: a file of authorities (default: the system's)"
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


def look_at_bridge(options: argparse.Namespace, seconds: float) -> Found:
    """Ask a rosbridge server what its robot has, and listen for a while.

    Raises:
        CliError: it is no such server's address.
        PartMissing: what it takes is not installed here.
        AdapterLost: it is not reached, or has no rosapi.

    """
    # People name it by its host; without TLS then, as its own tools do.
    url = options.rosbridge
    if "://" not in url:
        host, port = read_server_address("--rosbridge", url, _BRIDGE_PORT)
        url = f"ws://{f'[{host}]' if ':' in host else host}:{port}"
    _check_address("--rosbridge", url, ("ws", "wss"), "ws://robot.local:9090")
    # Here, not at the top: the other protocols can be looked at without it.
    try:
        from talaia.gateway.adapters.rosbridge.probe import probe_bridge
    except ImportError as error:
        raise PartMissing("talaia probe --rosbridge", error.name or "rosbags", "gateway") from error
    from talaia.model.discovery.probe_report import FORMAT, Found

    # As MQTT and HTTP: what was asked goes along, so that the description has it.
    asked = Found(
        talaia_probe=FORMAT,
        protocol="rosbridge",
        where=f"the rosbridge server {url}",
        seconds=seconds,
        url=url,
        token_file=options.token_file,
        ca=options.ca,
    )
    print(f"listening for {seconds:g} s …", file=sys.stderr, flush=True)
    return probe_bridge(asked, Path())


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


def look_at_alpaca(options: argparse.Namespace, seconds: float) -> Found:
    """Ask an Alpaca server what it has; without a host, the one that answers a broadcast.

    Raises:
        CliError: it is no host, or none or several servers answer.
        AdapterLost: it does not answer.

    """
    from talaia.gateway.adapters.alpaca.probe import probe_alpaca
    from talaia.gateway.adapters.alpaca.search import search_servers

    place = options.alpaca
    if not place:
        print(f"asking who is there, for {seconds:g} s …", file=sys.stderr, flush=True)
        try:
            found = search_servers(seconds)
        except OSError as error:
            raise CliError(f"--alpaca: nobody can be asked: {error}; name a host") from error
        if len(found) != 1:
            named = ", ".join(f"{server.host}:{server.port}" for server in found)
            several = f"several servers answer; name one of: {named}"
            raise CliError(f"--alpaca: {several if named else 'no server answers; name a host'}")
        host, port = found[0]
    else:
        host, port = read_server_address("--alpaca", place, _ALPACA_PORT)
    print("asking …", file=sys.stderr, flush=True)
    return probe_alpaca(host, port, connect=options.connect)


def look_at_cameras(options: argparse.Namespace, seconds: float) -> Found:
    """Look at the ONVIF camera that is named, or at all that answer in the network.

    Raises:
        CliError: it is no address, or nobody can be asked.
        AdapterLost: the named one does not answer.

    """
    from talaia.gateway.adapters.onvif.probe import probe_cameras
    from talaia.gateway.adapters.onvif.search import FoundCamera, search_cameras

    if options.token_file:
        raise CliError("--token-file is for --http and --rosbridge")
    url = options.onvif
    if url:
        url = url if "://" in url else f"http://{url}"
        _check_address("--onvif", url, ("http", "https"), "http://camera.local")
        # Where nearly all cameras have it.
        if urlsplit(url).path in ("", "/"):
            url = f"{url.rstrip('/')}/onvif/device_service"
        cameras = [FoundCamera(url, "", "")]
    else:
        if options.user or options.password_file or options.ca:
            raise CliError(
                "--onvif: name the camera that is signed in at (--onvif http://HOST): a password "
                "goes to no address that only an answer in the network has named"
            )
        print(f"asking who is there, for {seconds:g} s …", file=sys.stderr, flush=True)
        try:
            cameras = search_cameras(seconds)
        except OSError as error:
            raise CliError(f"--onvif: nobody can be asked: {error}; name a camera") from error
        if not cameras:
            raise CliError(
                "--onvif: no camera answers; name one (--onvif http://HOST): a search reaches the "
                "own network only, and ONVIF may have to be switched on in the camera first"
            )
    print("asking …", file=sys.stderr, flush=True)
    return probe_cameras(
        cameras,
        Path(),
        user=options.user,
        password_file=options.password_file,
        ca=options.ca,
    )


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


def read_server_address(option: str, place: str, usual_port: int) -> tuple[str, int]:
    """Read ``HOST`` or ``HOST:PORT`` of an option.

    Raises:
        CliError: it is neither.

    """
    try:
        # With slashes before it, so that `urlsplit` takes it for a host, and brackets for IPv6.
        where = urlsplit(f"//{place}")
        host, port = where.hostname or "", where.port or usual_port
    except ValueError as error:
        raise CliError(f"{option}: expected HOST or HOST:PORT, found {place!r}") from error
    if not host:
        raise CliError(f"{option}: expected HOST or HOST:PORT, found {place!r}")
    return host, port
