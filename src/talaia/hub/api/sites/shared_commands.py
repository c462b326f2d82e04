"""Which commands sites have in common, so that a group of them can be asked for one. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.api.missions.fleet_schemas import SharedCommandShape
from talaia.hub.api.sites.site_views import describe_command, heartbeat_commands
from talaia.hub.auth.permissions import Right

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.hub.api.schemas.common import ArgumentShape, CommandShape
    from talaia.hub.auth.permissions import Grants
    from talaia.model.site import Site

__all__ = ["list_shared_commands"]


class _Found(NamedTuple):
    site: str
    device: str
    device_name: str
    shape: CommandShape
    usable: bool


# Device and command by their ids, and each argument by id, type and unit.
_Key = tuple[str, str, tuple[tuple[str, str, str], ...]]


def list_shared_commands(sites: Iterable[Site], grants: Grants) -> list[SharedCommandShape]:
    """List the commands of ``sites``, those that most of them have first.

    Two sites share a command whose device and command have the same ids and whose arguments have
    the same ids, types and units: then the same words mean the same to both.
    """
    found: dict[_Key, list[_Found]] = {}
    for site in sites:
        for one in _commands_of(site, grants):
            found.setdefault(_key_of(one), []).append(one)
    shared = [_merge(alike) for alike in found.values() if any(one.usable for one in alike)]
    return sorted(shared, key=lambda one: (-len(one.sites), one.device, one.command.id))


def _commands_of(site: Site, grants: Grants) -> Iterator[_Found]:
    beats = heartbeat_commands(site)
    for device_id, device in site.devices.items():
        if not grants.has_right(Right.VIEW, site.site, device_id):
            continue
        usable = grants.has_right(Right.USE, site.site, device_id)
        for command_id in device.commands:
            if f"{device_id}/{command_id}" not in beats:
                shape = describe_command(site, device_id, command_id, grants)
                yield _Found(site.site, device_id, device.name, shape, usable)


def _key_of(one: _Found) -> _Key:
    arguments = tuple(
        (argument.id, argument.type.value, argument.unit) for argument in one.shape.arguments
    )
    return one.device, one.shape.id, tuple(sorted(arguments))


def _merge(alike: list[_Found]) -> SharedCommandShape:
    """Make one of the same command of several sites: what all of them take."""
    first = alike[0]
    arguments = [
        _merge_arguments([_argument_of(one, argument.id) for one in alike])
        for argument in first.shape.arguments
    ]
    shape = first.shape.model_copy(
        update={
            "arguments": arguments,
            # What one of them asks a person about is asked for all.
            "confirm": any(one.shape.confirm for one in alike),
            "cancellable": all(one.shape.cancellable for one in alike),
            "timeout": max(one.shape.timeout for one in alike),
            # Each robot's own state decides; its gateway asks the node itself.
            "needs": None,
        }
    )
    return SharedCommandShape(
        device=first.device,
        device_name=first.device_name,
        command=shape,
        sites=[one.site for one in alike if one.usable],
        barred=[one.site for one in alike if not one.usable],
    )


def _argument_of(one: _Found, name: str) -> ArgumentShape:
    # The key holds the ids of all arguments, so each of them has it.
    return next(argument for argument in one.shape.arguments if argument.id == name)


def _merge_arguments(alike: list[ArgumentShape]) -> ArgumentShape:
    """Give the narrowest limits: a value within them is within those of every site."""
    least = [argument.minimum for argument in alike if argument.minimum is not None]
    most = [argument.maximum for argument in alike if argument.maximum is not None]
    first = alike[0]
    same = all(argument.default == first.default for argument in alike)
    return first.model_copy(
        update={
            "minimum": max(least, default=None),
            "maximum": min(most, default=None),
            "max_length": min(argument.max_length for argument in alike),
            # A default of one site may be out of the limits of another.
            "default": first.default if same else None,
        }
    )
