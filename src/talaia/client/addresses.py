"""Which signals, commands and devices a script means. Pure.

An address is ``site/device/name``; where the token sees one site alone, ``device/name`` does.
``*`` and ``?`` stand for other letters, so that ``agv/base/*`` means all of a device.
"""

from __future__ import annotations

import difflib
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, NamedTuple

from talaia.client.errors import BadSettings, NotFound, NotPermitted

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.client.values import CommandInfo, DeviceInfo, SignalInfo, SiteInfo

__all__ = [
    "WatchedChannel",
    "channels_of",
    "find_command",
    "find_device",
    "has_pattern",
    "match_sites",
    "qualify_address",
]

_PART_UNITS = {"x": "m", "y": "m", "yaw": "rad", "lat": "°", "lon": "°", "alt": "m"}


class WatchedChannel(NamedTuple):
    """A channel of a site, by the site's own address, and the signal that it belongs to."""

    channel: str
    signal: SignalInfo

    @property
    def unit(self) -> str:
        """The unit of its numbers."""
        return _PART_UNITS.get(self.channel.partition(".")[2], self.signal.unit)


def has_pattern(text: str) -> bool:
    """Tell whether an address stands for several."""
    return not {"*", "?", "["}.isdisjoint(text)


def qualify_address(address: str, sites: Sequence[str], *, parts: int = 3) -> str:
    """Give an address with its site.

    Args:
        address: as a person wrote it.
        sites: those that the token sees.
        parts: how many an address with its site has.

    Raises:
        BadSettings: it is no address, or the site has to be named.

    """
    count = address.count("/") + 1
    if "" in address.split("/") or count not in {parts, parts - 1}:
        form = "site/device" if parts == 2 else "site/device/name"
        raise BadSettings(f"{address!r}: expected {form}")
    # `agv/*` is all of a site, and not a device of that name.
    whole_site = parts > count == 2 and has_pattern(address) and address.split("/")[0] in sites
    if count == parts or whole_site:
        return address
    if len(sites) != 1:
        raise BadSettings(
            f"{address!r}: name the site before it, one of {', '.join(sites) or 'none'}"
        )
    return f"{sites[0]}/{address}"


def match_sites(addresses: Sequence[str], sites: Sequence[str]) -> list[str]:
    """Give the sites that qualified addresses mean.

    Raises:
        NotFound: one means none.

    """
    found: dict[str, None] = {}
    for address in addresses:
        pattern = address.partition("/")[0]
        matched = [site for site in sites if fnmatchcase(site, pattern)]
        if not matched:
            raise _not_found("site", pattern, sites)
        found.update(dict.fromkeys(matched))
    return list(found)


def channels_of(site: SiteInfo, addresses: Sequence[str]) -> list[WatchedChannel]:
    """Give the channels of a site that qualified addresses mean, each once, in their order.

    Raises:
        NotFound: one that is no pattern means none.

    """
    known = [
        WatchedChannel(channel, signal)
        for device in site.devices
        for signal in device.signals
        for channel in signal.channels
    ]
    found: dict[str, WatchedChannel] = {}
    for address in addresses:
        place, _, pattern = address.partition("/")
        if not fnmatchcase(site.site, place):
            continue
        matched = [
            channel
            for channel in known
            if fnmatchcase(channel.channel, pattern) or fnmatchcase(channel.signal.address, pattern)
        ]
        if not matched and not has_pattern(address):
            names = [f"{site.site}/{channel.signal.address}" for channel in known]
            raise _not_found("signal", address, names)
        found.update({channel.channel: channel for channel in matched})
    return list(found.values())


def find_device(site: SiteInfo, device: str) -> DeviceInfo:
    """Find a device of a site.

    Raises:
        NotFound: there is none such, or it is not for this account.

    """
    for found in site.devices:
        if found.id == device:
            return found
    raise _not_found(
        "device", f"{site.site}/{device}", [f"{site.site}/{found.id}" for found in site.devices]
    )


def find_command(site: SiteInfo, address: str) -> tuple[DeviceInfo, CommandInfo]:
    """Find a command by its qualified address.

    Raises:
        NotPermitted: this account may use no command of the device.
        NotFound: there is none such.

    """
    _, device_id, name = address.split("/")
    device = find_device(site, device_id)
    for command in device.commands:
        if command.id == name:
            return device, command
    if {"use", "admin"}.isdisjoint(device.rights):
        raise NotPermitted(
            "forbidden",
            f"this token does not call commands of {site.site}/{device_id}",
            f"it takes the right use of {site.site}/{device_id}, of the token and of its person",
        )
    raise _not_found(
        "command", address, [f"{site.site}/{device.id}/{command.id}" for command in device.commands]
    )


def _not_found(kind: str, asked: str, known: Sequence[str]) -> NotFound:
    near = difflib.get_close_matches(asked, known, n=3)
    remedy = f"did you mean {' or '.join(near)}?" if near else ""
    return NotFound("unknown", f"there is no {kind} {asked!r} that this token may see", remedy)
