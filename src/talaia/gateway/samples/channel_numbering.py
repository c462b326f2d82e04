"""Numbers of channels that stay the same while a gateway runs, whatever is described anew. Pure.

Adapters number their samples by it on threads of their own. What the wire carries is the place in
the channel list of the description that counts now; the batcher turns one into the other, so that
a change of the description takes place at one moment for samples of all threads.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.gateway.errors import ChannelNumbersFull
from talaia.model.site import parts_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from talaia.model.site import Signal, Site

__all__ = ["ChannelNumbering"]

# What fits the samples' column of channels.
MOST = 65_536


class ChannelNumbering:
    """Gives each signal the number of its first channel; the others follow it."""

    def __init__(self, site: Site) -> None:
        """Begin with the numbers that the channels have in the description itself."""
        self._first: dict[tuple[str, str], int] = {}
        self._size = 0
        self.add_channels(site, {})

    def add_channels(self, site: Site, renamed: Mapping[str, str]) -> None:
        """Number what is new; what is known keeps its number, also under another address.

        Args:
            site: the description.
            renamed: channels by their former addresses, see `model.renames.list_renames`.

        Raises:
            ChannelNumbersFull: there are no numbers left; nothing has changed then.

        """
        moved = {_signal_address(old): _signal_address(new) for old, new in renamed.items()}
        first = {
            (moved.get(address, address), shape): number
            for (address, shape), number in self._first.items()
        }
        size = self._size
        for address, signal in _signals_of(site):
            key = (address, _kind_of(signal))
            if key not in first:
                first[key] = size
                size += len(parts_of(signal))
        if size > MOST:
            raise ChannelNumbersFull(
                f"more than {MOST} channels have been described since the start"
            )
        self._first, self._size = first, size

    def numbers_of(self, site: Site) -> dict[str, int]:
        """Give the number of the first channel of each signal, by address."""
        return {
            address: self._first[address, _kind_of(signal)] for address, signal in _signals_of(site)
        }

    def order_of(self, site: Site) -> NDArray[np.int64]:
        """Give by number the place in `Site.channels`, -1 for what is not described (numbers,)."""
        order = np.full(self._size, -1, np.int64)
        at = 0
        for address, signal in _signals_of(site):
            first, count = self._first[address, _kind_of(signal)], len(parts_of(signal))
            order[first : first + count] = np.arange(at, at + count)
            at += count
        return order


def _signals_of(site: Site) -> list[tuple[str, Signal]]:
    return [
        (f"{device_id}/{signal_id}", signal)
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
    ]


def _signal_address(channel: str) -> str:
    return channel.partition(".")[0]


def _kind_of(signal: Signal) -> str:
    """Tell signals apart that share an address and do not hold the same kind of values."""
    return f"{signal.type} {' '.join(parts_of(signal))}"
