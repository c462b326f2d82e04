"""From one description to the next: what was renamed, and which devices it touches. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding
from talaia.model.site import parts_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Signal, Site

__all__ = ["changed_devices", "former_addresses", "former_findings", "former_of", "list_renames"]


def former_of(device: str, signal: Signal) -> str:
    """Give the address that a signal of ``device`` had before; empty if it says none."""
    return signal.was if "/" in signal.was or not signal.was else f"{device}/{signal.was}"


def list_renames(before: Site, after: Site) -> dict[str, str]:
    """Give the channels that have another address now, by their former ones.

    A signal that says what it was has taken the place of that one; and where one that said so is
    gone and the one it was is back, somebody has gone back to the description before.
    """
    had, has = _signals_by_address(before), _signals_by_address(after)
    moved: dict[str, str] = {}
    for address, signal in has.items():
        former = former_of(address.split("/", 1)[0], signal)
        # Only a name that is gone can have become one that is new.
        if former and former not in has and address not in had:
            moved[former] = address
    for address, signal in had.items():
        former = former_of(address.split("/", 1)[0], signal)
        if former and former not in had and former in has and address not in has:
            moved[address] = former
    channels: dict[str, str] = {}
    for old, new in moved.items():
        # The parts of a signal that is not described any more are those of the new one.
        for part in parts_of(has[new]):
            tail = f".{part}" if part else ""
            channels[old + tail] = new + tail
    return channels


def former_addresses(site: Site) -> dict[str, str]:
    """Give the channels that say what they were, by what they were."""
    has = _signals_by_address(site)
    channels: dict[str, str] = {}
    for address, signal in has.items():
        former = former_of(address.split("/", 1)[0], signal)
        if former and former not in has:
            for part in parts_of(signal):
                tail = f".{part}" if part else ""
                channels[former + tail] = address + tail
    return channels


def changed_devices(before: Site, after: Site) -> frozenset[str]:
    """Name the devices that are not the same in both, those of only one among them.

    A device is the same when all that is described of it and of its connection is.
    """
    # Connections of both: one that came or went changes its devices, too.
    old, new = before.links(), after.links()
    changed = {name for name in old.keys() | new.keys() if old.get(name) != new.get(name)}
    return frozenset(
        name
        for name in before.devices.keys() | after.devices.keys()
        if before.devices.get(name) != after.devices.get(name)
        or before.connection_of(name) != after.connection_of(name)
        or before.connection_of(name) in changed
    )


def former_findings(site: Site) -> Iterator[Finding]:
    """Say what cannot be meant by ``was``."""
    signals = _signals_by_address(site)
    taken: dict[str, str] = {}
    for address, signal in signals.items():
        device, _, name = address.partition("/")
        former = former_of(device, signal)
        where = f"$.devices.{device}.signals.{name}.was"
        if not former:
            continue
        if former in signals:
            yield Finding(
                where,
                f"{former} is a signal of this description itself",
                "name one that is not there any more, or leave it out",
            )
        elif former in taken:
            yield Finding(
                where,
                f"{taken[former]} says already that it was {former}",
                "only one signal can go on with a history",
            )
        # The first that says so keeps it.
        taken.setdefault(former, address)


def _signals_by_address(site: Site) -> dict[str, Signal]:
    return {
        f"{device_id}/{signal_id}": signal
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
    }
