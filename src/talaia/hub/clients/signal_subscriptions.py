"""Which channels of a site one client wants, as few subscriptions at the hub. Pure.

Other tools subscribe to one signal at a time, and to thousands. At the hub each subscription costs
work with every batch, so they are put together: what one message asks for is one subscription, and
when these become many they are made one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.browser import Subscribe, Unsubscribe
from talaia.wire.columns import unpack_columns

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from talaia.wire.browser import Values

__all__ = ["ClientSample", "SignalSubscriptions"]

# More subscriptions than this are made one.
_MOST_GROUPS = 16


class ClientSample(NamedTuple):
    """One sample of a channel: its time (µs, UTC), its number (NaN of a text), its text if any."""

    address: str
    time_us: int
    value: float
    text: str | None


class SignalSubscriptions:
    """What a client wants of one site. Send what the methods give, in its order."""

    def __init__(self, site: str, *, every_ms: int = 0) -> None:
        """Ask for samples at most every ``every_ms``; 0: as they come."""
        # One client is at one site.
        self._site = site
        self._every_ms = every_ms
        # By the number at the hub: what was asked for, in the order that samples refer to.
        self._groups: dict[int, tuple[str, ...]] = {}
        # By address: the group that it comes with.
        self._wanted: dict[str, int] = {}
        # By address: the time of the newest sample given out (µs).
        self._last_us: dict[str, int] = {}
        self._next = 0

    @property
    def wanted(self) -> Collection[str]:
        """The addresses that are wanted now."""
        return self._wanted.keys()

    def add_addresses(self, addresses: Collection[str]) -> list[Subscribe | Unsubscribe]:
        """Want these, too; their newest values come first."""
        added = [address for address in dict.fromkeys(addresses) if address not in self._wanted]
        if not added:
            return []
        # What ends comes before what begins, so that the hub's limits hold.
        asked: list[Subscribe | Unsubscribe] = []
        if len(self._groups) >= _MOST_GROUPS:
            asked += [Unsubscribe(sub=sub) for sub in self._groups]
            added = [*self._wanted, *added]
            self._groups.clear()
        # Numbers come round long after the group that had one before is gone.
        while self._next in self._groups:
            self._next = (self._next + 1) % 65_536
        sub, self._next = self._next, (self._next + 1) % 65_536
        self._groups[sub] = tuple(added)
        self._wanted.update(dict.fromkeys(added, sub))
        asked.append(Subscribe(sub=sub, site=self._site, channels=added, every_ms=self._every_ms))
        return asked

    def remove_addresses(self, addresses: Collection[str]) -> list[Subscribe | Unsubscribe]:
        """Want these no more."""
        emptied = set()
        for address in addresses:
            sub = self._wanted.pop(address, None)
            self._last_us.pop(address, None)
            if sub is not None:
                emptied.add(sub)
        # A group that something is still wanted of stays whole.
        emptied.difference_update(self._wanted.values())
        for sub in emptied:
            del self._groups[sub]
        return [Unsubscribe(sub=sub) for sub in sorted(emptied)]

    def read_samples(self, values: Values) -> Iterator[ClientSample]:
        """Give the samples of a message that are still wanted, in their order."""
        channels = self._groups.get(values.sub)
        if channels is None:
            return
        columns = unpack_columns(values)
        # What is told with its age is the newest known, which the client may have had: when
        # subscriptions were made one, or when nothing has come since it was told.
        known = bool(values.age_ms)
        numbers, times = columns.channel.tolist(), columns.time_us.tolist()
        for at, (number, time_us, value) in enumerate(
            zip(numbers, times, columns.value.tolist(), strict=True)
        ):
            address = channels[number] if number < len(channels) else ""
            if self._wanted.get(address) != values.sub:
                continue
            if known and time_us <= self._last_us.get(address, -1):
                continue
            self._last_us[address] = time_us
            yield ClientSample(address, time_us, value, columns.texts.get(at))
