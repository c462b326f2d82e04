"""Looks at an Alpaca server: its devices and what they answer. Sets nothing, unless told to."""

from __future__ import annotations

import asyncio
import ipaddress
import time
from typing import TYPE_CHECKING

from talaia.gateway.adapters.alpaca.discovery import device_of, unique_word
from talaia.gateway.adapters.alpaca.found_devices import ask_device, list_devices
from talaia.gateway.adapters.alpaca.protocol import AlpacaRefused
from talaia.gateway.adapters.alpaca.server import AlpacaServer
from talaia.gateway.adapters.http.fetching import FetchFailed
from talaia.gateway.errors import AdapterLost
from talaia.model.connection import AlpacaConnection
from talaia.model.discovery.probe_report import (
    FORMAT,
    DeviceFound,
    ElementFound,
    Found,
    PropertyFound,
)

if TYPE_CHECKING:
    from talaia.gateway.adapters.alpaca.discovery import FoundDevice
    from talaia.gateway.adapters.alpaca.protocol import Configured

__all__ = ["is_here", "probe_alpaca"]

_CONNECT_S = 60.0
# A driver that was only just started takes its time, and a person is there who waits.
_ANSWER_S = 15.0
_MOST_SHOWN = 200


def is_here(host: str) -> bool:
    """Tell whether a host is this computer itself, which a description has to say."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def probe_alpaca(host: str, port: int, *, connect: bool = False) -> Found:
    """Ask a server what it has.

    Args:
        host: where it answers.
        port: its TCP port.
        connect: tell devices to connect to their hardware first: most say little before that.

    Raises:
        AdapterLost: it does not answer, or is no Alpaca server.

    """
    return asyncio.run(_probe_server(host, port, connect=connect))


async def _probe_server(host: str, port: int, *, connect: bool) -> Found:
    connection = AlpacaConnection(host=host, port=port, here=is_here(host), timeout=_ANSWER_S)
    server = AlpacaServer(connection)
    began = time.monotonic()
    try:
        listed = await list_devices(server)
        devices = [await _look_at(server, one, connect=connect) for one in listed]
    except (FetchFailed, AlpacaRefused) as error:
        raise AdapterLost(f"the Alpaca server {server.where}: {error}") from error
    finally:
        server.close()
    words: list[str] = []
    found: list[DeviceFound] = []
    for answers, connected in devices:
        words.append(unique_word(answers.device.replace("/", "_"), words))
        found.append(
            DeviceFound(
                answers.name or answers.device,
                answers.device,
                connected,
                tuple(_property_found(name, value) for name, value in answers.answers.items()),
                words[-1],
                device_of(answers, "") if connected else None,
            )
        )
    return Found(
        talaia_probe=FORMAT,
        protocol="alpaca",
        where=f"Alpaca server {server.where}",
        seconds=round(time.monotonic() - began, 1),
        host=host,
        port=port,
        devices=tuple(found),
    )


async def _look_at(
    server: AlpacaServer, one: Configured, *, connect: bool
) -> tuple[FoundDevice, bool]:
    connected = False
    try:
        connected = await server.ask_property(f"{one.device}/connected") is True
        if connect and not connected:
            await server.put_method(f"{one.device}/connected", {"Connected": True}, _CONNECT_S)
            connected = await server.ask_property(f"{one.device}/connected") is True
    except AlpacaRefused:
        # It is told with what it answers all the same.
        connected = False
    except FetchFailed as error:
        raise FetchFailed(f"{one.device}: {error}") from error
    return await ask_device(server, one), connected


def _property_found(name: str, value: object) -> PropertyFound:
    kind = {bool: "switch", int: "number", float: "number"}.get(type(value), "text")
    shown = "" if value is None else str(value)[:_MOST_SHOWN]
    return PropertyFound(name, kind, elements=(ElementFound("", "", shown),))
