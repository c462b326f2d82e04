"""Which channels a request of the history means, and whether they are open to the person. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.anomaly.episode_runner import SCORES
from talaia.hub.auth.permissions import Right, sees_signal
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.history.sensors.sensor_views import StoredSensorKind
    from talaia.hub.live.sites import LiveSite

__all__ = ["Asked", "NoChannel", "asked_channels", "former_channel", "may_read"]

# A position's signal has no unit of its own; see `model.site.parts_of`.
_PART_UNITS = {"x": "m", "y": "m", "yaw": "rad", "lat": "°", "lon": "°", "alt": "m"}


class Asked(NamedTuple):
    """A channel that is asked for, with what its description says, or said, of it.

    Attributes:
        known: what it is, is known; otherwise only that there is history.

    """

    address: str
    unit: str = ""
    states: tuple[str, ...] = ()
    text: bool = False
    known: bool = True


class NoChannel(Exception):
    """There is no such channel, or it is not for this person, who is not told which."""

    def __init__(self, address: str) -> None:
        """Keep what was asked for."""
        super().__init__(address)
        self.address = address

    def __str__(self) -> str:
        return f"there is no channel {self.address!r}"


def asked_channels(
    live: LiveSite,
    grants: Grants,
    addresses: Iterable[str],
    stored: Callable[[str], Asked | None],
) -> list[Asked]:
    """Find channels by their addresses or by those of their signals, each once, in that order.

    ``stored`` gives what an address of a former description is, if it has history.

    Raises:
        NoChannel: for the first address that is unknown or not open to the person.

    """
    found: dict[str, Asked] = {}
    for address in addresses:
        # First as it is described now; a former channel of the same address is the same one.
        some = _described_channels(live, grants, address)
        if not some and may_read(live, grants, address):
            former = stored(address)
            some = [] if former is None else [former]
        if not some:
            raise NoChannel(address)
        # A channel that is asked for twice keeps its first place.
        found.update({channel.address: channel for channel in some})
    return list(found.values())


def former_channel(address: str, kind: StoredSensorKind | None) -> Asked:
    """Say what a channel was that the description no longer has."""
    # Stored before descriptions were kept with the history, or never described.
    if kind is None or not kind.type:
        return Asked(address, known=False)
    part = address.partition(".")[2]
    states = kind.states if kind.type == SignalType.STATE else ()
    text = kind.type == SignalType.TEXT
    return Asked(address, _PART_UNITS.get(part, kind.unit), states, text)


def may_read(live: LiveSite, grants: Grants, address: str) -> bool:
    """Tell whether a channel's history is open to a person.

    What the description no longer has is open to those who may view its device: whether it was
    public is not known any more.
    """
    site = live.description
    # Scores of a detector are open to those who may see the signal.
    address = address.partition(SCORES)[0]
    device, _, signal = address.partition("/")
    # Of a group that is described no more nobody knows the signals: it takes the whole site.
    if not device and sees_signal(grants, site, "", signal):
        return True
    for channel in live.channels:
        if channel.address == address:
            return sees_signal(grants, site, channel.device, channel.signal)
    return grants.has_right(Right.VIEW, site.site, device)


def _described_channels(live: LiveSite, grants: Grants, address: str) -> list[Asked]:
    site = live.description
    found = []
    for channel in live.channels:
        if address not in {channel.address, f"{channel.device}/{channel.signal}"}:
            continue
        # All channels of a signal are open, or none.
        if not sees_signal(grants, site, channel.device, channel.signal):
            return []
        signal = site.devices[channel.device].signals[channel.signal]
        states = signal.states if signal.type is SignalType.STATE else ()
        unit = _PART_UNITS.get(channel.part, signal.unit)
        found.append(Asked(channel.address, unit, states, channel.text))
    return found
