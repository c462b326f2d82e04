"""The lists of channels that a gateway's batches are numbered by, on one link. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.hub.live.gateways.ingest import Batch
from talaia.wire.columns import renumber_channels, unpack_columns
from talaia.wire.errors import PeerError
from talaia.wire.newest import NewestSamples, newest_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.wire.columns import Columns
    from talaia.wire.frames import NewestBatch, SampleBatch

__all__ = ["ChannelMaps"]

# A peer that describes itself anew all the time must not fill the memory.
_MOST = 100


class ChannelMaps:
    """Knows every list that was told on the link, and where its channels are shown now."""

    def __init__(
        self, catalogue: str, addresses: Sequence[str], renamed: Mapping[str, str] | None = None
    ) -> None:
        """Begin with the list of the hello; ``renamed`` are former addresses of its channels."""
        # By the name of each list, the oldest first; with the addresses as they are now.
        first = tuple(addresses)
        self._lists: dict[str, tuple[str, ...]] = {catalogue: first}
        # Present addresses by former ones.
        self._renamed = dict(renamed or {})
        # What pages are shown now: it follows when a description is stored, after the lists.
        self._shown: tuple[str, ...] = first
        # For each list the place of its channels in `_shown`, or -1; made when it is needed.
        self._order: dict[tuple[str, ...], NDArray[np.int64]] = {}
        # The channels of the last batch as they came, and of how many they were found to be: most
        # gateways say the same ones again and again.
        self._last_channels = b""
        self._last_among = 0

    def add_map(self, catalogue: str, addresses: Sequence[str], renamed: Mapping[str, str]) -> None:
        """Take another list, by which batches are numbered from now on.

        What still comes by an earlier one is taken for the channels that those have become.
        """
        now = set(addresses)
        # Former addresses lead to the newest ones.
        earlier = {old: renamed.get(new, new) for old, new in self._renamed.items()}
        moved = {**earlier, **renamed}
        # An address that is used again is the new channel's.
        self._renamed = {old: new for old, new in moved.items() if old not in now}
        lists = {name: self._called_now(channels) for name, channels in self._lists.items()}
        lists.pop(catalogue, None)
        # A dict keeps the order of insertion: the oldest goes.
        while len(lists) >= _MOST:
            lists.pop(next(iter(lists)))
        self._lists = {**lists, catalogue: tuple(addresses)}
        # It was made by the former addresses.
        self._order.clear()

    def show_channels(self, addresses: tuple[str, ...]) -> None:
        """Take the channels that pages are shown now."""
        self._shown = addresses
        self._order.clear()

    def read_batch(self, message: SampleBatch) -> Batch:
        """Read a batch's columns and see that each channel is one of its list.

        Raises:
            PeerError: it is numbered by a list that the hub was not told, or out of it.

        """
        columns = unpack_columns(message)
        return Batch(message.boot, message.first, self._addresses_of(message, columns), columns)

    def read_newest(self, message: NewestBatch) -> tuple[tuple[str, ...], NewestSamples]:
        """Read the newest samples that are told, and the addresses that they are numbered by.

        Raises:
            PeerError: see `read_batch`.

        """
        told = newest_of(message)
        return self._addresses_of(message, told.columns), told

    def _addresses_of(
        self, message: SampleBatch | NewestBatch, columns: Columns
    ) -> tuple[str, ...]:
        # With its own addresses: what waited in the gateway from before.
        if message.addresses:
            addresses = self._called_now(tuple(message.addresses))
        elif message.catalogue in self._lists:
            addresses = self._lists[message.catalogue]
        else:
            raise PeerError(f"samples of the catalogue {message.catalogue!r} without its addresses")
        if message.channel == self._last_channels and len(addresses) == self._last_among:
            return addresses
        # Later the numbers index arrays, so they are checked where they come in.
        if len(columns) and int(columns.channel.max()) >= len(addresses):
            raise PeerError("a sample's channel is not in the catalogue")
        self._last_channels, self._last_among = message.channel, len(addresses)
        return addresses

    def live_columns(self, batch: Batch) -> Columns:
        """Give a batch's samples as pages are shown them, without those they are not shown yet."""
        # The same list, mostly: thousands of names need not be compared.
        if batch.addresses is self._shown or batch.addresses == self._shown:
            return batch.columns
        return renumber_channels(batch.columns, self._order_of(batch.addresses))

    def live_newest(self, addresses: tuple[str, ...], told: NewestSamples) -> NewestSamples:
        """Give newest samples by the channels that pages are shown, without the others."""
        if addresses == self._shown:
            return told
        order = self._order_of(addresses)
        shown = order[told.columns.channel] >= 0
        columns = renumber_channels(told.columns, order)
        return NewestSamples(columns, told.sequence[shown], told.age_ms[shown])

    def _order_of(self, addresses: tuple[str, ...]) -> NDArray[np.int64]:
        order = self._order.get(addresses)
        if order is None:
            place = {address: at for at, address in enumerate(self._shown)}
            order = np.array([place.get(address, -1) for address in addresses], np.int64)
            self._order[addresses] = order
        return order

    def _called_now(self, addresses: tuple[str, ...]) -> tuple[str, ...]:
        if not self._renamed:
            return addresses
        return tuple(self._renamed.get(address, address) for address in addresses)
