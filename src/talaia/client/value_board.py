"""The newest value of each channel that a script watches, and when it is not to be believed. Pure.

A value becomes stale when it is older than its signal's limit, when the gateway does not reach its
device, when the gateway is away from the hub, and when the hub is away from here. Each is told
once, with the reason; a newer value ends it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from talaia.client.values import Reading, time_of
from talaia.wire.browser import DeviceUpdate, SiteUpdate, Values
from talaia.wire.columns import unpack_columns

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from talaia.client.addresses import WatchedChannel
    from talaia.wire.browser import ToBrowser

__all__ = ["ValueBoard"]

# A signal that never goes stale has this limit, or more (s).
_NEVER_S = 1e9


@dataclass(slots=True)
class _Known:
    """What is known of a channel; ``born_s`` is when it was read, by our monotonic clock."""

    value: float | str
    time_us: int
    born_s: float
    stale: str = ""


class ValueBoard:
    """The channels of one site. Times are monotonic seconds of the caller's clock."""

    def __init__(self, site: str) -> None:
        """Begin with no channels; `change_channels` gives them."""
        self._site = site
        self._channels: Sequence[WatchedChannel] = ()
        # By channel, so that what is known outlives a new description.
        self._known: dict[str, _Known] = {}

    def change_channels(self, channels: Sequence[WatchedChannel]) -> None:
        """Watch these, in the order in which `Values` counts them."""
        self._channels = channels
        kept = {channel.channel for channel in channels}
        self._known = {name: known for name, known in self._known.items() if name in kept}

    def observe_message(self, message: ToBrowser, now_s: float) -> list[Reading]:
        """Take a message of the hub; give what a script should be told."""
        match message:
            case Values():
                return self._observe_values(message, now_s)
            case SiteUpdate(online=False) if message.site == self._site:
                why = f"its gateway is not connected{_because(message.why)}"
                return self._mark_stale(self._known, why, now_s)
            case DeviceUpdate(reached=False) if message.site == self._site:
                of_device = [
                    name for name in self._known if name.partition("/")[0] == message.device
                ]
                why = f"{message.device} is not reached{_because(message.why)}"
                return self._mark_stale(of_device, why, now_s)
            case _:
                return []

    def lose_hub(self, why: str, now_s: float) -> list[Reading]:
        """Mark everything: the hub is away."""
        return self._mark_stale(self._known, why, now_s)

    def find_overdue(self, now_s: float) -> list[Reading]:
        """Mark what has become older than its limit."""
        told = []
        for channel in self._channels:
            known, limit_s = self._known.get(channel.channel), channel.signal.max_age
            if known and not known.stale and _is_overdue(now_s - known.born_s, limit_s):
                known.stale = _too_old(limit_s)
                told.append(self._reading(channel, known, now_s))
        return told

    def due_s(self) -> float:
        """Give when `find_overdue` is to be called next; infinite: not before the next value."""
        times = [
            known.born_s + channel.signal.max_age
            for channel in self._channels
            if (known := self._known.get(channel.channel)) is not None and not known.stale
        ]
        return min(times, default=math.inf)

    def newest_readings(self, now_s: float) -> list[Reading]:
        """Give what is known of all channels, in their order."""
        self.find_overdue(now_s)
        return [
            self._reading(channel, known, now_s)
            for channel in self._channels
            if (known := self._known.get(channel.channel)) is not None
        ]

    def _observe_values(self, message: Values, now_s: float) -> list[Reading]:
        columns = unpack_columns(message)
        told = []
        for at, (number, time_us, value) in enumerate(
            zip(
                columns.channel.tolist(),
                columns.time_us.tolist(),
                columns.value.tolist(),
                strict=True,
            )
        ):
            # A hub of another description counts others; its own news of that is on its way.
            if number >= len(self._channels):
                continue
            channel = self._channels[number]
            age_s = message.age_ms[at] / 1000 if at < len(message.age_ms) else 0.0
            known = _Known(
                _value_of(channel, value, columns.texts.get(at)), time_us, now_s - max(0.0, age_s)
            )
            if _is_overdue(age_s, channel.signal.max_age):
                known.stale = _too_old(channel.signal.max_age)
            before = self._known.get(channel.channel)
            # The newest known is told again when a connection comes back.
            if message.age_ms and before is not None and before.time_us == time_us:
                repeated = before.stale == known.stale
                self._known[channel.channel] = known
                if repeated:
                    continue
            self._known[channel.channel] = known
            told.append(self._reading(channel, known, now_s))
        return told

    def _mark_stale(self, names: Iterable[str], why: str, now_s: float) -> list[Reading]:
        marked = set()
        for name in names:
            known = self._known[name]
            if not known.stale:
                known.stale = why
                marked.add(name)
        return [
            self._reading(channel, self._known[channel.channel], now_s)
            for channel in self._channels
            if channel.channel in marked
        ]

    def _reading(self, channel: WatchedChannel, known: _Known, now_s: float) -> Reading:
        return Reading(
            f"{self._site}/{channel.channel}",
            known.value,
            channel.unit,
            time_of(known.time_us),
            max(0.0, now_s - known.born_s),
            known.stale,
        )


def _value_of(channel: WatchedChannel, value: float, text: str | None) -> float | str:
    if text is not None:
        return text
    states = channel.signal.states
    # A state is a number in its list of words; one that is not in it is shown as it is.
    if channel.signal.type == "state" and value.is_integer() and 0 <= value < len(states):
        return states[int(value)]
    return value


def _is_overdue(age_s: float, limit_s: float) -> bool:
    return limit_s < _NEVER_S and age_s > limit_s


def _too_old(limit_s: float) -> str:
    return f"older than {limit_s:g} s"


def _because(why: str) -> str:
    return f": {why}" if why else ""
