"""Parts of a site in which anomalies that come together are one: devices, and groups that join."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.alarms.signal_groups import groups_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.site import Site

__all__ = ["cause_parts", "part_name", "watched_signals"]


def cause_parts(site: Site) -> dict[str, tuple[str, ...]]:
    """Give for each device all devices of its part, in the description's order.

    Each device is a part of its own; those whose signals a group judges together are one.
    """
    parts: dict[str, set[str]] = {device: {device} for device in site.devices}
    for group in groups_of(site)[0]:
        joined: set[str] = set()
        for address in group.signals:
            joined |= parts[address.partition("/")[0]]
        for device in joined:
            parts[device] = joined
    return {
        device: tuple(other for other in site.devices if other in parts[device])
        for device in site.devices
    }


def watched_signals(site: Site, devices: Iterable[str]) -> tuple[str, ...]:
    """Name the signals of some devices at which a detector looks, alone or in a group."""
    switch = site.services is not None and site.services.anomaly_detection
    grouped = {address for group in groups_of(site)[0] for address in group.signals}
    return tuple(
        address
        for device in devices
        for key, signal in site.devices[device].signals.items()
        for address in (f"{device}/{key}",)
        # By its word: the model's own closed lists import nothing of alarms, and it stays so.
        if signal.anomalies
        or address in grouped
        or (switch and signal.primary and signal.type == "number")
    )


def part_name(site: Site, devices: Iterable[str]) -> str:
    """Name a part as people call its devices."""
    return " and ".join(site.devices[device].name for device in devices)
