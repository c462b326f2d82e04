"""Which detectors a site's description asks for, and the channels that their scores are."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.anomaly.episode_runner import score_address
from talaia.model.alarms.anomaly import DetectorKind, Watch
from talaia.model.alarms.signal_groups import GROUP_DETECTOR, groups_of
from talaia.model.site import Channel, SignalType

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.site import Site

__all__ = ["MOST_BY_DEFAULT", "Wish", "score_channels", "wanted_detectors"]

# What `services.anomaly_detection` of a site sets to work, on how many of its signals at the most:
# each takes 96 kB, and up to a hundred microseconds a second.
_BY_DEFAULT = (Watch(detector=DetectorKind.TOGETHER),)
MOST_BY_DEFAULT = 1_000
# Samples name their channel by a number of two bytes.
_MOST_CHANNELS = 65_536


class Wish(NamedTuple):
    """What watches a signal; ``thin`` where only a sample a second is looked at."""

    address: str
    unit: str
    watches: Sequence[Watch]
    thin: bool


def wanted_detectors(site: Site) -> tuple[list[Wish], int]:
    """List what is described at signals, and what `services.anomaly_detection` adds to it.

    Returns:
        The wishes, and how many signals the service leaves out since there are too many.

    """
    own, more = [], []
    for device_id, device in site.devices.items():
        for signal_id, signal in device.signals.items():
            address = f"{device_id}/{signal_id}"
            if signal.anomalies:
                own.append(Wish(address, signal.unit, signal.anomalies, thin=False))
            elif signal.primary and signal.type is SignalType.NUMBER:
                more.append(Wish(address, signal.unit, _BY_DEFAULT, thin=True))
    if site.services is None or not site.services.anomaly_detection:
        return own, 0
    return own + more[:MOST_BY_DEFAULT], max(0, len(more) - MOST_BY_DEFAULT)


def score_channels(site: Site, beside: int) -> tuple[Channel, ...]:
    """List the channels of a site's scores, as many as there are numbers for.

    Those of groups belong to no device: `sees_signal` looks at the signals of the group.

    Args:
        site: its description.
        beside: how many channels it has of its own; these come first.

    """
    found = []
    for wish in wanted_detectors(site)[0]:
        device, _, signal = wish.address.partition("/")
        for watch in wish.watches:
            address = score_address(wish.address, watch.detector_name())
            found.append(Channel(address, device, signal, "", text=False))
    for group in groups_of(site)[0]:
        address = score_address(group.address, GROUP_DETECTOR)
        found.append(Channel(address, "", group.key, "", text=False))
    return tuple(found[: max(0, _MOST_CHANNELS - beside)])
