"""Groups of signals that are judged together: those of a description, and those of the switch."""

from __future__ import annotations

from itertools import chain, islice
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.alarms.anomaly import SignalGroup

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Site

__all__ = [
    "FEWEST_IN_GROUP",
    "GROUP_DETECTOR",
    "MOST_IN_GROUP",
    "MOST_IN_GROUPS",
    "GroupSignals",
    "group_address",
    "group_named",
    "groups_of",
]

# As pages and the history call the detector of a group.
GROUP_DETECTOR = "group"
FEWEST_IN_GROUP, MOST_IN_GROUP = 2, 64
# The only number of a device is judged against those of others, where there are any.
_FEWEST_OF_SWITCH = 1
# `services.anomaly_detection` makes groups of so many signals in all; each takes 30 kB while it
# learns.
MOST_IN_GROUPS = 1_000


class GroupSignals(NamedTuple):
    """A group of one description, its signals looked up.

    Attributes:
        key: its short name.
        group: as it is described.
        signals: addresses, in order.
        labels: what people call each of them.
        device: of which all of them are; empty where they are of several.
        states: names of the ways of running, where a state tells them.
        beside: addresses of numbers of other devices, by which those of a group of the switch are
            explained; they are not judged.

    """

    key: str
    group: SignalGroup
    signals: tuple[str, ...]
    labels: tuple[str, ...]
    device: str
    states: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()

    @property
    def is_single(self) -> bool:
        """It is the only number of its device: it is judged against the others, and by no distance.

        How far it is from what it usually is by itself, detectors of single signals say.
        """
        return len(self.signals) < FEWEST_IN_GROUP

    @property
    def name(self) -> str:
        """What people call the group."""
        return self.group.name or self.key

    @property
    def address(self) -> str:
        """Where it stands among signals."""
        return group_address(self.key)


def group_address(key: str) -> str:
    """Give the address of a group: like a signal's, without a device."""
    return f"/{key}"


def groups_of(site: Site) -> tuple[list[GroupSignals], int]:
    """List the groups of a site: those that are described, then those of the switch.

    Returns:
        The groups, and how many the switch leaves out since there are too many signals.

    """
    found = [group for key in site.anomaly_groups if (group := group_named(site, key)) is not None]
    left_out, count = 0, 0
    for device in _devices_of_switch(site):
        group = group_named(site, device)
        if group is None:
            continue
        count += len(group.signals)
        if count > MOST_IN_GROUPS:
            left_out += 1
        else:
            found.append(group)
    return found, left_out


def group_named(site: Site, key: str) -> GroupSignals | None:
    """Find one group; None where there is none of that name, or nothing to judge together."""
    group = site.anomaly_groups.get(key)
    if group is None:
        if key not in site.devices or not _is_switched_on(site):
            return None
        # A machine runs in several ways more often than not.
        group = SignalGroup(name=site.devices[key].name, device=key, modes=4)
    signals = group.signals or tuple(_numbers_of(site, group.device))
    known = [(address, site.signal(address)) for address in signals[:MOST_IN_GROUP]]
    there = [(address, signal) for address, signal in known if signal is not None]
    beside = () if key in site.anomaly_groups else _numbers_beside(site, key, len(there))
    if len(there) < (_FEWEST_OF_SWITCH if beside else FEWEST_IN_GROUP):
        return None
    devices = {address.partition("/")[0] for address, _ in there}
    labels = tuple(
        signal.name
        if len(devices) == 1
        else f"{site.devices[address.partition('/')[0]].name} {signal.name}"
        for address, signal in there
    )
    addresses = tuple(address for address, _ in there)
    state = site.signal(group.state) if group.state else None
    return GroupSignals(
        key,
        group,
        addresses,
        labels,
        devices.pop() if len(devices) == 1 else "",
        () if state is None else state.states,
        beside,
    )


def _is_switched_on(site: Site) -> bool:
    return site.services is not None and site.services.anomaly_detection


def _devices_of_switch(site: Site) -> Iterator[str]:
    """Name the devices that the switch makes a group of; one that is described takes its place."""
    if _is_switched_on(site):
        yield from (device for device in site.devices if device not in site.anomaly_groups)


def _numbers_beside(site: Site, device: str, many: int) -> tuple[str, ...]:
    """Name numbers of the other devices, up to as many as a group may have with its own."""
    others = (_numbers_of(site, other) for other in site.devices if other != device)
    return tuple(islice(chain.from_iterable(others), MOST_IN_GROUP - many))


def _numbers_of(site: Site, device: str) -> Iterator[str]:
    described = site.devices.get(device)
    for key, signal in described.signals.items() if described is not None else ():
        # By its word: the model's own closed lists import nothing of alarms, and it stays so.
        if signal.primary and signal.type == "number":
            yield f"{device}/{key}"
