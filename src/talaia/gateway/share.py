"""What one connection serves of a site. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.roster import Roster

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.connection import Connection
    from talaia.model.site import Device, Site

__all__ = ["Share", "shares_of"]


class Share(NamedTuple):
    """The part of a site that one adapter speaks for, and of which it may say anything.

    Attributes:
        name: of the connection.
        devices: those reached by it, by name.
        channel: by the address of a signal of theirs: the number of its first channel, which is
            what samples carry; see `Roster`.
        guarded: signals of theirs whose newest readings must be at hand; see `Site.guarded`.

    """

    name: str
    connection: Connection
    devices: Mapping[str, Device]
    channel: Mapping[str, int]
    guarded: frozenset[str]


def shares_of(site: Site, roster: Roster | None = None) -> list[Share]:
    """Cut a site into what each of its connections serves, in the order of the description.

    Without a ``roster`` channels are numbered by their place in `Site.channels`.
    """
    first = (roster or Roster(site)).numbers(site)
    guarded = site.guarded()
    of = {device: site.connection_of(device) for device in site.devices}
    shares = []
    for name, connection in site.links().items():
        devices = {each: site.devices[each] for each in site.devices if of[each] == name}
        channel = {
            address: index
            for address, index in first.items()
            if address.split("/", 1)[0] in devices
        }
        shares.append(Share(name, connection, devices, channel, guarded & channel.keys()))
    return shares
