"""The newest value of a channel as a broker is told it: with its time, and how good it is. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.wire.mqtt.payloads import ValueQuality

if TYPE_CHECKING:
    from talaia.hub.clients.mqtt.publication import PublishedChannel
    from talaia.hub.live.sites import LiveSite

__all__ = ["BrokerReading", "is_reached", "read_channel", "reading_mark"]


class BrokerReading(NamedTuple):
    """A value: a state as its word, where it has one."""

    value: float | str
    time_us: int
    quality: ValueQuality


def is_reached(live: LiveSite, device: str) -> bool:
    """Tell whether a site's gateway is connected and reaches a device."""
    return live.online and device not in live.current.unreached


def reading_mark(
    live: LiveSite, channel: PublishedChannel, now_ns: int
) -> tuple[int, ValueQuality] | None:
    """Give what changes whenever there is something to tell; None: nothing was heard of it yet."""
    arrived_ns = int(live.latest.arrived_ns[channel.at])
    if arrived_ns < 0:
        return None
    if not is_reached(live, channel.device):
        return arrived_ns, ValueQuality.LOST
    stale = channel.max_age and (now_ns - arrived_ns) / SECOND > channel.max_age
    return arrived_ns, ValueQuality.STALE if stale else ValueQuality.GOOD


def read_channel(live: LiveSite, channel: PublishedChannel, quality: ValueQuality) -> BrokerReading:
    """Read a channel's newest value."""
    latest = live.latest
    value: float | str
    if channel.text:
        value = latest.texts.get(channel.at, "")
    else:
        value = _word_of(float(latest.value[channel.at]), channel.states)
    return BrokerReading(value, int(latest.time_us[channel.at]), quality)


def _word_of(value: float, states: tuple[str, ...]) -> float | str:
    """Give the word of a state, where it has words."""
    # NaN compares with nothing, so it stays the number that is none.
    return states[int(value)] if states and 0 <= value < len(states) else value
