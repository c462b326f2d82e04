"""Which sensors say that a device may lose its power, and which commands take it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.arguments import args_of
from talaia.model.interlocks.outlet import OutletCommand
from talaia.model.site import ArgumentType

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.model.interlocks.enclosure import Enclosure
    from talaia.model.site import Device, Site

__all__ = ["Need", "cutting_commands", "needs_of", "outlets_cut"]

Value = float | int | bool | str


class Need(NamedTuple):
    """A device that an enclosure needs until it is safe.

    Attributes:
        enclosure: its name in the description.
        roof: needed until the roof is closed; else until the telescope is parked.

    """

    enclosure: str
    roof: bool


def cutting_commands(device: Device, outlet: str) -> tuple[OutletCommand, ...]:
    """Give the commands that cut the power of a device's outlet."""
    written = device.outlets[outlet].cut_by
    if written:
        return written
    found = []
    command = device.commands.get(outlet)
    if command is not None:
        switches = [
            name
            for name, argument in command.arguments.items()
            if argument.type is ArgumentType.BOOLEAN
        ]
        # The switch must be all that it asks for: beside another argument it may mean anything.
        if len(switches) == len(command.arguments) == 1:
            found.append(OutletCommand(command=outlet, args={switches[0]: False}))
    if f"{outlet}_off" in device.commands:
        found.append(OutletCommand(command=f"{outlet}_off"))
    return tuple(found)


def outlets_cut(device: Device, command: str, args: Mapping[str, Value]) -> Iterator[str]:
    """Name the outlets of a device that a command with these arguments switches off."""
    described = device.commands.get(command)
    if described is None:
        return
    # With the defaults: what is sent without arguments acts by them.
    given = args_of(described, args)
    for outlet in device.outlets:
        for cut in cutting_commands(device, outlet):
            # Without arguments given, the command always cuts.
            if cut.command == command and all(
                name in given and given[name] == value for name, value in cut.args.items()
            ):
                yield outlet
                break


def needs_of(site: Site, device: str) -> Iterator[Need]:
    """List what enclosures need of a device."""
    for name, rule in site.enclosures.items():
        if device in _roof_devices(rule):
            yield Need(name, roof=True)
        # Where nothing parks the telescope nobody waits for it.
        if rule.park is not None and device in _mount_devices(rule):
            yield Need(name, roof=False)


def _roof_devices(rule: Enclosure) -> set[str]:
    # What closes the roof and what says that it is closed: both need their power.
    addresses = {rule.close.command, *(sensor.signal for sensor in (*rule.closed, *rule.moving))}
    return {address.partition("/")[0] for address in addresses}


def _mount_devices(rule: Enclosure) -> set[str]:
    addresses = {"" if rule.park is None else rule.park.command}
    if rule.parked is not None:
        addresses.add(rule.parked.signal)
    return {address.partition("/")[0] for address in addresses}
