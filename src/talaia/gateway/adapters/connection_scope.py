"""What one connection serves of a site. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.model.connection import DerivedSource, DetectionSource

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.connection import Connection
    from talaia.model.site import Device, Site

__all__ = ["ConnectionScope", "connection_names", "scopes_of"]


class ConnectionScope(NamedTuple):
    """The part of a site that one adapter speaks for, and of which it may say anything.

    Attributes:
        name: of the connection.
        devices: those reached by it, by name; without what is seen on their cameras or worked out
            from other signals, which no robot says.
        channel: by the address of a signal of theirs: the number of its first channel, which is
            what samples carry; see `ChannelNumbering`.
        guarded: signals of theirs whose newest readings must be at hand; see `Site.safety_signals`.

    """

    name: str
    connection: Connection
    devices: Mapping[str, Device]
    channel: Mapping[str, int]
    guarded: frozenset[str]


def connection_names(site: Site) -> dict[str, str]:
    """Name the connection of each device of a site; empty for one that has none."""
    return {device: site.connection_of(device) for device in site.devices}


def scopes_of(site: Site, numbering: ChannelNumbering | None = None) -> list[ConnectionScope]:
    """Cut a site into what each of its connections serves, in the order of the description.

    Without a ``numbering`` channels are numbered by their place in `Site.channels`.
    """
    # Once for all connections, so that each number is given once.
    first = (numbering or ChannelNumbering(site)).numbers_of(site)
    guarded = site.safety_signals()
    of = connection_names(site)
    scopes = []
    for name, connection in site.links().items():
        devices = {
            device: _without_own_signals(site.devices[device])
            for device in site.devices
            if of[device] == name
        }
        channel = {
            f"{device_id}/{signal_id}": first[f"{device_id}/{signal_id}"]
            for device_id, device in devices.items()
            for signal_id in device.signals
        }
        scopes.append(ConnectionScope(name, connection, devices, channel, guarded & channel.keys()))
    return scopes


def _without_own_signals(device: Device) -> Device:
    """Leave out what is seen, and what is worked out from other signals."""
    signals = {
        name: signal
        for name, signal in device.signals.items()
        if not isinstance(signal.source, DerivedSource | DetectionSource)
    }
    # What looks at pictures goes as well: an adapter has nothing to do with it.
    streams = {
        name: msgspec.structs.replace(stream, detect=None, models={})
        if stream.detect is not None or stream.models
        else stream
        for name, stream in device.streams.items()
    }
    if len(signals) == len(device.signals) and streams == device.streams:
        return device
    return msgspec.structs.replace(device, signals=signals, streams=streams)
