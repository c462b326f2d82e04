"""Cross-checks of connections, and of which one a device is reached by; part of `check`.

What a protocol asks of its sources and commands stands with the protocol: see `connections`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, id_fits
from talaia.model.checks.indi_setup_checks import setup_findings
from talaia.model.closed_lists import DeviceKind
from talaia.model.connection import DerivedSource, rules_of
from talaia.model.connections.indi import indi_word_fits
from talaia.model.errors import UnknownWord

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.connection import Connection
    from talaia.model.site import Device, Site

__all__ = ["NO_CONNECTION", "connection_findings", "frames_findings", "link_of"]

NO_CONNECTION = "its signals need a connection, and the site has none"


def connection_findings(site: Site) -> Iterator[Finding]:
    """List what is wrong with a site's connections."""
    if site.ros2 is not None and "ros2" in site.connections:
        yield Finding(
            "$.connections.ros2", "ros2 is described twice", "leave out the key ros2 of the site"
        )
    for name, connection in site.links().items():
        # The path as it stands in the file.
        short = site.ros2 is not None and name == "ros2"
        where = "$.ros2" if short else f"$.connections.{name}"
        yield from id_fits(where, name)
        yield from rules_of(connection).own_findings(where)


def link_of(site: Site, where: str, device: Device) -> tuple[Connection | None, list[Finding]]:
    """Find the connection of a device, or what is wrong about it."""
    links = site.links()
    if device.connection:
        link = links.get(device.connection)
        # Named, and not there. Where there is no connection at all, that is said below instead.
        if link is None and links:
            word = UnknownWord(f"{where}.connection", "connection", device.connection, links)
            return None, [Finding(word.where, word.problem, word.remedy)]
        if link is not None:
            return link, _device_findings(where, device, link)
    needs = _signals_read(device) or device.streams or device.commands or device.frames
    if not links:
        if not needs:
            return None, []
        remedy = "add ros2: {} above devices, or connections: with the protocol of your robot"
        return None, [Finding(where, NO_CONNECTION, remedy)]
    if len(links) == 1:
        link = next(iter(links.values()))
        return link, _device_findings(where, device, link)
    if not needs and device.drive is None:
        return None, []
    problem = "the site has several connections, and which one is meant is not said"
    remedy = f"write connection: and one of: {', '.join(sorted(links))}"
    return None, [Finding(f"{where}.connection", problem, remedy)]


def _signals_read(device: Device) -> bool:
    """Tell whether a device has signals of its own; what is worked out needs no connection."""
    return any(not isinstance(signal.source, DerivedSource) for signal in device.signals.values())


def _device_findings(where: str, device: Device, link: Connection) -> list[Finding]:
    found = [*rules_of(link).device_findings(where, device)]
    # The name goes to the INDI server, which has its own bounds.
    if device.indi:
        found += indi_word_fits(f"{where}.indi", device.indi, "INDI device")
    return [*found, *setup_findings(where, device)]


def frames_findings(where: str, device: Device, link: Connection) -> Iterator[Finding]:
    """List what is wrong with where a camera's FITS files come from."""
    if device.frames is None:
        return
    if device.kind is not DeviceKind.CAMERA:
        problem = f"only a camera has FITS files, and this is of kind {device.kind}"
        yield Finding(where, problem, "write at the device: kind: camera")
    yield from rules_of(link).frames_findings(where, device)
