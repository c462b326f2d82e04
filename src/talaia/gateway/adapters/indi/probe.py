"""Looks at an INDI server: its devices and all their properties.

Asks for what there is and sets nothing, unless it is told to connect drivers: most show little
before that. `talaia.gateway.adapters.indi` reads what comes, as for the adapter.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from typing import TYPE_CHECKING

from talaia.gateway.adapters.indi.description.labels import word_of
from talaia.gateway.adapters.indi.discovery import devices_of
from talaia.gateway.adapters.indi.errors import IndiError
from talaia.gateway.adapters.indi.protocol import (
    BlobEnd,
    BlobHead,
    BlobPart,
    IndiParser,
    PropertyPermission,
    PropertyState,
    VectorKind,
    ask_properties,
    new_vector,
)
from talaia.gateway.adapters.indi.state import IndiDeviceTree
from talaia.gateway.errors import AdapterLost
from talaia.model.discovery.probe_report import (
    FORMAT,
    DeviceFound,
    ElementFound,
    Found,
    PropertyFound,
)

if TYPE_CHECKING:
    from talaia.gateway.adapters.indi.protocol import Element
    from talaia.gateway.adapters.indi.state import IndiDevice, StoredVector

__all__ = ["probe_server"]

OPEN_S = 5.0
# Drivers define their properties in bursts; after so long without one, that was all.
QUIET_S = 2.0
READ_BYTES = 256 * 1024
MAX_SHOWN = 200


def probe_server(host: str, port: int, seconds: float, *, connect: bool = False) -> Found:
    """Ask a server what it has.

    Args:
        host: where it answers.
        port: its TCP port.
        seconds: longest to listen (s); shorter when nothing new comes any more.
        connect: tell drivers to connect to their hardware first.

    Raises:
        AdapterLost: it does not answer, or is no INDI server.

    """
    return asyncio.run(_probe_server(host, port, seconds, connect=connect))


async def _probe_server(host: str, port: int, seconds: float, *, connect: bool) -> Found:
    where = f"the INDI server {host}:{port}"
    try:
        async with asyncio.timeout(OPEN_S):
            reader, writer = await asyncio.open_connection(host, port, limit=READ_BYTES)
    except (OSError, TimeoutError) as error:
        raise AdapterLost(f"{where} cannot be reached: {str(error) or 'no answer'}") from error
    looking = _Look(reader, writer, connect=connect)
    began = time.monotonic()
    try:
        async with asyncio.timeout(seconds):
            await looking.listen_until_quiet()
    except TimeoutError:
        pass
    except (OSError, IndiError) as error:
        raise AdapterLost(f"{where} was lost: {error}") from error
    finally:
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()
    return Found(
        talaia_probe=FORMAT,
        protocol="indi",
        where=where.removeprefix("the "),
        seconds=round(time.monotonic() - began, 1),
        host=host,
        port=port,
        devices=_devices_found(looking.book),
    )


class _Look:
    """One conversation with a server."""

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, *, connect: bool
    ) -> None:
        self.book = IndiDeviceTree()
        self._reader, self._writer = reader, writer
        self._connect = connect
        self._asked: set[str] = set()

    async def listen_until_quiet(self) -> None:
        """Take in what comes until nothing new has come for a while."""
        words = IndiParser()
        self._writer.write(ask_properties())
        quiet_at = time.monotonic() + QUIET_S
        while True:
            try:
                async with asyncio.timeout(max(quiet_at - time.monotonic(), 0.0)):
                    data = await self._reader.read(READ_BYTES)
            except TimeoutError:
                return
            if not data:
                raise IndiError("it closed the connection")
            if self._apply_data(words, data):
                quiet_at = time.monotonic() + QUIET_S

    def _apply_data(self, words: IndiParser, data: bytes) -> bool:
        """Take bytes in; tell whether they brought more than values of what was known."""
        news = False
        for event in words.parse_data(data):
            if isinstance(event, BlobHead | BlobPart | BlobEnd):
                continue
            before = sum(len(device.vectors) for device in self.book)
            held = self.book.apply_event(event, time.monotonic_ns())
            news |= sum(len(device.vectors) for device in self.book) != before
            if held is not None and held.name == "CONNECTION":
                # It answers at once or after a while; in between nothing comes.
                news |= held.state is PropertyState.BUSY or self._ask_connect(held)
        return news

    def _ask_connect(self, held: StoredVector) -> bool:
        """Tell a driver to connect, once."""
        if not self._connect or held.device in self._asked or held.element_value("CONNECT") is True:
            return False
        self._asked.add(held.device)
        asked = {"CONNECT": True, "DISCONNECT": False}
        self._writer.write(new_vector(VectorKind.SWITCH, held.device, "CONNECTION", asked))
        return True


def _devices_found(book: IndiDeviceTree) -> tuple[DeviceFound, ...]:
    found = []
    words: set[str] = set()
    for device in sorted(book, key=lambda device: device.name):
        described = devices_of([device], "", words)
        word, one = next(iter(described.items()), (word_of(device.name, words, "device"), None))
        words.add(word)
        there = device.connected or "CONNECTION" not in device.vectors
        found.append(
            DeviceFound(
                device.name,
                _driver_name(device),
                there,
                tuple(_property_found(vector) for vector in device.vectors.values()),
                word,
                one if there else None,
            )
        )
    return tuple(found)


def _driver_name(device: IndiDevice) -> str:
    """Name the program and its version, as ``DRIVER_INFO`` has them."""
    words = (
        device.element_value("DRIVER_INFO", element)
        for element in ("DRIVER_EXEC", "DRIVER_VERSION")
    )
    return " ".join(str(word) for word in words if word)


def _property_found(held: StoredVector) -> PropertyFound:
    return PropertyFound(
        held.name,
        held.kind.value.lower(),
        held.label,
        held.group,
        held.state.value,
        held.perm is not PropertyPermission.READ,
        tuple(_element_found(held.kind, element) for element in held.elements.values()),
    )


def _element_found(kind: VectorKind, element: Element) -> ElementFound:
    match element.value:
        case bool() as on:
            value = "on" if on else "off"
        case float() as number:
            value = f"{number:.10g}"
        case text:
            value = text[:MAX_SHOWN] if kind is not VectorKind.BLOB else ""
    return ElementFound(element.name, element.label, value, element.minimum, element.maximum)
